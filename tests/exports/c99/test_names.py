"""Names and comments that any C compiler accepts."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parakin.exports.c99.names import Names, comment, identifier


@given(st.text(max_size=20))
def test_any_text_becomes_an_identifier(text: str) -> None:
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", identifier(text))


@pytest.mark.parametrize(
    ("text", "made"), [("B1.2", "B1_2"), ("9 lives", "m9_lives"), ("_x", "m_x"), ("é", "m_")]
)
def test_what_is_fit_is_kept(text: str, made: str) -> None:
    assert identifier(text) == made


@given(st.text("*/ a", max_size=20))
def test_no_comment_ends_early_and_none_begins_in_another(text: str) -> None:
    assert "*/" not in comment(text)
    assert "/*" not in comment(text)


def test_functions_and_constants_are_named_after_the_file() -> None:
    names = Names("my-kernel")
    assert (names.stem, names.prefix, names.constant) == ("my-kernel", "my_kernel", "MY_KERNEL")
