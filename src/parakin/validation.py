"""Tables from outside checked by pydantic, its findings told as one InputError."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from parakin.errors import InputError, nearest

AnyModel = TypeVar("AnyModel", bound=BaseModel)
_EXPECTED = (
    {"float_type": "a number", "int_type": "a number", "string_type": "text"}
    | {"list_type": "a list", "tuple_type": "a list", "extra_forbidden": "no such key"}
    | dict.fromkeys(("dict_type", "mapping_type", "model_type", "model_attributes_type"), "a table")
)
_SCALARS = ("int", "float", "str")


class Table(BaseModel):
    """A table that has the declared keys and no others, its values of the declared types."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _keys(cls, data: Any) -> Any:
        # Before pydantic looks at the values: a misspelt key would also be reported missing.
        keys = {f.alias or name: f.is_required() for name, f in cls.model_fields.items()}
        given = data if isinstance(data, Mapping) else keys
        if unknown := [key for key in given if key not in keys]:
            raise _finding(f"key {unknown[0]!r}", nearest(str(unknown[0]), keys))
        required = [key for key, needed in keys.items() if needed]
        if missing := [key for key in required if key not in given]:
            raise _finding(f"no key {missing[0]!r}", f"the keys {', '.join(required)}")
        return data


def _finding(found: str, expected: str) -> PydanticCustomError:
    return PydanticCustomError("keys", "{expected}", {"found": found, "expected": expected})


def validated(model: type[AnyModel], data: object, place: str) -> AnyModel:
    """`data` as a `model`; InputError naming the place, below `place`, where it is none."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise input_error(error, place, data) from None


def input_error(error: ValidationError, place: str, data: object = None) -> InputError:
    """The first finding in `error`, which came of validating `data`, the table at `place`.

    Keys are named with what exists where the model is a `Table`. A ValueError raised in a
    validator should say, as its message, what was expected. Without `data`, the place may hold
    names that pydantic gives to the members of a union of tables.
    """
    findings = [(_where(e["loc"], place, data), e) for e in error.errors(include_url=False)]
    where, first = findings[0]
    found, context = first["input"], first.get("ctx", {})
    if first["type"] == "keys":
        return InputError(where, context["found"], context["expected"])
    if first["type"].startswith("union_tag"):
        key = context["discriminator"].strip("'")
        if key not in found:
            return InputError(where, f"no key {key!r}", f"the key {key}")
        tags = [tag.strip("' ") for tag in context["expected_tags"].split(",")]
        return InputError(f"{where}.{key}", repr(found[key]), nearest(str(found[key]), tags))
    # The alternatives of a union are reported one by one, all at the same place.
    texts = [_EXPECTED.get(e["type"], e["msg"]) for at, e in findings if at == where]
    expected = " or ".join(dict.fromkeys(texts)).replace("Input should be ", "")
    shown = repr(found) if len(repr(found)) <= 80 else f"{repr(found)[:77]}..."
    return InputError(where, shown, expected.replace("Value error, ", ""))


def _where(loc: tuple[int | str, ...], place: str, data: Any) -> str:
    """`loc` as the user would write it, without the names pydantic gives to unions' members."""
    for part in loc:
        if isinstance(part, int):
            place += f"[{part}]"
        elif part in data if isinstance(data, Mapping) else data is None and part not in _SCALARS:
            place += f".{part}"
        else:
            continue
        data = None if data is None else data[part]
    return place
