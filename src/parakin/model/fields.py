"""The kinds of values in a mechanism's tables: quantities, names, lists of three."""

from __future__ import annotations

import re
from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, StrictFloat, StrictInt

from parakin.model.expressions import is_parameter_name
from parakin.model.validation import Text

Quantity = StrictInt | StrictFloat | str


def tupled(value: object) -> object:
    """TOML and JSON have lists; frozen models hold tuples."""
    return tuple(tupled(item) for item in value) if isinstance(value, list) else value


def several(value: object) -> object:
    """Where one value stands for a list of one."""
    if isinstance(value, (list, tuple)):
        return tupled(list(value))
    return (value,)


T = TypeVar("T")
OneOrMore = Annotated[tuple[T, ...], BeforeValidator(several)]
Triple = Annotated[tuple[Quantity, Quantity, Quantity], BeforeValidator(tupled)]
Turns = Annotated[tuple[tuple[Literal["x", "y", "z"], Quantity], ...], BeforeValidator(tupled)]
Angles = Annotated[tuple[tuple[Text, Literal["x", "y", "z"]], ...], BeforeValidator(tupled)]
Names = Annotated[tuple[str, ...], BeforeValidator(tupled)]
Range = Annotated[tuple[Quantity, Quantity], BeforeValidator(tupled)]


def _name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_ '-]{0,63}", name):
        raise ValueError("a name of up to 64 characters: a letter, then letters, digits and _ ' -")
    return name


def _actuated(moved: object) -> bool | tuple[int, ...]:
    if isinstance(moved, bool):
        return moved
    numbers = moved if isinstance(moved, (list, tuple)) else (None,)
    if not all(type(k) is int and k > 0 for k in numbers):
        raise ValueError("true or false, or numbers of the joint's coordinates, such as [2]")
    return tuple(numbers)


Actuated = Annotated[bool | tuple[int, ...], BeforeValidator(_actuated)]


def _mechanism_name(name: str) -> str:
    return name if re.fullmatch(r"\d[A-Za-z0-9_ '-]{0,63}", name) else _name(name)  # 3-rrr


def _parameter(name: str) -> str:
    if not (is_parameter_name(name) and re.fullmatch(r"[A-Za-z]\w{0,63}", name, re.ASCII)):
        raise ValueError(
            "a name that expressions can use: a letter, then letters, digits and _, at most 64; "
            "not pi, a function or a Python keyword"
        )
    return name


Name = Annotated[str, AfterValidator(_name)]
MechanismName = Annotated[str, AfterValidator(_mechanism_name)]
ParameterName = Annotated[str, AfterValidator(_parameter)]
