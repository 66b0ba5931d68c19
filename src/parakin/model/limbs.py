"""Limbs that repeat: written once in a file, and expanded here one by one.

A table `[limbs.NAME]` holds `count` and tables like those at the top of a file. `{i}` in their
keys and texts stands for the limb's number, 1 to count, and so does `i` in expressions, where
every name in `each` stands for that limb's value in its list.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from parakin.errors import InputError
from parakin.model.expressions import Value
from parakin.model.validation import Table, validated

MAX_LIMBS = 1000
_MAX_TEXT = 1_000_000  # characters when expanded, as many as a file may have
# Texts that are names, never expressions; `at` is one of a force, and expressions of a frame.
_PLAIN = ("kind", "parent", "child", "file", "at", "between", "axes", "csv", "law")


class _Limb(Table):
    count: int
    each: Mapping[str, list[Value]] = {}
    bodies: Mapping[str, Any] = {}
    joints: Mapping[str, Any] = {}
    home: Mapping[str, Any] = {}
    stated: Mapping[str, Any] = {}
    guess: Mapping[str, Any] = {}
    limits: Mapping[str, Any] = {}
    forces: Mapping[str, Any] = {}
    symbols: Mapping[str, Any] = {}


def expand_limbs(table: Mapping[str, Any], origin: str) -> dict[str, Any]:
    """The tables of a file with its `[limbs]` expanded limb by limb.

    origin: the file, for messages. Raises InputError on limbs of the wrong form, lists of the
    wrong length, and repeated names.
    """
    result = {key: value for key, value in table.items() if key != "limbs"}
    limbs = table.get("limbs", {})
    if not isinstance(limbs, Mapping):
        raise InputError(f"{origin}: limbs", repr(limbs)[:80], "[limbs.NAME] tables")
    left = _MAX_TEXT
    for name, data in limbs.items():
        place = f"{origin}: limbs.{name}"
        limb = validated(_Limb, data, place)
        if not 1 <= limb.count <= MAX_LIMBS:
            raise InputError(f"{place}.count", str(limb.count), f"1 to {MAX_LIMBS}")
        left -= limb.count * _size(data)
        if left < 0:
            found = f"{limb.count} limbs of {_size(data)} characters"
            raise InputError(place, found, f"at most {_MAX_TEXT} characters in all limbs")
        for key, values in limb.each.items():
            if not key.isidentifier():
                raise InputError(
                    f"{place}.each", f"the name {key!r}", "a name that expressions can use"
                )
            if len(values) != limb.count:
                raise InputError(
                    f"{place}.each.{key}", f"{len(values)} values", f"a list of {limb.count}"
                )
        for number in range(1, limb.count + 1):
            _add(result, limb, str(name), number, place)
    return result


def _size(data: Mapping[str, Any]) -> int:
    """Characters of one limb, without `each`, from which it takes one value per list."""
    return len(repr({key: value for key, value in data.items() if key != "each"}))


def _add(result: dict[str, Any], limb: _Limb, name: str, number: int, place: str) -> None:
    stem = re.sub(r"\W", "_", name, flags=re.ASCII)
    own = {key: f"{stem}{number}_{key}" for key in limb.each}
    values = {
        own[key]: _numbered(values[number - 1], number, own) for key, values in limb.each.items()
    }
    _merge(result, "parameters", values, place)
    for key in ("bodies", "joints", "home", "stated", "guess", "limits", "forces", "symbols"):
        _merge(result, key, _numbered(getattr(limb, key), number, own), place)


def _merge(result: dict[str, Any], key: str, more: Mapping[str, Any], place: str) -> None:
    if not more:
        return
    known = result.get(key, {})
    if not isinstance(known, Mapping):
        raise InputError(f"{place.partition(': ')[0]}: {key}", repr(known)[:80], "a table")
    for name in more:
        if name in known:
            raise InputError(f"{place}: {key}", f"{name!r} twice", "names with {i} in them")
    result[key] = {**known, **more}


def _is_plain(key: str, value: object) -> bool:
    return key in _PLAIN and (key != "at" or isinstance(value, str))


def _numbered(value: Any, number: int, own: Mapping[str, str], *, plain: bool = False) -> Any:
    if isinstance(value, Mapping):
        return {
            str(key).replace("{i}", str(number)): (
                _turns(inner, number, own)
                if key == "turns"
                else _numbered(inner, number, own, plain=_is_plain(key, inner))
            )
            for key, inner in value.items()
        }
    if isinstance(value, list):
        return [_numbered(inner, number, own, plain=plain) for inner in value]
    if not isinstance(value, str):
        return value
    text = value.replace("{i}", str(number))
    if plain:
        return text
    names = "|".join(map(re.escape, [*own, "i"]))
    return re.sub(rf"(?<![\w.])({names})(?!\w)", lambda m: own.get(m[1], f"({number})"), text)


def _turns(value: Any, number: int, own: Mapping[str, str]) -> Any:
    """Turns of a frame: their first letters are axes, even if `each` has a name x."""
    if not isinstance(value, list):
        return value
    return [
        [*turn[:1], *_numbered(turn[1:], number, own)] if isinstance(turn, list) else turn
        for turn in value
    ]
