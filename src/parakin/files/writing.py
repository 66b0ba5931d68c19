"""Files written whole or not at all, and checked before anything is computed for them."""

from __future__ import annotations

import importlib.util
import io
import os
import secrets
import stat
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parakin.errors import InputError, nearest, not_installed, reason

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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

    Links are followed. A file that is replaced keeps its permissions and, where the system allows
    it, its owner. Raises InputError if `path` cannot be written.
    """
    target = _target(path)
    with _as_input_error(path):
        old = target.stat() if target.exists() else None
        name = f".{target.stem[:100]}-{secrets.token_hex(4)}{target.suffix}"
        temporary = target.with_name(name)
        try:
            # As the umask has it, or for nobody else before it has the old file's permissions.
            mode = 0o666 if old is None else 0o600
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode))
            yield temporary
            if old is not None:
                _keep(temporary, old)
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)


def _keep(path: Path, old: os.stat_result) -> None:
    """Give a file the owner and the permissions of another."""
    made = path.stat()
    if hasattr(os, "chown") and (made.st_uid, made.st_gid) != (old.st_uid, old.st_gid):
        with suppress(OSError):  # only root may give files away
            os.chown(path, old.st_uid, old.st_gid)
    path.chmod(stat.S_IMODE(old.st_mode))


def write_figure(figure: Figure, path: Path, **options: Any) -> None:
    """Write a figure in the format of its suffix, at 200 dots per inch where it has dots.

    Drawn in memory, as the PDFs of matplotlib hide that a disk is full. Raises InputError.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format=path.suffix.lower()[1:], dpi=200, **options)
    with replacing(path) as temporary:
        temporary.write_bytes(drawn.getbuffer())


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
            if target.exists() and not os.access(target, os.W_OK):
                raise InputError(str(path), "a file that is read-only", "a file to write")
            return target
    except (ValueError, RuntimeError) as error:  # a null character, a loop of links
        raise InputError(repr(str(path)), str(error), "a path") from None
