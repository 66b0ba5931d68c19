"""Input tables checked by pydantic, whose findings become one InputError."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError, model_validator
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
    """For models that raise InputError when they are constructed in Python, too."""

    def __call__(self, /, **data: Any) -> Any:
        try:
            return super().__call__(**data)
        except ValidationError as error:
            place = " ".join(str(part) for part in (self.__name__, data.get("name")) if part)
            raise input_error(error, f"{place}:", data) from None


class Table(BaseModel, metaclass=_RaisesInputError):
    """A table with the declared keys and no others, and values of the declared types.

    Raises InputError on any other.
    """

    set_by_reader: ClassVar[frozenset[str]] = frozenset()  # keys that a file may not have

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _keys(cls, data: Any) -> Any:
        # Before pydantic checks the values: it would report a misspelt key as missing.
        keys = {f.alias or name: f.is_required() for name, f in cls.model_fields.items()}
        given = data if isinstance(data, Mapping) else keys
        if cls.model_config.get("populate_by_name"):
            alias = {name: f.alias or name for name, f in cls.model_fields.items()}
            given = {alias.get(key, key): None for key in given}
        if unknown := [key for key in given if key not in keys]:
            known = [key for key in keys if key not in cls.set_by_reader or key not in given]
            raise _finding(f"unknown key {unknown[0]!r}", nearest(str(unknown[0]), known))
        missing = [key for key, needed in keys.items() if needed and key not in given]
        if missing:
            what = "a value" if len(missing) == 1 else "values"
            raise _finding(f"no key {missing[0]!r}", f"{what} for {', '.join(missing)}")
        return data


_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
_PLAIN = "text without control characters"


def refuse_control(text: str, place: str) -> None:
    """Raises InputError on characters that files of text, XML among them, cannot hold."""
    if _CONTROL.search(text):
        raise InputError(place, _shown(text), _PLAIN)


def _plain(text: str) -> str:
    if _CONTROL.search(text):
        raise ValueError(_PLAIN)
    return text


Text = Annotated[str, AfterValidator(_plain)]
"""Text without control characters but tabs and ends of lines."""


def _finding(found: str, expected: str) -> PydanticCustomError:
    return PydanticCustomError("keys", "{expected}", {"found": found, "expected": expected})


def validated(model: type[AnyModel], data: object, place: str) -> AnyModel:
    """`data` as a `model`. Raises InputError, with a place below `place`, if it is not valid."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise input_error(error, place, data) from None


def input_error(error: ValidationError, place: str, data: object = None) -> InputError:
    """The first finding in `error`, from validating `data`, the table at `place`.

    place: ends in a colon if it is a file or a whole model. A ValueError raised in a validator
    should have as its message what was expected. Without `data`, the place may include names
    that pydantic gives to the members of a union.
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
    if first["type"] == "missing":  # from a list: tables check their keys themselves
        length = max(int(e["loc"][-1]) for e in errors if e["type"] == "missing") + 1
        return InputError(_where(first["loc"][:-1], place, data), _shown(found), _list_of(length))
    if first["type"] == "too_long":
        most, text = context["max_length"], isinstance(found, str)
        expected = f"text of at most {most} characters" if text else _list_of(most)
        return InputError(where, _shown(found), expected)
    if first["type"] == "too_short":
        what = "text" if isinstance(found, str) else "a list"
        return InputError(where, _shown(found), f"{what} that is not empty")
    # The alternatives of a union are reported one by one at the same place.
    texts = [_EXPECTED.get(e["type"], e["msg"]) for at, e in findings if at == where]
    if {"a number", "text"} <= set(texts):
        texts = ["a number, a quantity like '850 mm' or an expression"]
    expected = " or ".join(dict.fromkeys(texts)).replace("Input should be ", "")
    return InputError(where, _shown(found), expected.replace("Value error, ", ""))


def _list_of(length: int) -> str:
    return f"a list of {length}"


def _shown(value: object) -> str:
    """As the user would write it: tuples as lists."""
    text = repr(list(value) if isinstance(value, tuple) else value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _where(loc: tuple[int | str, ...], place: str, data: Any) -> str:
    """`loc` as the user would write it, without pydantic's names for members of unions."""
    for part in loc:
        if isinstance(part, int):
            if data is not None and not isinstance(data, (list, tuple)):
                continue  # one value, where it stands for a list of one
            place += f"[{part}]"
        elif part in data if isinstance(data, Mapping) else data is None and part not in _SCALARS:
            place += f" {part}" if place.endswith(":") else f".{part}"
        else:
            continue
        try:
            data = None if data is None else data[part]
        except IndexError:  # an element missing from a list
            data = None
    return place.removesuffix(":")
