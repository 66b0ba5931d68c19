"""What is kept between processes: whole, trusted and bounded, or not at all."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from parakin.files import keeping

posix = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="files have no owners here")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "kept"
    monkeypatch.setenv(keeping.VARIABLE, str(folder))
    return folder


def entry(place: Path) -> Path:
    (path,) = place.iterdir()
    return path


def test_what_is_kept_is_found_by_its_key_alone(place: Path) -> None:
    assert keeping.find("a") is None
    keeping.keep("a", b"content")
    assert keeping.find("a") == b"content"
    assert keeping.find("b") is None
    keeping.keep("a", b"newer")
    assert keeping.find("a") == b"newer"
    entry(place)  # and nothing else is left beside it


def test_off_keeps_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keeping.keep("a", b"content")
    monkeypatch.setenv(keeping.VARIABLE, "off")
    assert keeping.folder() is None
    assert keeping.find("a") is None
    keeping.keep("b", b"content")
    entry(place)


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="other folders")
def test_the_folder_is_where_the_desktop_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(keeping.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert keeping.folder() == tmp_path / "parakin"
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for told in ("", "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", told)
        assert keeping.folder() == tmp_path / "home" / ".cache" / "parakin"


def test_what_is_damaged_is_not_found_and_is_made_anew(place: Path) -> None:
    keeping.keep("a", b"content")
    path = entry(place)
    whole = path.read_bytes()
    for at in range(len(whole)):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        assert keeping.find("a") is None
        path.write_bytes(whole[:at])
        assert keeping.find("a") is None
    keeping.keep("a", b"content")
    assert keeping.find("a") == b"content"


def test_the_entry_of_another_key_is_not_taken(place: Path) -> None:
    keeping.keep("a", b"content")
    mine = entry(place)
    keeping.keep("b", b"other")
    (theirs,) = set(place.iterdir()) - {mine}
    theirs.replace(mine)
    assert keeping.find("a") is None


@posix
@pytest.mark.parametrize("mode", [0o020, 0o002])
def test_nothing_is_taken_that_others_can_write(place: Path, mode: int) -> None:
    keeping.keep("a", b"content")
    path = entry(place)
    path.chmod(0o600 | mode)
    assert keeping.find("a") is None
    path.chmod(0o600)
    assert keeping.find("a") == b"content"
    place.chmod(0o700 | mode)
    assert keeping.find("a") is None
    keeping.keep("b", b"content")
    entry(place)  # nothing is written either
    place.chmod(0o755)
    assert keeping.find("a") == b"content"


@posix
def test_nothing_is_taken_from_another_user(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keeping.keep("a", b"content")
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert keeping.find("a") is None
    keeping.keep("b", b"content")
    entry(place)


@posix
def test_others_cannot_read_what_is_kept(place: Path) -> None:
    keeping.keep("a", b"content")
    assert place.stat().st_mode & 0o777 == 0o700
    assert entry(place).stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("what", ["a file", "within a file", "a null"])
def test_a_folder_that_cannot_be_is_none(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    place = {"a file": file, "within a file": file / "kept", "a null": tmp_path / "a\0b"}[what]
    monkeypatch.setattr(keeping, "folder", lambda: place)
    keeping.keep("a", b"content")
    assert keeping.find("a") is None
    assert file.read_text() == "mine"


def test_a_full_disk_leaves_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(os, "replace", full)
    keeping.keep("a", b"content")
    assert not list(place.iterdir())


def test_what_was_not_used_for_longest_goes_first(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping, "_LIMIT", 10_000)
    content = os.urandom(3000)
    now = time.time()
    for k, key in enumerate("abc"):
        keeping.keep(key, content)
        path = keeping._path(place, key)
        os.utime(path, (now - 1000 + k, now - 1000 + k))
    assert keeping.find("a") == content  # used again
    keeping.keep("d", content)
    assert keeping.find("b") is None
    assert [keeping.find(key) for key in "acd"] == [content] * 3
    (place / "mine").write_bytes(bytes(20_000))  # is not an entry
    keeping.keep("d", content)
    assert (place / "mine").exists()
    assert keeping.find("d") == content
