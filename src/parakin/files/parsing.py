"""Text, TOML, YAML and XML, parsed within bounds: file size, nesting, length of numbers."""

from __future__ import annotations

import math
import re
import stat
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parakin.errors import InputError, not_installed, reason

if TYPE_CHECKING:
    from lxml.etree import _Element

MAX_BYTES = 1_000_000  # of a text file
_MAX_DEPTH = 12
_MAX_DIGITS = 1000
_MAX_BITS = 10_000  # of whole numbers; Python can format some 14,000 for a message
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")  # as C reads one
_YAML_NUMBER = re.compile(r"[+-]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_YAML_NONE = re.compile(r"[+-]?\.(?:inf|nan)", re.IGNORECASE)  # refused where numbers are used
_TOML_TEXT = re.compile(r"""\"(?:[^"\\\n]|\\.)*+"?|'[^'\n]*+'?""")
_LONG_KEY = re.compile(r"(?:\.[ \t]*[\w-]++[ \t]*+){100}")  # a.b.c...: tomllib takes quadratic time
_TOO_DEEP = (f"lists or tables more than {_MAX_DEPTH} deep", f"at most {_MAX_DEPTH} levels")


def read_text(path: Path) -> str:
    """The text of a small UTF-8 file. Raises InputError if it is missing, too large or not text."""
    data = read_bytes(path, MAX_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = f"byte 0x{data[error.start]:02x}, which is not UTF-8"
        raise InputError(f"{path}, byte {error.start}", found, "a text file in UTF-8") from None
    if not text.strip():
        raise InputError(str(path), "an empty file", "a file with text")
    return text


def read_bytes(path: Path, most: int) -> bytes:
    """The bytes of a file. Raises InputError if it is missing, is none (a pipe might never end), or
    has more than `most`.
    """
    try:
        if path.is_dir():
            raise InputError(str(path), "a folder", "a file")
        if not stat.S_ISREG(path.stat().st_mode):
            raise InputError(str(path), "a special file, such as a pipe or a device", "a file")
        with path.open("rb") as file:
            data = file.read(most + 1)
    except OSError as error:
        raise InputError(str(path), reason(error), "a readable file") from None
    except ValueError as error:  # a null byte in the path
        raise InputError(repr(str(path)), str(error), "a path") from None
    if len(data) > most:
        raise InputError(str(path), f"more than {most} bytes", "a smaller file")
    return data


def parse_toml(text: str, origin: str) -> dict[str, Any]:
    """TOML as nested tables. origin: the file, for messages. Raises InputError."""
    if _LONG_KEY.search(_TOML_TEXT.sub("text", text)):
        raise InputError(origin, *_TOO_DEEP)
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(origin, f"a syntax error: {error}", "TOML") from None
    except RecursionError:
        raise InputError(origin, *_TOO_DEEP) from None
    except (ValueError, OverflowError) as error:
        raise InputError(origin, f"a value that cannot be read: {error}", "TOML") from None
    _check_values(table, origin)
    return table


def flattened(
    table: Mapping[str, Any], place: str, nested: Callable[[Mapping[str, Any]], bool] = bool
) -> dict[str, Any]:
    """Nested tables as one with dotted keys: TOML reads `platform.x = 1` as x inside platform.

    nested: which tables are parts of names rather than values; by default, all but empty ones.
    Raises InputError on a name that is given twice.
    """
    flat: dict[str, Any] = {}
    for key, value in table.items():
        inner = {key: value}
        if isinstance(value, Mapping) and nested(value):
            below = flattened(value, f"{place}.{key}", nested)
            inner = {f"{key}.{name}": item for name, item in below.items()}
        for name, item in inner.items():
            if name in flat:
                raise InputError(f"{place}.{name}", "two values", "one")
            flat[name] = item
    return flat


def parse_yaml(text: str, origin: str) -> dict[str, Any]:
    """YAML as nested tables, without references. origin: the file, for messages.

    Raises InputError.
    """
    try:
        import yaml
    except ImportError:
        raise not_installed(origin, "PyYAML") from None

    try:
        depth = 0  # checked first, as deep nesting would overflow libyaml's own stack
        for event in yaml.parse(text, yaml.CSafeLoader):
            if isinstance(event, yaml.AliasEvent):
                raise InputError(origin, "a reference (*name)", "values written out")
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > _MAX_DEPTH:
                raise InputError(origin, *_TOO_DEEP)
        loader = yaml.CSafeLoader(text)
        node = loader.get_single_node()
        _check_nodes(node, origin)
        table = None if node is None else loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        if "nesting" in (error.problem or ""):  # newer versions of PyYAML check it themselves
            raise InputError(origin, *_TOO_DEEP) from None
        mark = error.problem_mark
        line = "" if mark is None else f", line {mark.line + 1}"
        raise InputError(f"{origin}{line}", f"a syntax error: {error.problem}", "YAML") from None
    except yaml.YAMLError as error:
        raise InputError(origin, f"a syntax error: {error}", "YAML") from None
    except (RecursionError, ValueError, OverflowError, TypeError) as error:
        raise InputError(origin, f"a value that cannot be read: {error}", "YAML") from None
    _check_values(table, origin)
    if not isinstance(table, dict):
        raise InputError(origin, f"{table!r:.80}", "a table of loops")
    return table


def _check_nodes(node: Any, origin: str) -> None:
    """Raises InputError on repeated keys, since YAML keeps only the last, on numbers that take
    long to read, and on those that are not plain decimals: to YAML `010` is 8, and `1:30` is 90.
    """
    waiting = [] if node is None else [node]
    while waiting:
        node = waiting.pop()
        value = node.value
        if isinstance(value, str):
            if node.tag.endswith((":int", ":float")):
                _check_yaml_number(value, f"{origin}, line {node.start_mark.line + 1}")
            continue
        seen: set[str] = set()
        for item in value:
            if not isinstance(item, tuple):
                waiting.append(item)
                continue
            waiting += item
            key = item[0].value if isinstance(item[0].value, str) else ""
            if key in seen:
                place = f"{origin}, line {item[0].start_mark.line + 1}"
                raise InputError(place, f"{key!r:.80} twice", "one value")
            seen |= {key} if key else set()


def _check_yaml_number(text: str, place: str) -> None:
    if len(text) > _MAX_DIGITS:
        raise InputError(place, f"a number of {len(text)} characters", "a shorter one")
    if not (_YAML_NUMBER.fullmatch(text) or _YAML_NONE.fullmatch(text)):
        raise InputError(place, f"{text!r:.80}", "a plain decimal number")


def _check_values(table: object, origin: str) -> None:
    """Raises InputError on tables nested too deep, and on numbers too long for a message."""
    level, depth = [table], 0
    while level:
        depth += 1
        if depth > _MAX_DEPTH:
            raise InputError(origin, *_TOO_DEEP)
        inside: list[object] = []
        for item in level:
            if isinstance(item, dict):
                inside += [*item.keys(), *item.values()]
            elif isinstance(item, (list, tuple, set)):
                inside += item
            elif isinstance(item, int) and item.bit_length() > _MAX_BITS:
                found = f"a whole number of {item.bit_length()} bits"
                raise InputError(origin, found, f"at most {_MAX_BITS}")
        level = inside


def parse_xml(text: str, origin: str) -> _Element:
    """The root of an XML document without entities. origin: the file, for messages.

    Raises InputError.
    """
    try:
        from lxml import etree
    except ImportError:
        raise not_installed(origin, "lxml") from None
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(origin, "a document type or entities", "plain XML")
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError as error:
        place = f"{origin}, line {error.lineno}" if error.lineno else origin
        raise InputError(place, f"a syntax error: {error.msg}", "XML") from None


def numbers(text: str | None, count: int, default: Sequence[float], place: str) -> list[float]:
    """The numbers in an attribute, or `default` if it is missing. Raises InputError unless there
    are `count` finite ones, written as C reads them.
    """
    if text is None:
        return list(default)
    values = [number(word) for word in text.split()] if text.isascii() else []
    if len(values) != count or not all(abs(a) < 1e100 for a in values):
        expected = f"{count} finite number{'s'[: count > 1]}"
        raise InputError(place, f"{text!r:.80}", expected)
    return values


def number(word: str) -> float:
    """A number as C writes it; NaN for anything else that Python takes for one (1_0, ١, inf)."""
    return float(word) if NUMBER.fullmatch(word) else math.nan
