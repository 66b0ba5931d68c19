"""Tables from outside checked by pydantic, its findings told as one InputError."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from parakin.errors import InputError, nearest

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

AnyModel = TypeVar("AnyModel", bound=BaseModel)
_EXPECTED = (
    {"float_type": "a number", "int_type": "a whole number", "string_type": "text"}
    | {"list_type": "a list", "tuple_type": "a list", "bool_type": "true or false"}
    | dict.fromkeys(("dict_type", "mapping_type", "model_type", "model_attributes_type"), "a table")
)
_SCALARS = ("int", "float", "str")


class _RaisesInputError(ModelMetaclass):
    """Makes models whose construction in Python fails with an InputError too."""

    def __call__(self, /, **data: Any) -> Any:
        try:
            return super().__call__(**data)
        except ValidationError as error:
            place = " ".join(str(part) for part in (self.__name__, data.get("name")) if part)
            raise input_error(error, f"{place}:", data) from None


class Table(BaseModel, metaclass=_RaisesInputError):
    """A table that has the declared keys and no others, its values of the declared types.

    Raises InputError where it has not.
    """

    set_by_reader: ClassVar[frozenset[str]] = frozenset()  # keys that a file leaves to its reader

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _keys(cls, data: Any) -> Any:
        # Before pydantic looks at the values: a misspelt key would also be reported missing.
        keys = {f.alias or name: f.is_required() for name, f in cls.model_fields.items()}
        given = data if isinstance(data, Mapping) else keys
        if unknown := [key for key in given if key not in keys]:
            known = [key for key in keys if key not in cls.set_by_reader or key not in given]
            raise _finding(f"unknown key {unknown[0]!r}", nearest(str(unknown[0]), known))
        missing = [key for key, needed in keys.items() if needed and key not in given]
        if missing:
            what = "a value" if len(missing) == 1 else "values"
            raise _finding(f"no key {missing[0]!r}", f"{what} for {', '.join(missing)}")
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

    A `place` that ends in a colon is a file, or a whole, that places follow. Keys are named with
    what exists where the model is a `Table`. A ValueError raised in a validator should say, as
    its message, what was expected. Without `data`, the place may hold names that pydantic gives
    to the members of a union of tables.
    """
    errors = error.errors(include_url=False)
    findings = [(_where(e["loc"], place, data), e) for e in errors]
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
    if first["type"] == "literal_error":
        names = re.findall(r"'([^']*)'", context["expected"])
        return InputError(where, _shown(found), nearest(str(found), names))
    if first["type"] == "missing":  # from a list: tables look for their keys themselves
        length = max(int(e["loc"][-1]) for e in errors if e["type"] == "missing") + 1
        return InputError(_where(first["loc"][:-1], place, data), _shown(found), _list_of(length))
    if first["type"] == "too_long":
        return InputError(where, _shown(found), _list_of(context["max_length"]))
    # The alternatives of a union are reported one by one, all at the same place.
    texts = [_EXPECTED.get(e["type"], e["msg"]) for at, e in findings if at == where]
    if {"a number", "text"} <= set(texts):
        texts = ["a number, a quantity like '850 mm' or an expression"]
    expected = " or ".join(dict.fromkeys(texts)).replace("Input should be ", "")
    return InputError(where, _shown(found), expected.replace("Value error, ", ""))


def _list_of(length: int) -> str:
    return f"a list of {length}"


def _shown(value: object) -> str:
    """As the user would write it: tuples as the lists they were."""
    text = repr(list(value) if isinstance(value, tuple) else value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _where(loc: tuple[int | str, ...], place: str, data: Any) -> str:
    """`loc` as the user would write it, without the names pydantic gives to unions' members."""
    for part in loc:
        if isinstance(part, int):
            place += f"[{part}]"
        elif part in data if isinstance(data, Mapping) else data is None and part not in _SCALARS:
            place += f" {part}" if place.endswith(":") else f".{part}"
        else:
            continue
        try:
            data = None if data is None else data[part]
        except IndexError:  # an element that a list should have had
            data = None
    return place.removesuffix(":")
