"""Units: what is exact, what is compound, what is none."""

from __future__ import annotations

from fractions import Fraction

import pytest

from parakin.model.units import (
    FORCE,
    LENGTH,
    TORQUE,
    Dimension,
    UnknownUnitError,
    atom,
    compound,
    describe,
    is_unit,
)


def test_common_units_are_exact() -> None:
    assert atom("mm").value == Fraction(1, 1000)
    assert atom("mm^2") == (Fraction(1, 10**6), Dimension(length=2))
    assert atom("m³").dimension == Dimension(length=3)


def test_compounds_stop_at_names_and_at_what_is_no_unit() -> None:
    none = frozenset[str]()
    assert compound("N m", none) == ((1, TORQUE), 3)
    assert compound("N*m", frozenset({"m"})) == ((1, FORCE), 1)
    assert compound("mm/s^2", none)[0] == (Fraction(1, 1000), Dimension(length=1, time=-2))
    assert compound("mm*radius", none) == ((Fraction(1, 1000), LENGTH), 2)
    with pytest.raises(UnknownUnitError, match="'radius' is not a unit"):
        compound("mm radius", none)


def test_units_that_are_not_multiples_are_none() -> None:
    assert not is_unit("degC")
    assert not is_unit("dBm")
    assert is_unit("lbf")


def test_dimensions_have_names() -> None:
    assert describe(FORCE) == "a force"
    assert describe(Dimension(time=-3, mass=1)) == "a quantity in s^-3 kg^1"
    assert describe(Dimension(time=-2, mass=1)) == "a stiffness, such as N/m"
