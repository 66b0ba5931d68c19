"""The words of an XML language: which elements may stand where, with which attributes.

A word that is unknown is refused, since what it was meant to say would be lost. A language is
written as lines, each an element and its attributes, indented by what it stands in; MuJoCo prints
its own in this form.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from parakin.errors import InputError, nearest

if TYPE_CHECKING:
    from lxml.etree import _Element

_LISTED = 10  # names in a sentence
_MAX_ATTRIBUTES = 200  # of one element: lxml takes quadratic time to list them
_LINE = re.compile(r"( *)([\w():]+) \((.)\)(.*)")


@dataclass
class Word:
    """An element: its attributes, and the elements in it by name. once: not twice in another.
    unread: its attributes and what is in it are not looked at.
    """

    attributes: frozenset[str] = frozenset()
    inside: dict[str, Word] = field(default_factory=dict)
    once: bool = False
    unread: bool = False


def language(text: str) -> Word:
    """What `text` says stands in a document: lines `element (mark) attributes`, indented.

    Marks: `?` for at most once, `-` for unread, others for any number. A line without a mark has
    more attributes of the element above it.
    """
    top = Word()
    above: list[tuple[int, Word]] = [(-1, top)]
    for line in text.splitlines():
        found = _LINE.match(line)
        if found is None:
            above[-1][1].attributes |= set(line.split())
            continue
        indent, name, mark, rest = len(found[1]), found[2], found[3], found[4]
        while above[-1][0] >= indent:
            above.pop()
        word = Word(frozenset(rest.split()), once=mark == "?", unread=mark == "-")
        above[-1][1].inside[name] = word
        above.append((indent, word))
    return top


def check_words(root: _Element, top: Word, origin: str) -> None:
    """Raises InputError on the first element or attribute that the language does not have.

    origin: the file, for messages.
    """
    word = top.inside[str(root.tag)]
    _check_attributes(root, word, origin)
    for element, within in _children(root, word, origin):
        _check_attributes(element, within, origin)


def _children(parent: _Element, word: Word, origin: str) -> Iterator[tuple[_Element, Word]]:
    """All elements that are read below `parent`, in the file's order, each with its word."""
    seen: set[str] = set()
    for element in parent:
        name = written(element)
        if name not in word.inside:
            raise _unknown(element, f"<{name}> in <{parent.tag}>", name, word.inside, origin)
        inner = word.inside[name]
        if inner.once and name in seen:
            raise InputError(line_of(element, origin), f"a second <{name}>", "one")
        seen.add(name)
        if not inner.unread:
            yield element, inner
            yield from _children(element, inner, origin)


def _check_attributes(element: _Element, word: Word, origin: str) -> None:
    count = len(element.attrib)
    if count > _MAX_ATTRIBUTES:
        place = line_of(element, origin)
        raise InputError(place, f"{count} attributes", f"at most {_MAX_ATTRIBUTES}")
    for key in element.attrib:
        if str(key) not in word.attributes:
            found = f"an attribute {str(key)!r} of <{element.tag}>"
            raise _unknown(element, found, str(key), word.attributes, origin)


def _unknown(
    element: _Element, found: str, name: str, known: dict[str, Word] | frozenset[str], origin: str
) -> InputError:
    expected = nearest(name, known) if known else "none"
    if name.startswith("xacro:"):
        expected = "URDF, as written by: xacro FILE"
    return InputError(line_of(element, origin), found, expected)


def written(element: _Element) -> str:
    """An element's name as in the file, prefix included."""
    local = str(element.tag).rpartition("}")[2]
    return f"{element.prefix}:{local}" if element.prefix else str(element.tag)


def line_of(element: _Element, origin: str) -> str:
    """An element's place, for messages."""
    return f"{origin}, line {element.sourceline}"


def line_number(element: _Element) -> int:
    """The line of the file on which an element stands; 0 if it is not known."""
    line = element.sourceline
    return line if isinstance(line, int) else 0


def not_used(root: _Element, used: Callable[[_Element], bool]) -> str:
    """A sentence that lists the elements that were passed over, for the user; "" if none were.

    used: whether an element is read; those inside another that is not are not listed.
    """
    found: set[str] = set()
    waiting = [root]
    while waiting:
        for element in waiting.pop():
            if used(element):
                waiting.append(element)
            else:
                found.add(f"<{written(element)}>")
    return f" Not used: {', '.join(sorted(found))}." if found else ""


def unused(name: str, taken: Container[str]) -> str:
    """`name`, with primes if others have it."""
    while name in taken:
        name += "'"
    return name


def listed(what: str, names: Sequence[str]) -> str:
    """A sentence for notes, "what: names", the first ones of many; "" if there are no names."""
    if not names:
        return ""
    return f" {what}: {', '.join(names[:_LISTED])}{', ...' if len(names) > _LISTED else '.'}"
