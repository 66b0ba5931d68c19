"""Commands that cannot be parsed."""

from __future__ import annotations

import pytest
from linkage import Refusal


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "the following arguments are required: COMMAND; see parakin --help"),
        (
            ["chek", "x"],
            "command: found unknown name 'chek'; expected one of: certify, check, draw, ",
        ),
        (["check"], "the following arguments are required: MECHANISM; see parakin check --help"),
        (["solve", "linkage.toml"], "arguments are required: MOTION; see parakin solve --help"),
        (
            ["solve", "linkage.toml", "turn", "--plott"],
            "unrecognized arguments: --plott; see parakin",
        ),
        (
            ["solve", "linkage.toml", "turn", "-o"],
            "argument -o/--output: expected one argument; see",
        ),
    ],
)
def test_a_command_that_cannot_be_parsed(arguments: list[str], said: str, refusal: Refusal) -> None:
    assert said in refusal(*arguments)
