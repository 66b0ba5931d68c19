"""Motions from CSV: what is understood, and what is refused with file, line and column."""

from __future__ import annotations

import csv
import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from parakin.errors import InputError
from parakin.files import motion_csv
from parakin.files.motion_csv import read_motion_csv
from parakin.model.units import ANGLE, LENGTH
from parakin.motion import laws
from parakin.motion.laws import from_laws
from parakin.motion.motion import Samples

DIMENSIONS = {"x": LENGTH, "B1.2": ANGLE}
LAWS = {"x": laws.sine(1.0, 0.2, 0.5), "B1.2": laws.cosine(0.0, 0.5, 2.0)}
DRIVE = from_laws("drive", LAWS, 2.0, 50.0).samples()

PATIENT = settings(  # and each example overwrites the file of the last
    deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
Write = Callable[..., Path]


@pytest.fixture(name="write")
def _write(tmp_path: Path) -> Write:
    def write(content: str | bytes, name: str = "drive.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


def table(header: str, *columns: np.ndarray, delimiter: str = ",", end: str = "\n") -> str:
    rows = zip(*(column.tolist() for column in columns), strict=True)
    lines = [delimiter.join(header.split(",")), *(delimiter.join(map(repr, row)) for row in rows)]
    return end.join(lines) + end


POSITIONS = table("time,x,B1.2", DRIVE.time, *DRIVE.position)
EVERYTHING = table(
    "time,x.position,x.velocity,x.acceleration,x.jerk,"
    "B1.2.jerk,B1.2.acceleration,B1.2.velocity,B1.2",
    DRIVE.time,
    *(rows[0] for rows in DRIVE.orders),
    *(rows[1] for rows in reversed(DRIVE.orders)),
)


def same(got: Samples, expected: Samples = DRIVE) -> None:
    for a, b in zip(got, expected, strict=True):
        assert_array_equal(a, b)


def test_positions_alone(write: Write) -> None:
    drive = read_motion_csv(write(POSITIONS), DIMENSIONS)
    assert drive.name == "drive"
    assert drive.coordinates == ("x", "B1.2")
    assert drive.derivatives == "quintic spline"
    samples = drive.samples()
    assert_array_equal(samples.time, DRIVE.time)
    assert_array_equal(samples.position, DRIVE.position)
    assert_allclose(samples.velocity, DRIVE.velocity, atol=1e-6)  # h⁵ x⁽⁶⁾ at h = 20 ms


def test_derivatives_and_any_order_of_columns(write: Write) -> None:
    drive = read_motion_csv(write(EVERYTHING), DIMENSIONS)
    assert drive.derivatives == "given"
    same(drive.samples())


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("head", ["", "\ufeff", "# made by hand, today; or so\n\n  # twice\n"])
def test_dialects(write: Write, delimiter: str, end: str, head: str) -> None:
    text = table("time,x,B1.2", DRIVE.time, *DRIVE.position, delimiter=delimiter, end=end)
    drive = read_motion_csv(write(head + text + end), DIMENSIONS)
    assert_array_equal(drive.samples().position, DRIVE.position)


def test_quotes_spaces_and_a_missing_last_line_end(write: Write) -> None:
    rows = "".join(f'"a, b", {i / 10} ,"{i}"\n' for i in range(6))
    drive = read_motion_csv(write(f'status, time ,"x"\n{rows}c,0.6,6'), {"x": LENGTH})
    assert_array_equal(drive.samples().position, [np.arange(7.0)])


def test_units(write: Write) -> None:
    factors = {"time [ms]": 1e3, "x [mm]": 1e3, "B1.2.position [deg]": 180 / np.pi}
    derived = {
        "x.velocity [mm/s]": (1, 0, 1e3),
        "B1.2.velocity [rpm]": (1, 1, 30 / np.pi),
        "x.acceleration [mm/s^2]": (2, 0, 1e3),
        "B1.2.acceleration[deg/s²]": (2, 1, 180 / np.pi),
        "x.jerk [mm/s**3]": (3, 0, 1e3),
        "B1.2.jerk [deg/s³]": (3, 1, 180 / np.pi),
    }
    values = [
        DRIVE.time,
        *DRIVE.position,
        *(DRIVE.orders[o][row] for o, row, _ in derived.values()),
    ]
    scales = [*factors.values(), *(scale for _, _, scale in derived.values())]
    columns = [value * scale for value, scale in zip(values, scales, strict=True)]
    header = ",".join([*factors, *derived])
    drive = read_motion_csv(write(table(header, *columns)), DIMENSIONS)
    assert drive.derivatives == "given"
    samples = drive.samples()
    assert_allclose(samples.time, DRIVE.time, rtol=1e-14, atol=1e-15)
    for got, expected in zip(samples.orders, DRIVE.orders, strict=True):
        assert_allclose(got, expected, rtol=1e-14, atol=1e-15)


def test_results_are_motions(write: Write) -> None:
    """Columns that results hold beside the driven coordinates are left aside."""
    others = "A2.position,rod.position.x,rod.orientation.w,rod.angular_velocity.z,conditioning"
    nothing = [np.full_like(DRIVE.time, np.nan)] * 5
    header = f"time,{others},x,B1.2.position,residual"
    text = table(header, DRIVE.time, *nothing, *DRIVE.position, DRIVE.time)
    lines = [f"{line},{'status' if i == 0 else 'converged'}" for i, line in enumerate(text.split())]
    drive = read_motion_csv(write("\n".join(lines)), DIMENSIONS)
    assert_array_equal(drive.samples().position, DRIVE.position)


def test_smoothing_and_gaps_are_passed_on(write: Write) -> None:
    path = write(POSITIONS)
    drive = read_motion_csv(path, DIMENSIONS, smoothing={"x": 1e-3})
    assert drive.derivatives == "smoothed quintic spline (noise x 0.001)"
    with pytest.raises(InputError, match=r"drive\.csv: motion 'drive': found a step of 0\.02 s"):
        read_motion_csv(path, DIMENSIONS, max_gap=0.01)


def line(number: int, text: str, source: str = POSITIONS) -> str:
    """The source with one line replaced, counted from 1."""
    lines = source.split("\n")
    lines[number - 1] = text
    return "\n".join(lines)


BEFORE = "# a comment\n\n"  # so that samples and lines are counted differently
REFUSED: list[tuple[str, str | bytes, list[str]]] = [
    ("empty", "", ["drive.csv: found no text; expected a header and samples"]),
    ("blank", " \n\n", ["drive.csv: found no text"]),
    ("only comments", "# time,x\n", ["drive.csv: found no text"]),
    ("header only", "time,x,B1.2\n\n", ["drive.csv: found only a header; expected samples"]),
    ("UTF-16", POSITIONS.encode("utf-16"), ["found bytes that are not UTF-8"]),
    ("binary later", POSITIONS.encode() + b"\xff,1,1\n", ["found bytes that are not UTF-8"]),
    ("no time", line(1, "Time,x,B1.2"), ["column 1: found 'Time'; expected", "'time'?"]),
    (
        "no time at all",
        table("x,B1.2", *DRIVE.position),
        ["drive.csv: found no column 'time' among x, B1.2; expected columns time, "],
    ),
    (
        "unknown",
        line(1, "time,x,B1.1"),
        ["drive.csv, column 3: found 'B1.1'; expected", "did you mean 'B1.2'?"],
    ),
    ("nameless", line(1, "time,x,"), ["drive.csv, column 3: found ''; expected one of"]),
    (
        "not driven",
        line(1, "time,x,B1.1.position"),
        ["drive.csv: found no column 'B1.2' among time, x, B1.1.position; expected columns time, "],
    ),
    (
        "twice",
        line(1, "time,x,x.position"),
        ["drive.csv, column 3: found 'x.position' after 'x'; expected one column each"],
    ),
    ("time twice", line(1, "time,time [ms],x"), ["found 'time [ms]' after 'time'"]),
    (
        "velocity of one",
        line(1, "time,x,B1.2,x.velocity"),
        ["found columns of velocity, but none for 'B1.2'; expected columns for all driven"],
    ),
    (
        "velocities alone",
        table("time,x,B1.2,x.velocity,B1.2.velocity", DRIVE.time, *DRIVE.position, *DRIVE.velocity),
        ["drive.csv: motion 'drive': found velocity alone; expected both"],
    ),
    (
        "unit",
        line(1, "time,x [deg],B1.2"),
        ["drive.csv, column 2 'x [deg]'", "an angle", "expected a length"],
    ),
    ("no such unit", line(1, "time,x [mn],B1.2"), ["column 2 'x [mn]'", "'mn' is not a unit"]),
    (
        "no unit",
        line(1, "time,x [2*3],B1.2"),
        ["column 2 'x [2*3]': found the unit [2*3]; expected a unit such as mm, deg/s or m/s^2"],
    ),
    ("empty unit", line(1, "time,x [],B1.2"), ["found the unit []; expected a unit such as"]),
    (
        "short",
        BEFORE + line(5, "0.06,1"),
        ["drive.csv, line 7: found 2 cells; expected 3, as in the header"],
    ),
    ("long", line(5, "0.06,1,1,1"), ["drive.csv, line 5: found 4 cells; expected 3"]),
    ("long with quotes", line(5, '0.06,"1,1",1,1'), ["line 5: found 4 cells; expected 3"]),
    (
        "text",
        BEFORE + line(5, "0.06,1.O,1"),
        ["drive.csv, line 7, column 'x': found '1.O'; expected a finite number"],
    ),
    ("empty cell", line(5, "0.06,1,"), ["line 5, column 'B1.2': found ''; expected a finite"]),
    (
        "decimal comma",
        line(5, "0,06;1;1", POSITIONS.replace(",", ";")),
        ["line 5, column 'time': found '0,06'; expected a finite number with a decimal point"],
    ),
    ("underscore", line(5, "0.06,1_0,1"), ["line 5, column 'x': found '1_0'"]),
    ("other digits", line(5, "0.06,١,1"), ["line 5, column 'x': found '١'"]),
    ("nan", BEFORE + line(5, "0.06,nan,1"), ["line 7, column 'x': found 'nan'; expected a finite"]),
    ("inf", line(5, "0.06,1,-inf"), ["line 5, column 'B1.2': found '-inf'"]),
    ("overflow", line(5, "0.06,1,1e999"), ["line 5, column 'B1.2': found '1e999'"]),
    ("comment within", line(5, "# 0.06,1,1"), ["line 5, column 'time': found '# 0.06'"]),
    (
        "one sample",
        "time,x,B1.2\n0,1,2\n",
        ["drive.csv: motion 'drive': found 1 samples; expected at least 6"],
    ),
    ("long cell", f'time,"{"x" * 200_000}"\n', ["drive.csv, header: found field larger than"]),
    (
        "null",
        line(5, "0.06,\0,1"),
        ["drive.csv, line 5", "found"],
    ),
    (
        "in degrees",
        table(
            "time,x,x.velocity,x.acceleration,x.jerk,"
            "B1.2,B1.2.velocity,B1.2.acceleration,B1.2.jerk",
            DRIVE.time,
            *(rows[0] for rows in DRIVE.orders),
            DRIVE.position[1],
            *np.degrees([rows[1] for rows in DRIVE.orders[1:]]),
        ),
        ["drive.csv: motion 'drive', velocity of 'B1.2': found an integral off by"],
    ),
]


@pytest.mark.parametrize(
    ("content", "parts"), [case[1:] for case in REFUSED], ids=[case[0] for case in REFUSED]
)
def test_refused(write: Write, content: str | bytes, parts: list[str]) -> None:
    path = write(content)
    with pytest.raises(InputError) as error:
        read_motion_csv(path, DIMENSIONS)
    message = str(error.value)
    assert message.startswith(str(path.parent))
    for part in parts:
        assert part in message


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv: found no such file or directory; expected a"):
        read_motion_csv(tmp_path / "none.csv", DIMENSIONS)
    with pytest.raises(InputError, match="found a folder or special file; expected a CSV file"):
        read_motion_csv(tmp_path, DIMENSIONS)
    with pytest.raises(InputError, match=r"null (character|byte); expected a readable CSV file"):
        read_motion_csv("a\0b", DIMENSIONS)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads everything")
def test_unreadable(write: Write) -> None:
    path = write(POSITIONS)
    path.chmod(0)
    with pytest.raises(InputError, match="found permission denied; expected a readable CSV file"):
        read_motion_csv(path, DIMENSIONS)


def test_too_large(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    assert motion_csv.MAX_BYTES == 2_000_000_000
    monkeypatch.setattr(motion_csv, "MAX_BYTES", 100)
    with pytest.raises(InputError, match=r"found \d+ bytes; expected at most 100"):
        read_motion_csv(write(POSITIONS), DIMENSIONS)


@PATIENT
@given(
    st.text(alphabet='time,x[]m/s\n\t;#"0123.e-\r\\\0é', max_size=80)
    | st.binary(max_size=40)
    | st.lists(st.sampled_from([*"time,x\n0123456789.", "time,x\n", "nan"])).map("".join)
)
def test_any_file_is_a_motion_or_an_input_error(write: Write, content: str | bytes) -> None:
    path = write(content)
    with pytest.raises(InputError) as error:
        read_motion_csv(path, {"x": LENGTH})
    assert error.value.place.startswith(str(path))


@PATIENT
@given(
    st.lists(
        st.floats(-1e3, 1e3).filter(lambda x: x == 0 or abs(x) > 1e-100), min_size=6, max_size=20
    ),
    st.sampled_from(",;\t"),
)
def test_every_digit_comes_back(write: Write, values: list[float], delimiter: str) -> None:
    path = write("")
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = ((i / 10, value) for i, value in enumerate(values))
        csv.writer(file, delimiter=delimiter).writerows([("time", "x"), *rows])
    samples = read_motion_csv(path, {"x": LENGTH}).samples()
    assert_array_equal(samples.position, [values])


def test_a_hundred_thousand_rows_take_a_moment(write: Write) -> None:
    t = np.arange(100_000) / 1000
    path = write(table("time,x,B1.2", t, *(law(t)[0] for law in LAWS.values())))
    start = time.process_time()
    assert read_motion_csv(path, DIMENSIONS).count == 100_000
    assert time.process_time() - start < 5  # of processor time; 0.3 s here
