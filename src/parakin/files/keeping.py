"""What takes long to make, kept in a folder of the user's from one process to the next.

An entry is found by all that it depends on, as text. It is written whole or not at all, and ignored
unless it is whole, of this very text, and of a file and a folder that only the user can write:
what is kept may be code. Whatever goes wrong, there is no entry, and it is made again.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
import zlib
from contextlib import suppress
from pathlib import Path

VARIABLE = "PARAKIN_CACHE"  # "off", or another folder
_LIMIT = 200_000_000  # bytes of all entries; those not used for longest go first
_MAGIC = b"parakin 1\n"
_DIGEST = hashlib.sha256().digest_size
_SUFFIX, _UNFINISHED = ".kept", ".part"
_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def folder() -> Path | None:
    """Where entries are; None if nothing is to be kept."""
    told = os.environ.get(VARIABLE, "").strip()
    if told.lower() == "off":
        return None
    if told:
        return Path(os.path.expanduser(told))
    try:
        home = Path.home()
    except RuntimeError:  # nobody's
        return None
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "parakin"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "parakin"
    told = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(told) if os.path.isabs(told) else home / ".cache") / "parakin"


def find(key: str) -> bytes | None:
    """What is kept under a key; None if nothing is, or it cannot be trusted."""
    place = folder()
    if place is None:
        return None
    path = _path(place, key)
    try:
        if not _only_ours(place.stat()):
            return None
        with path.open("rb") as stream:
            status = os.fstat(stream.fileno())
            if not _only_ours(status) or not stat.S_ISREG(status.st_mode):
                return None
            content = stream.read()
        found = _unpacked(content, key)
        if found is not None:
            with suppress(OSError):  # of a folder that can only be read
                os.utime(path)
        return found
    except (OSError, ValueError):  # ValueError: a null character in the folder's name
        return None


def keep(key: str, content: bytes) -> None:
    """Keep something under a key, if it can be."""
    place = folder()
    if place is None:
        return
    name = key.encode()
    rest = len(name).to_bytes(8, "little") + name + zlib.compress(content, 1)
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _only_ours(place.stat()):
            return
        number, made = tempfile.mkstemp(_UNFINISHED, dir=place)
        try:
            with os.fdopen(number, "wb") as stream:
                stream.write(_MAGIC + hashlib.sha256(rest).digest() + rest)
            os.replace(made, _path(place, key))
        finally:
            with suppress(OSError):
                os.unlink(made)
        _prune(place)
    except (OSError, ValueError):
        return


def _path(place: Path, key: str) -> Path:
    return place / (hashlib.sha256(key.encode()).hexdigest() + _SUFFIX)


def _only_ours(status: os.stat_result) -> bool:
    """Whether a file or folder is the user's own, and nobody else may write it. On Windows what is
    in a profile is the user's.
    """
    if not hasattr(os, "geteuid"):
        return True
    return status.st_uid == os.geteuid() and not status.st_mode & _OTHERS


def _unpacked(content: bytes, key: str) -> bytes | None:
    """What an entry holds, if it is whole and of this key."""
    start = len(_MAGIC) + _DIGEST
    rest, name = content[start:], key.encode()
    if content[:start] != _MAGIC + hashlib.sha256(rest).digest():
        return None
    if rest[: 8 + len(name)] != len(name).to_bytes(8, "little") + name:
        return None
    try:
        return zlib.decompress(rest[8 + len(name) :])
    except zlib.error:
        return None


def _prune(place: Path) -> None:
    """Remove entries that were not used for longest, until the rest is small enough."""
    entries: list[tuple[float, int, str]] = []
    with os.scandir(place) as found:
        for each in found:
            if each.name.endswith((_SUFFIX, _UNFINISHED)):
                with suppress(OSError):  # another process may have removed it
                    status = each.stat(follow_symlinks=False)
                    entries.append((status.st_mtime, status.st_size, each.path))
    total = sum(size for _, size, _ in entries)
    for _, size, path in sorted(entries):
        if total <= _LIMIT:
            return
        with suppress(OSError):
            os.unlink(path)
        total -= size
