"""Mechanisms from the tables of a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from parakin.errors import InputError
from parakin.files.parsing import flattened
from parakin.model.bodies import Body
from parakin.model.limbs import expand_limbs
from parakin.model.mechanism import Joint, Mechanism, Platform
from parakin.model.validation import AnyModel, validated

_COORDINATE_TABLES = ("home", "stated", "guess", "limits")


def mechanism_from_table(table: Mapping[str, Any], origin: str) -> Mechanism:
    """A mechanism from the tables of a TOML file, with joints and bodies as tables by name.

    origin: the file, for messages. Raises InputError.
    """
    data = expand_limbs(table, origin)
    for key in ("bodies", "joints"):
        if key not in data:
            raise InputError(origin, f"no table [{key}]", f"[{key}.NAME] tables")
    data["bodies"] = _listed(Body, data["bodies"], f"{origin}: bodies")
    data["joints"] = _listed(Joint, data["joints"], f"{origin}: joints")
    if "platform" in data:
        place = f"{origin}: platform"
        data["platform"] = validated(Platform, table_at(data["platform"], place), place)
    for key in _COORDINATE_TABLES:
        if key in data:
            data[key] = flattened(table_at(data[key], f"{origin}: {key}"), f"{origin}: {key}")
    if "origin" in data:
        raise InputError(origin, "unknown key 'origin'", "no such key")
    return Mechanism(**data, origin=origin)


def _listed(model: type[AnyModel], tables: object, place: str) -> tuple[AnyModel, ...]:
    """Tables by name as models that hold their names."""
    made = []
    for name, table in table_at(tables, place).items():
        inner = table_at(table, f"{place}.{name}")
        if "name" in inner:
            raise InputError(
                f"{place}.{name}", "a key 'name'", "none: the name of the table is used"
            )
        made.append(validated(model, {"name": name, **inner}, f"{place}.{name}"))
    return tuple(made)


def table_at(value: object, place: str) -> Mapping[str, Any]:
    """`value` if it is a table. Raises InputError, naming `place`, if it is not."""
    if not isinstance(value, Mapping):
        raise InputError(place, f"{value!r:.80}", "a table")
    return value
