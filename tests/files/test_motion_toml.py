"""Motions from TOML tables: every law, and every refusal."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkage import LINKAGE, MOTION, Refusal, edited
from numpy.testing import assert_allclose

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.files.motion_toml import laws_by_coordinate, motion_from_table
from parakin.model.expressions import Parameters
from parakin.model.units import ANGLE, LENGTH
from parakin.motion import laws
from parakin.motion.laws import Law
from parakin.motion.motion import Motion

PATIENT = settings(deadline=None)  # the first spline imports scipy


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


def assert_says(error: pytest.ExceptionInfo[InputError], message: str) -> None:
    """Each of the parts of `message`, which three dots separate."""
    for part in message.split(" ... "):
        assert part in refusal(error)


PLATFORM = {"platform.x": LENGTH, "platform.y": LENGTH, "platform.phi": ANGLE}

HOME = {"platform.x": 1.8, "platform.y": 1.1, "platform.phi": 0.1}


def read(
    text: str, rate: float | None = None, parameters: Mapping[str, Any] | None = None
) -> Motion:
    table = tomllib.loads(text)["motions"]["general"]
    known = Parameters({"x_star": "50 mm", "phi_star": "20 deg", **(parameters or {})})
    return motion_from_table(table, "general", known, HOME, PLATFORM, "motions.general", rate)


def one(law: str, coordinate: str = "platform.x") -> FloatArray:
    """(3, n) of a motion of 2 s with one law."""
    drive = read(
        f'[motions.general]\nduration = "2 s"\nrate = 100\n'
        f"[motions.general.laws]\n{coordinate} = {law}\n"
    )
    row = drive.coordinates.index(coordinate)
    return np.stack([rows[row] for rows in drive.samples().orders])


def test_a_whole_table() -> None:
    drive = read(
        """
        [motions.general]
        title = "General evolution"
        duration = "3 s"
        [motions.general.laws]
        platform.x = { law = "cosine", by = "2*x_star" }
        "platform.phi" = { law = "sines", terms = [
            { amplitude = "2 deg", frequency = "0.5 Hz", phase = "90 deg" },
            { amplitude = 0.01, frequency = 3 } ] }
        """
    )
    assert drive.name == "general"
    assert drive.coordinates == ("platform.x", "platform.y", "platform.phi")
    assert drive.count == 3001
    assert drive.derivatives == "exact"
    samples = drive.samples()
    t = samples.time
    terms = [(np.radians(2), 0.5, np.pi / 2), (0.01, 3.0, 0.0)]
    given = [laws.cosine(1.8, 0.1, 3.0), laws.constant(1.1), laws.sines(0.1, terms)]
    for row, law in enumerate(given):
        for got, expected in zip(samples.orders, law(t), strict=True):
            assert_allclose(got[row], expected, atol=1e-13)


def test_rate_may_be_said_and_replaced() -> None:
    text = '[motions.general]\nduration = 3\nrate = "2 kHz"\n'
    assert read(text).count == 6001
    assert read(text, rate=10.0).count == 31
    assert read("[motions.general]\nduration = 3\n").count == 3001


T = np.arange(201) / 100


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        ('{ law = "constant", value = "2 m" }', laws.constant(2.0)),
        ('{ law = "cosine", to = "2 m" }', laws.cosine(1.8, 0.2, 2.0)),
        ('{ law = "cosine", from = 1, to = 2, begin = 0.5 }', laws.cosine(1, 1, 1.5, 0.5)),
        (
            '{ law = "poly345", by = "x_star", begin = "500 ms", duration = "1 s" }',
            laws.polynomial345(1.8, 0.05, 1.0, 0.5),
        ),
        ('{ law = "poly4567", by = -0.1 }', laws.polynomial4567(1.8, -0.1, 2.0)),
        (
            '{ law = "sine", amplitude = "10 mm", frequency = "2 Hz" }',
            laws.sine(1.8, 0.01, 2.0),
        ),
        (
            '{ law = "sine", center = 0, amplitude = 1, frequency = 1, phase = "90 deg" }',
            laws.sine(0.0, 1.0, 1.0, np.pi / 2),
        ),
        (
            '{ law = "chirp", amplitude = 0.1, from_frequency = 0, to_frequency = "5 Hz" }',
            laws.chirp(1.8, 0.1, 0.0, 5.0, 2.0),
        ),
        (
            '{ law = "waypoints", times = [0, "500 ms", 2], values = ["1800 mm", 2, "x_star"] }',
            laws.waypoints([0, 0.5, 2], [1.8, 2.0, 0.05]),
        ),
    ],
)
def test_each_law_of_a_table(law: str, expected: Law) -> None:
    assert_allclose(one(law), np.stack(expected(T)), atol=1e-12)


HEAD = '[motions.general]\nduration = "2 s"\n'

LAW = HEAD + "[motions.general.laws]\nplatform.x = "

BAD_TABLES = [
    ("[motions.general]\n", "motions.general: found no key 'duration'"),
    (HEAD + "law = 1", "motions.general: found unknown key 'law' ... did you mean 'laws'?"),
    (HEAD + "laws = 3", "motions.general.laws: found 3; expected a table"),
    (HEAD + "title = 3", "motions.general.title: found 3; expected text"),
    (
        "[motions.general]\nduration = true",
        "motions.general.duration: found True; expected a number",
    ),
    (
        '[motions.general]\nduration = "3 m"',
        "motions.general.duration: found '3 m', a length; expected a time",
    ),
    (
        '[motions.general]\nduration = "-3 s"',
        "motions.general.duration: found -3; expected a positive number",
    ),
    (
        "[motions.general]\nduration = inf",
        "motions.general.duration: found inf ... a finite number",
    ),
    (HEAD + "rate = 0", "motions.general.rate: found 0; expected a positive number"),
    (HEAD + 'rate = "1 rpm"', "motions.general.rate: found '1 rpm'"),
    (HEAD + "rate = 1e9", "motion 'general': found 2e+09 steps"),
    (
        HEAD + "laws.platform.z = { law = 'constant', value = 1 }",
        "motions.general.laws: found 'platform.z', not driven ... did you mean 'platform.",
    ),
    (LAW + "3", "motions.general.laws.platform: found no key 'law'; expected the key law"),
    (LAW + "{ by = 3 }", "motions.general.laws.platform.x: found no key 'law'; expected the key"),
    (LAW + "{}", "motions.general.laws.platform.x: found no key 'law'"),
    (
        LAW + '{ law = "cosin", by = 3 }',
        "general.laws.platform.x.law: found 'cosin' ... poly4567 ... did you mean 'cosine'?",
    ),
    (LAW + "{ law = 3 }", "motions.general.laws.platform.x.law: found 3; expected one of: "),
    (
        LAW + '{ law = "cosine", bye = 3 }',
        "laws.platform.x: found unknown key 'bye' ... duration, from, law, to ... mean 'by'",
    ),
    (
        LAW + '{ law = "sine", amplitud = 1, frequency = 1 }',
        "laws.platform.x: found unknown key 'amplitud' ... did you mean 'amplitude'",
    ),
    (
        LAW + '{ law = "sine", amplitude = 1 }',
        "motions.general.laws.platform.x: found no key 'frequency'",
    ),
    (
        LAW + '{ law = "cosine", by = [3] }',
        "motions.general.laws.platform.x.by: found [3]; expected a number",
    ),
    (
        LAW + '{ law = "cosine", by = "2*y_star" }',
        "motions.general.laws.platform.x.by: found '2*y_star': unknown parameter 'y_star'",
    ),
    (
        LAW + '{ law = "cosine", by = "phi_star" }',
        "motions.general.laws.platform.x.by: found 'phi_star', an angle; expected a length",
    ),
    (LAW + '{ law = "cosine" }', "platform.x.by and to: found neither; expected one of them"),
    (LAW + '{ law = "cosine", by = 1, to = 1 }', "platform.x.by and to: found both; expected one"),
    (
        LAW + '{ law = "cosine", by = 1, begin = 1, duration = 1.5 }',
        "platform.x.begin: found a law from 1 s to 2.5 s; expected one within the motion, 0 s to 2",
    ),
    (LAW + '{ law = "cosine", by = 1, begin = -1 }', "found a law from -1 s to 2 s"),
    (LAW + '{ law = "cosine", by = 1, begin = 5 }', "found a law from 5 s to 2 s"),
    (
        LAW + '{ law = "cosine", by = 1, duration = 0 }',
        "motions.general.laws.platform.x.duration: found 0; expected a positive number",
    ),
    (
        LAW + '{ law = "sines", terms = [] }',
        "motions.general.laws.platform.x.terms: found []; expected a list that is not empty",
    ),
    (
        LAW + '{ law = "sines", terms = [{ amplitude = 1, frequency = 1 }, { frequency = 1 }] }',
        "motions.general.laws.platform.x.terms[1]: found no key 'amplitude'",
    ),
    (
        LAW + '{ law = "sines", terms = [{ amplitude = 1, frequency = "1 s" }] }',
        "motions.general.laws.platform.x.terms[0].frequency: found '1 s', a time; expected a freq",
    ),
    (
        LAW + '{ law = "waypoints", times = [0, "1 m"], values = [0, 1] }',
        "motions.general.laws.platform.x.times[1]: found '1 m', a length; expected a time",
    ),
    (
        LAW + '{ law = "waypoints", times = [0, 3], values = [0, 1] }',
        "motions.general.laws.platform.x.times: found a law from 0 s to 3 s; expected one within",
    ),
    (
        LAW + '{ law = "waypoints", times = [], values = [] }',
        "motions.general.laws.platform.x.times: found []; expected two or more, increasing",
    ),
    (
        LAW + '{ law = "waypoints", times = [0, 1], values = [0, 1, 2] }',
        "motions.general.laws.platform.x.values: found an array of shape (3,); expected (2,)",
    ),
    (
        LAW + '{ law = "constant", value = 1 }\n"platform.x" = { law = "constant", value = 2 }',
        "motions.general.laws.platform.x: found two values; expected one",
    ),
]


@pytest.mark.parametrize(("text", "message"), BAD_TABLES)
def test_tables_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        read(text)
    assert_says(error, message)


@PATIENT
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    ["law", "by", "to", "from", "terms", "amplitude", "times", "values", "duration"]
                ),
                inner,
                max_size=4,
            )
        ),
        max_leaves=10,
    ),
    st.sampled_from(["constant", "cosine", "sine", "sines", "chirp", "waypoints", "x"]),
)
def test_any_table_is_a_motion_or_an_input_error(law: Any, kind: str) -> None:
    table: dict[str, Any] = {"duration": 1, "rate": 10, "laws": {"platform": {"x": law}}}
    if isinstance(law, dict):
        law["law"] = kind
    try:
        drive = motion_from_table(table, "m", Parameters({}), HOME, PLATFORM, "motions.m")
        assert np.isfinite(drive.samples().acceleration).all()
    except InputError as error:
        assert error.place.startswith("motion")


def test_law_tables_are_kept_whole() -> None:
    table = {"platform": {"x": {"law": "a"}, "y": {"z": {"law": "b"}}}, "A2": {"law": "c"}, "B": 3}
    flat = {"platform.x": {"law": "a"}, "platform.y.z": {"law": "b"}, "A2": {"law": "c"}, "B": 3}
    assert laws_by_coordinate(table, "laws") == flat


ARITHMETIC = "only numbers, units, parameters, + - * / ** and functions"

MOTIONS = [
    (
        "A = {",
        "AA = {",
        "motion.laws: found 'AA', not driven; expected one of: A; did you mean 'A'",
    ),
    ("A = {", "B = {", "motion.laws: found 'B', not driven; expected one of: A"),
    (
        '"poly345"',
        '"poly34"',
        "motion.laws.A.law: found 'poly34'; expected one of: chirp, constant",
    ),
    ('"poly345"', '"poly34"', "did you mean 'poly345'?"),
    ('law = "poly345", ', "", "motion.laws.A: found no key 'law'; expected the key law"),
    ("by =", "bye =", "motion.laws.A: found unknown key 'bye'; expected one of: begin, by"),
    (
        'by = "40 deg"',
        "by = 1, to = 2",
        "motion.laws.A.by and to: found both; expected one of them",
    ),
    (
        'by = "40 deg"',
        "by = [1]",
        "motion.laws.A.by: found [1]; expected a number, a quantity like",
    ),
    ("40 deg", "40 mm", "motion.laws.A.by: found '40 mm', a length; expected an angle"),
    (
        "40 deg",
        "40 deg + q",
        "motion.laws.A.by: found '40 deg + q': unknown parameter 'q'; expected",
    ),
    ("40 deg", "().__class__", f"it is more than arithmetic; expected {ARITHMETIC}"),
    ('"40 deg"', "nan", "motion.laws.A.by: found nan; expected a finite number"),
    ("A = { law", "A = [1]\nB = { law", "motion.laws.A: found [1]; expected a table"),
    ("rate = 50", "rte = 50", "motion: found unknown key 'rte'; expected one of: duration, laws"),
    ("rate = 50", "rate = 0", "motion.rate: found 0; expected a positive number"),
    ("rate = 50", "rate = inf", "motion.rate: found inf; expected a finite number"),
    (
        "rate = 50",
        "rate = 1e30",
        "found 2e+30 steps (2 s at 1e+30 samples per second); expected at",
    ),
    ('"2 s"', '"2 m"', "motion.duration: found '2 m', a length; expected a time"),
    ('"2 s"', "-1", "motion.duration: found -1; expected a positive number"),
    ('duration = "2 s"', "", "motion: found no key 'duration'; expected a value for duration"),
    (MOTION, LINKAGE, "motion: found unknown key 'name'; expected one of: duration, laws, rate"),
    (MOTION, "\n", ": found an empty file; expected a file with text"),
    (MOTION, "duration", ": found a syntax error: Expected '=' after a key"),
]


@pytest.mark.parametrize(("old", "new", "said"), MOTIONS, ids=[case[2] for case in MOTIONS])
def test_a_motion_that_says_something_wrong(
    old: str, new: str, said: str, refusal: Refusal
) -> None:
    Path("motion.toml").write_text(edited(MOTION, old, new))
    message = refusal("solve", "linkage.toml", "motion.toml", "-o", "old.csv")
    assert "motion" in message.split(":")[0]
    assert said in message
    assert "; expected " in message
