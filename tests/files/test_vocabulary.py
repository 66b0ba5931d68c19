"""The words of a language: what is refused, where, and what is said to have been passed over."""

from __future__ import annotations

import pytest

from parakin.errors import InputError
from parakin.files.parsing import parse_xml
from parakin.files.vocabulary import check_words, language, not_used

pytest.importorskip("lxml")

SMALL = language(
    """
house (!) name
   room (*) name size
            door
      lamp (?) watts
   garden (-)
"""
)


MANY = " ".join(f"a{k}='1'" for k in range(300))


def refusal(text: str) -> str:
    with pytest.raises(InputError) as refused:
        check_words(
            parse_xml(f'<house xmlns:x="x" xmlns:xacro="y">{text}</house>', "f"), SMALL, "f"
        )
    return str(refused.value)


def test_a_language_is_read_from_its_lines() -> None:
    house = SMALL.inside["house"]
    assert house.attributes == {"name"}
    assert set(house.inside) == {"room", "garden"}
    room = house.inside["room"]
    assert room.attributes == {"name", "size", "door"}  # the line below goes on
    assert room.inside["lamp"].once
    assert not room.once
    assert house.inside["garden"].unread


def test_known_words_pass_and_what_is_unread_may_hold_anything() -> None:
    garden = '<garden x="1"><any/></garden>'
    text = f'<house name="a"><room door="b"><lamp watts="1"/></room>{garden}</house>'
    check_words(parse_xml(text, "f"), SMALL, "f")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "\n<rom/>",
            "f, line 2: found <rom> in <house>; expected one of: garden, room; did you mean",
        ),
        (
            '<room\nsiz="1"/>',
            "an attribute 'siz' of <room>; expected one of: door, name, size; did",
        ),
        ("<room><lamp/><lamp/></room>", "f, line 1: found a second <lamp>; expected one"),
        ("<room><lamp><room/></lamp></room>", "found <room> in <lamp>; expected none"),
        ("<xacro:if/>", "found <xacro:if> in <house>; expected URDF, as written by: xacro FILE"),
        ("<x:room/>", "found <x:room> in <house>; expected one of: garden, room"),
        ('<room x:name="a"/>', "found an attribute '{x}name' of <room>"),
        (f"<room {MANY}/>", "found 300 attributes; expected at most 200"),
    ],
)
def test_a_word_that_is_unknown_is_refused_with_its_line(text: str, said: str) -> None:
    assert said in refusal(text)


def test_what_is_passed_over_is_listed_once_and_without_what_is_in_it() -> None:
    root = parse_xml("<house><garden><tree/></garden><room/><garden/><fence/></house>", "f")
    said = not_used(root, lambda element: element.tag == "room")
    assert said == " Not used: <fence>, <garden>."
    assert not_used(root, lambda element: True) == ""
