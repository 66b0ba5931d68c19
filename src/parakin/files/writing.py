"""Files written whole or not at all, and checked before anything is computed for them."""

from __future__ import annotations

import importlib.util
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from parakin.errors import InputError, nearest, not_installed, reason


def check_suffix(path: Path, suffixes: Sequence[str], needs: Mapping[str, str], extra: str) -> None:
    """Raises InputError if the suffix is none of these, or a module it needs is missing.

    needs: names of libraries by module. extra: the one of parakin's that installs them.
    """
    if path.suffix.lower() not in suffixes:
        found = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise InputError(str(path), found, nearest(path.suffix, suffixes))
    for module, library in needs.items():
        if importlib.util.find_spec(module) is None:
            raise not_installed(str(path), library, extra)


def check_writable(path: Path) -> None:
    """Raises InputError if `path` cannot be written."""
    target = _target(path)
    with _as_input_error(path), tempfile.TemporaryFile(dir=target.parent):
        pass


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path in the same folder, moved to `path` at the end; removed if anything fails.

    Links are followed. Raises InputError if `path` cannot be written.
    """
    target = _target(path)
    with _as_input_error(path):
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem[:100]}-", suffix=target.suffix
        )
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o666 & ~mask)
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)


@contextmanager
def _as_input_error(path: Path) -> Iterator[None]:
    """Turns an OSError into an InputError about `path`."""
    try:
        yield
    except OSError as error:
        raise InputError(str(path), reason(error), "a file that can be written") from None


def _target(path: Path) -> Path:
    """The file that `path` leads to, links followed. Raises InputError if it is not a file."""
    try:
        with _as_input_error(path):
            target = path.resolve()
            if target.is_dir():
                raise InputError(str(path), "a folder", "a file to write")
            if target.exists() and not target.is_file():
                raise InputError(str(path), "a special file, such as a device", "a file to write")
            return target
    except (ValueError, RuntimeError) as error:  # a null character, a loop of links
        raise InputError(repr(str(path)), str(error), "a path") from None
