"""Findings of pydantic as InputErrors."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from parakin.errors import InputError
from parakin.model.validation import input_error, validated


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


class Plain(BaseModel):
    """A model that is no Table."""

    model_config = ConfigDict(extra="forbid", strict=True)
    size: int | str = 1
    items: list[int] = []

    @field_validator("size")
    @classmethod
    def _even(cls, size: int | str) -> int | str:
        if isinstance(size, int) and size % 2:
            raise ValueError("an even number")
        return size


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"size": 3}, "here.size: found 3; expected an even number"),
        ({"size": 0.5}, "here.size: found 0.5; expected a whole number"),
        ({"items": [1, "b"]}, "here.items[1]: found 'b'; expected a whole number"),
        ({"items": 3}, "here.items: found 3; expected a list"),
        ({"items": ["x" * 200]}, "..."),
        (7, "here: found 7; expected a table"),
    ],
)
def test_findings_of_any_model(data: Any, message: str) -> None:
    with pytest.raises(InputError) as error:
        validated(Plain, data, "here")
    assert message in refusal(error)
    assert len(refusal(error)) < 150


def test_findings_without_the_data() -> None:
    with pytest.raises(ValidationError) as error:
        Plain.model_validate({"size": 0.5})
    assert str(input_error(error.value, "here")).startswith("here.size: found 0.5; expected a ")
