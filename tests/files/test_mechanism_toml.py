"""Mechanisms from tables."""

from __future__ import annotations

import pytest

from parakin import InputError
from parakin.files.mechanism_toml import mechanism_from_table

TABLE = {
    "name": "bar",
    "driven": ["A"],
    "bodies": {"bar": {"points": {"P": [1, 0, 0]}}},
    "joints": {"A": {"kind": "revolute", "parent": "base", "child": "bar"}},
    "home": {"A": "30 deg"},
}


def test_tables_by_name_become_bodies_and_joints() -> None:
    mechanism = mechanism_from_table(TABLE, "bar.toml")
    assert [body.name for body in mechanism.bodies if body.name != mechanism.base] == ["bar"]
    assert [(j.name, j.kind) for j in mechanism.joints] == [("A", "revolute")]
    assert mechanism.home == {"A": "30 deg"}
    assert mechanism.where.startswith("bar.toml")


def test_numbered_coordinates_may_be_nested() -> None:
    joints = {"A": {"kind": "universal", "parent": "base", "child": "bar"}}
    table = {**TABLE, "joints": joints, "driven": ["A.1", "A.2"], "home": {"A": {"1": 0, "2": 1}}}
    assert mechanism_from_table(table, "bar.toml").home == {"A.1": 0, "A.2": 1}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"joints": None}, "joints"),
        ({"origin": "here"}, "unknown key 'origin'"),
        ({"home": 3}, "bar.toml: home"),
        ({"bodies": []}, "bar.toml: bodies"),
    ],
)
def test_what_is_no_table_is_named(change: dict[str, object], said: str) -> None:
    table = {k: v for k, v in {**TABLE, **change}.items() if v is not None}
    with pytest.raises(InputError, match=said):
        mechanism_from_table(table, "bar.toml")
