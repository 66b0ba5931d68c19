"""What commands take: parameters that mean nothing."""

from __future__ import annotations

import pytest
from linkage import Refusal


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("r", "--set: found 'r'; expected NAME=VALUE"),
        ("=3", "--set: found '=3'; expected NAME=VALUE"),
        ("r=", "--set: found 'r='; expected NAME=VALUE"),
        ("r= ", "--set: found 'r= '; expected NAME=VALUE"),
        ("", "--set: found ''; expected NAME=VALUE"),
        (
            "reech=3",
            "parameters: found unknown parameter 'reech'; expected one of: l, r, reach; di",
        ),
        ("r=3 K", "parameters.r: found '3 K': 'K' is not a unit of length"),
        ("r=nan", "parameters.r: found 'nan': unknown parameter 'nan'"),
        ("r=3 deg", "parameters.reach: found 'r + l': an angle and a length do not go together"),
        ("l=3", "cannot be assembled from its guess"),
        ("r=l=2", "parameters.r: found 'l=2': it cannot be parsed"),
        ("r=reach", "parameters.r: found the cycle r -> reach -> r"),
        ("r=open('x')", "parameters.r: found \"open('x')\": unknown function 'open'"),
    ],
)
def test_a_setting_that_means_nothing(setting: str, said: str, refusal: Refusal) -> None:
    assert said in refusal("check", "linkage.toml", "--set", setting)
