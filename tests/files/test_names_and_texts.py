"""Names of files that are not UTF-8, texts with control characters, and permissions."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest
from linkage import LINKAGE, MOTION, Refusal

import parakin
from parakin.files.writing import replacing

Parakin = Callable[..., tuple[int, str, str]]

ODD = os.fsdecode(b"b\xff")
WRITTEN = [
    *(["solve", "M", f"{ODD}.csv", "-o", f"x.{suffix}"] for suffix in ("csv", "nc", "parquet")),
    *(["plot", "M", f"{ODD}.csv", "-o", f"x.{suffix}"] for suffix in ("png", "svg", "pdf")),
    *(["film", "M", f"{ODD}.csv", "-o", f"x.{suffix}"] for suffix in ("gif", "mp4")),
    *(["draw", "M", "-o", f"x.{suffix}"] for suffix in ("svg", "pdf", "png")),
    ["report", "M", f"{ODD}.csv", "-o", "x.html"],
    *(["export", "M", f"x.{suffix}"] for suffix in ("c", "xml", "urdf")),
    ["check", "M"],
]


@pytest.mark.parametrize("command", WRITTEN, ids=" ".join)
def test_names_that_are_not_utf_8_are_written_and_read(command: list[str], here: Path) -> None:
    from linkage import in_a_process

    Path(f"{ODD}.toml").write_text(LINKAGE)
    Path(f"{ODD}.csv").write_text(
        "time,A\n" + "".join(f"{k / 10},{1.2 + 0.01 * k}\n" for k in range(9))
    )
    odd = [word.replace("M", f"{ODD}.toml").replace("x.", f"{ODD}x.") for word in command]
    code, err = in_a_process(*odd)
    assert code == (1 if command[0] == "check" else 0), err  # as the linkage is warned of
    assert "Traceback" not in err
    if command[0] != "check":
        assert Path(odd[-1]).stat().st_size


CONTROL = ["\x00", "\x01", "\x1b[31m", "\x7f", "\x85", "\uffff"]


@pytest.mark.parametrize("character", CONTROL)
@pytest.mark.parametrize("key", ["title", "source", "notes"])
def test_control_characters_are_refused_with_their_place(
    key: str, character: str, refusal: Refusal
) -> None:
    escaped = f"\\u{ord(character[0]):04x}{character[1:]}"
    Path("odd.toml").write_text(f'{key} = "a{escaped}b"\n' + LINKAGE.replace("title", "# title"))
    for command in (["check", "odd.toml"], ["draw", "odd.toml", "-o", "old.svg"]):
        message = refusal(*command)
        assert message.startswith(f"odd.toml: {key}: found 'a")
        assert message.endswith("b'; expected text without control characters")
    plain = parakin.load("five-bar").model_dump()
    with pytest.raises(parakin.InputError, match=key):
        parakin.Mechanism(**plain | {key: f"a{character}b"})


@pytest.mark.parametrize("key", ["title", "source", "notes"])
def test_ends_of_lines_and_all_other_letters_are_taken(key: str) -> None:
    plain = parakin.load("five-bar").model_dump()
    text = "a\nb\tc \u00a0 é 漢 \U0001f600"
    assert getattr(parakin.Mechanism(**plain | {key: text}), key) == text


@pytest.mark.parametrize(
    "edit",
    [
        {"symbols": {"A1": "a\0"}},
        {"motions": {"a\0": {}}},
        {"title": "\udcff"},
        {"notes": "\ud800"},
    ],
)
def test_symbols_names_of_motions_and_surrogates_too(edit: dict[str, object]) -> None:
    plain = parakin.load("five-bar").model_dump()
    with pytest.raises(parakin.InputError):
        parakin.Mechanism(**plain | edit)


def test_a_motion_and_a_result_with_such_a_text_are_refused(here: Path) -> None:
    with pytest.raises(parakin.InputError, match="motion"):
        parakin.from_laws("a\0", {"A": parakin.laws.constant(0.0)}, 1.0, 10.0)
    solver = parakin.compile("five-bar", machine_code=False)
    result = solver.solve("line").isel(time=slice(5)).assign_attrs(note="a\0b")
    for name in ("x.nc", "x.parquet", "x.csv"):
        with pytest.raises(parakin.InputError, match="attribute note"):
            parakin.save(result, name)
    assert list(here.iterdir()) == []


@pytest.mark.parametrize("name", ['a"b.c', "a\\b.c", "a\nb.c"])
def test_names_that_c_cannot_include_are_refused(name: str, here: Path) -> None:
    with pytest.raises(parakin.InputError, match="a name that C can include"):
        parakin.export("five-bar", name)


def _mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o755])
def test_a_file_that_is_replaced_keeps_its_permissions(mode: int, here: Path) -> None:
    old, link = here / "old.csv", here / "link.csv"
    old.write_text("old")
    old.chmod(mode)
    link.symlink_to("old.csv")
    with replacing(link) as temporary:
        assert _mode(temporary) & ~mode == 0
        temporary.write_text("new")
    assert (old.read_text(), _mode(old), link.is_symlink()) == ("new", mode, True)


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_a_new_file_gets_what_the_umask_leaves(mask: int, here: Path) -> None:
    before = os.umask(mask)
    try:
        with replacing(here / "new.csv") as temporary:
            temporary.write_text("new")
    finally:
        os.umask(before)
    assert _mode(here / "new.csv") == 0o666 & ~mask


@pytest.mark.parametrize("command", WRITTEN[:-1], ids=" ".join)
def test_every_command_keeps_permissions(command: list[str], run: Parakin, here: Path) -> None:
    Path("M").write_text(LINKAGE)
    Path("motion.toml").write_text(MOTION)
    name = Path(command[-1])
    name.write_text("old")
    name.chmod(0o640)
    assert run(*(w.replace(f"{ODD}.csv", "motion.toml") for w in command))[0] == 0
    assert _mode(name) == 0o640
    assert name.read_bytes() != b"old"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root writes anything")
def test_a_read_only_file_is_refused(refusal: Refusal) -> None:
    Path("old.csv").chmod(0o444)
    assert "a file that is read-only" in refusal("solve", "linkage.toml", "turn", "-o", "old.csv")
