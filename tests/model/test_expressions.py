"""Quantities and expressions as text: what they are worth, and that nothing else is let in."""

from __future__ import annotations

import math
import re
import warnings
from fractions import Fraction

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from parakin import InputError
from parakin.model.expressions import MAX_CHARACTERS, Parameters, Value
from parakin.model.units import (
    ANGLE,
    ANGULAR_VELOCITY,
    BARE,
    DENSITY,
    FORCE,
    FREQUENCY,
    INERTIA,
    LENGTH,
    MASS,
    POWER,
    TIME,
    TORQUE,
    VELOCITY,
    Dimension,
)

ACCELERATION = Dimension(length=1, time=-2)


def evaluate(text: Value, dimension: Dimension = BARE, **parameters: Value) -> float:
    return Parameters(parameters).evaluate(text, dimension, "here")


def refused(text: Value, dimension: Dimension = BARE, **parameters: Value) -> InputError:
    with pytest.raises(InputError) as caught:
        evaluate(text, dimension, **parameters)
    return caught.value


# ---- quantities


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("850 mm", LENGTH, 0.85),
        ("850mm", LENGTH, 0.85),
        ("8.5e2 mm", LENGTH, 0.85),
        (".85 m", LENGTH, 0.85),
        ("85. cm", LENGTH, 0.85),
        ("1 in", LENGTH, 0.0254),
        ("2 ft + 1 in", LENGTH, 0.6350),
        ("3 um", LENGTH, 3e-6),
        ("3 µm", LENGTH, 3e-6),
        ("15 deg", ANGLE, math.radians(15)),
        ("15°", ANGLE, math.radians(15)),
        ("2 mrad", ANGLE, 2e-3),
        ("1 turn", ANGLE, 2 * math.pi),
        ("1.5 ms", TIME, 1.5e-3),
        ("2 min", TIME, 120.0),
        ("3 kHz", FREQUENCY, 3000.0),
        ("9.81 m/s^2", ACCELERATION, 9.81),
        ("9.81 m/s**2", ACCELERATION, 9.81),
        ("9.81 m/s²", ACCELERATION, 9.81),
        ("250 mm/s", VELOCITY, 0.25),
        ("30 deg/s", ANGULAR_VELOCITY, math.radians(30)),
        ("60 rpm", ANGULAR_VELOCITY, 2 * math.pi),
        ("250 kg", MASS, 250.0),
        ("7.85 g/cm^3", DENSITY, 7850.0),
        ("7850 kg/m³", DENSITY, 7850.0),
        ("12 N", FORCE, 12.0),
        ("0.5 kN", FORCE, 500.0),
        ("3 N m", TORQUE, 3.0),
        ("3 N*m", TORQUE, 3.0),
        ("3 Nm", TORQUE, 3.0),
        ("3 N·m", TORQUE, 3.0),
        ("2e-4 kg*m^2", INERTIA, 2e-4),
        ("2e-4 kg m²", INERTIA, 2e-4),
        ("5 N/mm", Dimension(time=-2, mass=1), 5000.0),
        ("200 N*s/m", Dimension(time=-1, mass=1), 200.0),
        ("2 N m/A", Dimension(length=2, time=-2, mass=1, current=-1), 2.0),
        ("2 N m / deg", Dimension(length=2, time=-2, mass=1, angle=-1), 360 / math.pi),
        ("2 N m", Dimension(length=2, time=-2, mass=1, angle=-1), 2.0),
        ("1.5 kW", POWER, 1500.0),
    ],
)
def test_a_number_with_a_unit_is_a_quantity_in_si(
    text: str, dimension: Dimension, value: float
) -> None:
    assert evaluate(text, dimension) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("number", [1, 7, 33, 850, 950, 1234.5])
def test_millimetres_are_rounded_once(number: float) -> None:
    assert evaluate(f"{number} mm", LENGTH) == number / 1000
    assert evaluate(f"{number} ms", TIME) == number / 1000
    assert evaluate(f"{number} cm", LENGTH) == number / 100


@pytest.mark.parametrize("value", [0, 3, -0.25, "3", "-0.25", "1e-3", "1e3", "2.5E-7", "+4"])
def test_a_bare_number_is_si_in_any_dimension(value: Value) -> None:
    for dimension in (BARE, LENGTH, ANGLE, TIME):
        assert evaluate(value, dimension) == float(value)


@pytest.mark.parametrize("text", ["1e-3 + d", "1e-3+d", "1E-3*1 + d", "d - -1e-3"])
def test_an_exponent_is_part_of_its_number(text: str) -> None:
    assert evaluate(text, LENGTH, d="1 m") == pytest.approx(1.001, rel=1e-15)


def test_a_unit_stands_right_behind_its_number_and_every_other_name_is_a_parameter() -> None:
    h, m = 1.25, 7.0
    assert evaluate("h", h=h) == h
    assert evaluate("2*h", h=h) == 2 * h
    assert evaluate("2 h", TIME, h=h) == 7200.0
    assert evaluate("3 m + m", LENGTH, m=m) == 10.0
    assert evaluate("m*3 m", LENGTH, m=m) == 21.0
    assert evaluate("2*pi") == 2 * math.pi


@pytest.mark.parametrize("text", ["(2)h", "h 2", "2 h_G", "2 d1", "d1 mm", "2 sin(1)", "1_0 mm"])
def test_other_neighbours_do_not_multiply(text: str) -> None:
    assert "cannot be parsed" in refused(text, h=1, h_G=1, d1=1).found


def test_an_unknown_unit_names_the_usual_ones_and_the_nearest() -> None:
    error = refused("5 mmm", LENGTH)
    assert error.found == "'5 mmm': 'mmm' is not a unit"
    assert "deg" in error.expected
    assert error.expected.endswith("did you mean 'mm'?")


def test_a_parameter_behind_a_number_is_told_from_a_unit() -> None:
    error = refused("2 r", r=3)
    assert error.found == "'2 r': 'r' is a parameter, not a unit"
    assert error.expected == "2*r for that"


def test_a_parameter_is_meant_after_an_operator_and_a_unit_after_a_space() -> None:
    assert evaluate("2 N*m", Dimension(length=2, time=-2, mass=1), m="0.5 m") == 1.0
    assert evaluate("2 N m", Dimension(length=2, time=-2, mass=1), m="0.5 m") == 2.0
    assert evaluate("850 mm*h", LENGTH, h=2) == 1.7
    assert "'h' is not" not in refused("2 N h", LENGTH, h=2).found  # an hour, and no length


@pytest.mark.parametrize("text", ["5 degC", "5 K", "5 mol", "5 dBm", "5 cd"])
def test_units_of_other_kinds_are_refused(text: str) -> None:
    assert "is not a unit" in refused(text, LENGTH).found


# ---- arithmetic


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2*3 - 4/8", 6.5),
        ("-2**2", -4.0),
        ("(1 + 2)*3", 9.0),
        ("2**3**2", 512.0),
        ("2**-1", 0.5),
        ("abs(-3)", 3.0),
        ("sqrt(2)", math.sqrt(2)),
        ("hypot(3, 4)", 5.0),
        ("sin(0.5)", math.sin(0.5)),
        ("cos(0.5)", math.cos(0.5)),
        ("tan(0.5)", math.tan(0.5)),
        ("asin(0.5)", math.asin(0.5)),
        ("acos(0.5)", math.acos(0.5)),
        ("atan(0.5)", math.atan(0.5)),
        ("atan2(-1, -1)", math.atan2(-1, -1)),
        ("sin(30 deg)", math.sin(math.radians(30))),
        ("pi", math.pi),
    ],
)
def test_arithmetic_and_functions(text: str, value: float) -> None:
    dimension = ANGLE if text.startswith("a") and "abs" not in text else BARE
    assert evaluate(text, dimension) == value


def combined(leaves: st.SearchStrategy[str], operators: str) -> st.SearchStrategy[str]:
    def grow(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        pairs = st.tuples(inner, st.sampled_from(operators), inner)
        return pairs.map(lambda t: f"({t[0]} {t[1]} {t[2]})") | inner.map(lambda t: f"-{t}")

    return st.recursive(leaves, grow, max_leaves=6)


whole = st.integers(0, 9).map(str)
powers = st.tuples(whole, st.integers(0, 2)).map(lambda t: f"{t[0]}**{t[1]}")
fractions = st.tuples(st.integers(-999, 999), st.integers(1, 999)).map(lambda t: f"({t[0]}/{t[1]})")
floats = st.floats(0, allow_nan=False, allow_infinity=False).map(repr)


@settings(deadline=None)
@given(combined(whole | powers, "+-*"))
def test_whole_numbers_are_exact(text: str) -> None:
    assert evaluate(text) == eval(text)  # Python's integers


@settings(deadline=None)
@given(fractions, fractions, fractions)
def test_fractions_are_met_to_rounding(a: str, b: str, c: str) -> None:
    x, y, z = (Fraction(text.strip("()")) for text in (a, b, c))
    bound = (abs(x * y) + abs(z)) * Fraction(1, 2**50)
    assert abs(Fraction(evaluate(f"{a}*{b} + {c}")) - (x * y + z)) <= bound


@settings(deadline=None)
@given(combined(floats, "+-*/"))
def test_floats_are_pythons_to_the_last_bit_or_refused_where_not_finite(text: str) -> None:
    parts: list[float] = []

    class Watched(float):
        def watched(self, value: float) -> Watched:
            parts.append(value)
            return Watched(value)

        def __add__(self, other: float) -> Watched:
            return self.watched(float(self) + float(other))

        def __sub__(self, other: float) -> Watched:
            return self.watched(float(self) - float(other))

        def __mul__(self, other: float) -> Watched:
            return self.watched(float(self) * float(other))

        def __truediv__(self, other: float) -> Watched:
            return self.watched(float(self) / float(other))

        def __neg__(self) -> Watched:
            return self.watched(-float(self))

    marked = re.sub(r"\d[\d.]*(e[+-]?\d+)?", lambda m: f"Watched('{m[0]}')", text)
    try:
        expected = eval(marked, {"Watched": Watched})
        finite = all(math.isfinite(part) for part in parts)
    except ZeroDivisionError:
        finite = False
    if len(text) > MAX_CHARACTERS:
        return
    if finite:
        assert evaluate(text) == expected
    else:
        assert refused(text).expected == "a finite number"


@settings(deadline=None)
@given(
    st.floats(-1e6, 1e6),
    st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-6),
    st.sampled_from(["a + b", "a - b", "a*b", "a/b", "-a", "abs(a) + b", "hypot(a, b)"]),
)
def test_parameters_agree_with_pythons_floats_to_the_last_bit(
    a: float, b: float, text: str
) -> None:
    python = {"a": a, "b": b, "abs": abs, "hypot": math.hypot}
    assert evaluate(text, a=a, b=b) == eval(text, python)
    assert evaluate(text, a=repr(a), b=repr(b)) == eval(text, python)


# ---- dimensions


@pytest.mark.parametrize(
    ("text", "dimension"),
    [
        ("2*d - d/2", LENGTH),
        ("sqrt(d*d + d**2)", LENGTH),
        ("hypot(d, 3 mm)", LENGTH),
        ("atan2(d, 2*d)", ANGLE),
        ("acos(d/(2*d))", ANGLE),
        ("d*sin(a)", LENGTH),
        ("d/(3 s)", VELOCITY),
        ("(d**3)**(1/3)", LENGTH),
        ("d + 1", LENGTH),  # a bare number is SI
        ("1 + d", LENGTH),
        ("a + pi/2", ANGLE),
        ("abs(-a)", ANGLE),
        ("1/(2 s)", FREQUENCY),
    ],
)
def test_dimensions_are_carried_through(text: str, dimension: Dimension) -> None:
    assert math.isfinite(evaluate(text, dimension, d="2 m", a="20 deg"))


@pytest.mark.parametrize(
    ("text", "dimension", "found", "expected"),
    [
        ("15 deg", LENGTH, "'15 deg', an angle", "a length"),
        ("15 mm", ANGLE, "'15 mm', a length", "an angle"),
        ("15 mm", TIME, "'15 mm', a length", "a time"),
        ("15 s", FREQUENCY, "'15 s', a time", "a frequency"),
        ("d*d", LENGTH, "'d*d', a quantity in m^2", "a length"),
        ("d", BARE, "'d', a length", "a number"),
        ("d + 1 s", LENGTH, "a length and a time do not go together", "one dimension"),
        ("hypot(d, 1 s)", LENGTH, "a length and a time do not go together", "one dimension"),
        ("atan2(d, 1 s)", ANGLE, "a length and a time do not go together", "one dimension"),
        ("sin(d)", BARE, "sin of a length", "an angle"),
        ("acos(d)", ANGLE, "acos of a length", "a plain number"),
        ("2**d", BARE, "an exponent with a dimension", "a plain number"),
    ],
)
def test_wrong_dimensions_are_named(
    text: str, dimension: Dimension, found: str, expected: str
) -> None:
    error = refused(text, dimension, d="2 m")
    assert error.place == "here"
    assert found in error.found
    assert expected in error.expected


# ---- parameters


def test_parameters_stand_on_one_another_in_any_order() -> None:
    parameters = Parameters({"sum": "d2 + d3", "d2": "950 mm", "d3": "0.65", "angle": "15 deg"})
    assert parameters.all() == {
        "sum": 1.6,
        "d2": 0.95,
        "d3": 0.65,
        "angle": math.radians(15),
    }


def test_a_cycle_is_told_round() -> None:
    error = refused("a", a="b + 1", b="2*c", c="b")
    assert error.place == "parameters.b"
    assert "the cycle b -> c -> b" in error.found
    assert "the cycle a -> a" in refused("a", a="a").found


def test_a_parameter_that_fails_is_the_place_to_mend() -> None:
    parameters = Parameters({"a": "b/2", "b": "1/zero", "zero": 0}, "machine.toml")
    with pytest.raises(InputError) as caught:
        parameters.evaluate("2*a", LENGTH, "joints.A.at[0]")
    assert caught.value.place == "machine.toml: parameters.b"
    assert caught.value.found == "'1/zero': it divides by zero"


def test_an_unknown_parameter_names_those_there_are_and_the_nearest() -> None:
    error = refused("2*lenght", length=1, width=2)
    assert error.found == "'2*lenght': unknown parameter 'lenght'"
    assert error.expected == "one of: length, width; did you mean 'length'?"


def test_a_long_chain_of_parameters_ends_in_a_value_or_a_message() -> None:
    chain: dict[str, Value] = {f"p{k}": f"p{k + 1} + 1" for k in range(5000)}
    with pytest.raises(InputError, match="nested too deeply"):
        Parameters({**chain, "p5000": 0}).evaluate("p0", BARE, "here")
    assert Parameters({**chain, "p5000": 0}).evaluate("p4950", BARE, "here") == 50.0


# ---- what is kept out


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "().__class__.__bases__[0].__subclasses__()",
        "d.real",
        "d.__class__",
        "'a'.join('b')",
        "d[0]",
        "[1, 2]",
        "[x for x in (1, 2)]",
        "{1: 2}",
        "{1, 2}",
        "(1, 2)",
        "lambda: 1",
        "(lambda: 1)()",
        "(x := 3)",
        "f'{d}'",
        "'text'",
        "b'text'",
        "1 if d else 2",
        "d < 2",
        "d and 1",
        "not d",
        "~3",
        "7 // 2",
        "7 % 2",
        "1 << 3",
        "1 | 2",
        "True",
        "None",
        "...",
        "2j",
        "sin",
        "sin(x=1)",
        "sin(*d)",
        "sin(**d)",
        "sin(1)(2)",
        "(sin)(1)(d)",
        "exec('1')",
        "eval('1')",
        "open('/etc/passwd')",
        "print(1)",
        "abs(-1, 2)",
        "atan2(1)",
        "hypot()",
        "await d",
        "(yield 1)",
        "*d",
        "import os",
        "d = 3",
        "1; 2",
        "1 # and so on",
        "1\n2",
        "1,",
        "",
        "   ",
        "\0",
        "1 \\",
        "'\\d'",
        "1if 2 else 3",
        "0x1for x in d",
        "0777",
        "d!",
        "5 %",
        "√2",
        "５",
        "__name__",
        "__builtins__",
        "_unit0",
        "3 mm + _unit0",
        "3 mm + _unit1",
        "3 mm + __unit0",
        "3 mm + ＿unit0",
        "3 mm * _ᵘnit0",
        "nan",
        "inf",
        "-inf",
    ],
)
def test_anything_but_arithmetic_is_refused(text: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        error = refused(text, LENGTH, d="2 m")
    assert error.place == "here"
    assert error.found
    assert error.expected
    assert "\n" not in str(error)


def test_an_unknown_function_names_those_there_are_and_the_nearest() -> None:
    error = refused("atan3(1)")
    assert "unknown function 'atan3'" in error.found
    assert "hypot" in error.expected
    assert "did you mean 'atan'?" in error.expected


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1/0", "divides by zero"),
        ("1/(d - d)", "divides by zero"),
        ("1e999", "overflows"),
        ("1/1e999", "overflows"),
        ("atan(1e999)*1", "overflows"),
        ("1e308*10", "overflows"),
        ("1/(1e308*10)", "overflows"),
        ("1e200**2", "overflows"),
        ("9**9**9", "overflows"),
        ("1" + "0" * 400, "overflows"),
        ("sqrt(-1)", "no real value"),
        ("asin(2)", "no real value"),
        ("(-1)**0.5", "no real value"),
        ("0**-1", "no real value"),
    ],
)
def test_values_that_are_no_finite_number_are_refused(text: str, why: str) -> None:
    error = refused(text, d=1)
    assert why in error.found
    assert error.expected == "a finite number"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 10**400])
def test_numbers_that_are_not_finite_are_refused(value: Value) -> None:
    assert refused(value).expected == "a finite number"


@pytest.mark.parametrize("value", [True, None, [1], {"a": 1}, object()])
def test_values_that_are_neither_number_nor_text_are_refused(value: object) -> None:
    assert refused(value).expected == "a number or an expression"  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "text", ["(" * 240 + "1" + ")" * 240, "-" * 499 + "1", "sqrt(" * 90 + "1" + ")" * 90]
)
def test_nesting_ends_in_a_value_or_a_message(text: str) -> None:
    try:
        assert abs(evaluate(text)) == 1.0
    except InputError as error:
        assert "here" in str(error)


def test_long_text_is_refused_without_being_quoted() -> None:
    error = refused("1+" * MAX_CHARACTERS + "1")
    assert error.found == f"{2 * MAX_CHARACTERS + 1} characters"


words = "d mm ( ) + - * / ** 1 2.5 e 0x _unit0 sin ' \" [ ] { : = , . ° ² /s ^2 # @ pi µ j \\ f'"
pieces = st.sampled_from(
    [*words.split(), "1e999", "__class__", "lambda", " if ", " for ", " in ", " ", "\n", "\t", "\0"]
)


@settings(deadline=None)
@given(st.text(max_size=40) | st.lists(pieces, max_size=12).map("".join))
@example("1e-3")
@example("0" * 500)
def test_any_text_is_a_finite_float_or_an_input_error(text: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            value = evaluate(text, LENGTH, d="2 m")
        except InputError as error:
            assert "\n" not in str(error)
        else:
            assert type(value) is float
            assert math.isfinite(value)
