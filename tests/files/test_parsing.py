"""Text files read within bounds: what is no text, no TOML, too large or too deep."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkage import LINKAGE, Refusal

import parakin
from parakin import InputError
from parakin.files.parsing import numbers, parse_xml


@pytest.fixture(autouse=True)
def _here(linkage_folder: Path) -> None:
    """Every test runs in the folder."""


@settings(deadline=None)
@given(st.binary(max_size=200) | st.text("[]{}=.,'\"#\n a1-", max_size=60).map(str.encode))
def test_any_bytes_are_refused_as_a_mechanism(content: bytes) -> None:
    Path("bytes.toml").write_bytes(content)
    with pytest.raises(InputError) as caught:
        parakin.load("bytes.toml")
    assert caught.value.place.startswith("bytes.toml")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "bad.toml: found an empty file; expected a file with text"),
        (b" \n\t\n", "bad.toml: found an empty file; expected a file with text"),
        (b"\xef\xbb\xbf", "bad.toml: found an empty file; expected a file with text"),
        (b"name =", "bad.toml: found a syntax error: Invalid value (at end of document); expected"),
        (b"name = 'a'\nb", "bad.toml: found a syntax error: Expected '=' after a key"),
        (bytes(range(256)), "bad.toml, byte 128: found byte 0x80, which is not UTF-8; expected a"),
        (b"\x7fELF\x02\x01\x01\x00", "bad.toml: found a syntax error"),
        (LINKAGE.encode("utf-16"), "bad.toml, byte 0: found byte 0xff, which is not UTF-8"),
        ("title = 'é'".encode("latin-1"), "bad.toml, byte 9: found byte 0xe9, which is not UTF-8"),
        (b"#" * 1_000_001, "bad.toml: found more than 1000000 bytes; expected a smaller file"),
        (b"a = " + b"[" * 5000 + b"]" * 5000, "bad.toml: found lists or tables more than 12 deep"),
        (b"a = " + b"[" * 50 + b"]" * 50, "bad.toml: found lists or tables more than 12 deep"),
        (b"[" + b".".join([b"a"] * 50) + b"]", "bad.toml: found lists or tables more than 12 deep"),
        (b"joints.a.b = 1\njoints.a.b.c = 2", "bad.toml: found a syntax error"),
    ],
)
def test_a_file_that_is_no_mechanism(content: bytes, said: str, refusal: Refusal) -> None:
    Path("bad.toml").write_bytes(content)
    assert said in refusal("check", "bad.toml")


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("flight-simulatr", "mechanism: found unknown name 'flight-simulatr'; expected a file, or"),
        ("flight-simulatr", "did you mean 'flight-simulator'?"),
        ("", "mechanism: found unknown name ''; expected a file, or one of: "),
        ("x" * 300, "mechanism: found unknown name 'xxx"),
        ("a\0b", r"mechanism: found unknown name 'a\x00b'"),
        ("a\0b.toml", "embedded null byte; expected a path"),
        ("x" * 300 + ".toml", "found file name too long; expected a readable file"),
        ("missing.toml", "missing.toml: found no such file or directory; expected a readable file"),
        ("linkage.toml/x.toml", "linkage.toml/x.toml: found not a directory; expected a readable"),
        (".", ".: found a folder; expected a file"),
        ("folder.toml", "folder.toml: found a folder; expected a file"),
        ("loop.toml", "loop.toml: found too many levels of symbolic links; expected a readable"),
        (
            "/dev/zero",
            "/dev/zero: found a special file, such as a pipe or a device",
        ),
        (
            "/dev/null",
            "/dev/null: found a special file, such as a pipe or a device",
        ),
        ("/proc/self/mem", "/proc/self/mem: found input/output error; expected a readable file"),
    ],
)
def test_a_path_that_cannot_be_read(path: str, said: str, refusal: Refusal) -> None:
    Path("folder.toml").mkdir()
    Path("loop.toml").symlink_to("loop.toml")
    assert said in refusal("check", path)


@pytest.mark.parametrize("text", ["1", "-1", "+1", "1.", ".5", "1.5e3", "1E-3", "007"])
def test_numbers_as_c_writes_them_are_read(text: str) -> None:
    assert numbers(f" {text}\n{text} ", 2, (), "f") == [float(text)] * 2


@pytest.mark.parametrize(
    "text",
    ["", "1_0", "١", "１", "0x10", "inf", "nan", "1e999", "1,5", "1d3", "1\u00a02", "e1", "."],
)
def test_what_only_python_takes_for_a_number_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="expected 1 finite number"):
        numbers(text, 1, (), "f")


def test_a_syntax_error_of_xml_has_a_line() -> None:
    pytest.importorskip("lxml")
    with pytest.raises(InputError, match="f, line 2: found a syntax error"):
        parse_xml("<a>\n<b></a>", "f")
