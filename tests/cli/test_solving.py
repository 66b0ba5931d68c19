"""What `parakin solve` prints where, what it writes, and how it ends."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np
import pendulum
import pytest
import xarray as xr
from linkage import ARM

from parakin import Status
from parakin.arrays import ORDERS
from parakin.files import datasets
from parakin.views import plots

SOLVE = ("solve", "flight-simulator", "general")

# The platform is raised by 3 m, far beyond its legs, after 1 s at rest.
TOO_HIGH = """
duration = "2 s"
rate = 100

[laws]
platform.y = { law = "poly345", by = "3 m", begin = "1 s" }
"""

PUSH = "force = [-100, -50, 0]"
LOCKED = f"""
name = "crank"
driven = ["A"]
home.A = "30 deg"
guess = {{ B = "-40 deg", D = "190 mm" }}
[bodies]
crank = {{ mass = 1 }}
rod = {{}}
piston = {{ mass = 2 }}
[joints.A]
kind = "revolute"
parent = "base"
child = "crank"
actuated = true
friction = {{ coefficient = 4, radius = "60 mm" }}
[joints.B]
kind = "revolute"
parent = "crank"
child = "rod"
on_parent = {{ at = ["50 mm", 0, 0] }}
friction = {{ coefficient = 4, radius = "60 mm" }}
[joints.C]
kind = "revolute"
parent = "rod"
child = "piston"
on_parent = {{ at = ["150 mm", 0, 0] }}
[joints.D]
kind = "prismatic"
parent = "base"
child = "piston"
on_parent = {{ axis = [1, 0, 0] }}
on_child = {{ axis = [1, 0, 0] }}
[forces.push]
kind = "wrench"
at = "piston"
{PUSH}
[motions.turn]
duration = "1 s"
rate = 50
laws = {{ A = {{ law = "poly345", by = "360 deg" }} }}
"""

Parakin = Callable[..., tuple[int, str, str]]


def lines(text: str) -> list[list[str]]:
    """A printed table by cells: what two or more spaces part."""
    return [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]


def test_solve_prints_a_table_of_the_actuated_coordinates(
    run: Parakin, general: xr.Dataset
) -> None:
    code, out, err = run(*SOLVE)
    assert (code, out) == (0, "")
    title, heading, *rows, last = lines(err)
    assert title == ["flight-simulator, general: 3-DOF parallel flight simulator"]
    assert heading == "actuated,from,to,stroke from home,peak speed,peak accel.".split(",")
    assert [row[0] for row in rows] == ["A2 [mm]", "B3 [mm]", "C3 [mm]"]
    for name, row in zip(("A2", "B3", "C3"), rows, strict=True):
        q, v, a = (1e3 * general[order].sel(coordinate=name) for order in ORDERS[:3])
        home = 1e3 * float(general["home"].sel(coordinate=name))
        assert row[1:] == [
            f"{float(q.min()):.3f}",
            f"{float(q.max()):.3f}",
            f"{float(q.min()) - home:+z.3f} .. {float(q.max()) - home:+z.3f}",
            f"{float(abs(v).max()):.3f} mm/s",
            f"{float(abs(a).max()):.3f} mm/s²",
        ]
    assert re.match(
        r"3,001 samples solved in [\d.]+ m?s \([\d,]+ ns a pose\); worst residual \S+ m, ", last[0]
    )


def test_angles_are_shown_in_degrees_and_all_coordinates_where_none_is_actuated(
    run: Parakin,
) -> None:
    Path("arm.toml").write_text(ARM)
    code, _, err = run("solve", "arm.toml", "wave")
    assert code == 0
    rows = {row[0]: row[1:] for row in lines(err)}
    assert rows["shoulder [deg]"][:3] == ["10.000", "50.000", "+0.000 .. +40.000"]
    assert rows["shoulder [deg]"][3] == "37.500 deg/s"
    assert rows["slide [mm]"][2] == "-50.000 .. +50.000"


@pytest.mark.parametrize("columns", ["20", "80", "200"])
def test_numbers_are_never_cut_or_folded(
    run: Parakin, columns: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    names = {"shoulder": "a-joint-with-a-name-as-long-as-they-come-and-then-some-more"}
    Path("arm.toml").write_text(ARM.replace("shoulder", names["shoulder"]))
    _, out, _ = run("check", "arm.toml")
    _, _, err = run("solve", "arm.toml", "wave")
    for text in (out, err):
        assert "…" not in text
        (row,) = [
            line for line in text.splitlines() if re.match(rf"{names['shoulder']}( |$)", line)
        ]
        assert "10.000" in row


def test_the_tables_of_the_flight_simulator_fit_eighty_columns(run: Parakin) -> None:
    _, out, _ = run("check", "flight-simulator")
    _, _, err = run(*SOLVE)
    rows = [line.rstrip() for line in (out + err).splitlines() if re.search(r"\S  +\S", line)]
    assert len(rows) > 20
    assert max(map(len, rows)) <= 80


def read_csv(text: str) -> tuple[list[str], np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    header, *rows = csv.reader(io.StringIO(text))
    return header, np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])


def test_jerk_on_request(run: Parakin) -> None:
    """Against central differences of the accelerations: h²/6 of a fifth derivative below 10."""
    code, _, err = run(*SOLVE, "-o", "general.csv", "--jerk", "--plot", "general.png")
    assert code == 0
    assert "peak jerk" in err
    assert "mm/s³" in err
    header, values = read_csv(Path("general.csv").read_text())
    for name in ("A2", "B3", "platform.psi"):
        jerk = values[:, header.index(f"{name}.jerk")]
        a = values[:, header.index(f"{name}.acceleration")]
        np.testing.assert_allclose(jerk[1:-1], (a[2:] - a[:-2]) / 2e-3, atol=1e-5)
        assert np.abs(jerk).max() > 0.01


def test_jerk_is_refused_where_the_motion_has_none(run: Parakin, general: xr.Dataset) -> None:
    names = ["platform.x", "platform.y", "platform.phi"]
    with open("drive.csv", "w") as file:
        datasets.write_csv([general.drop_dims("body").sel(coordinate=names)], file)
    assert run("solve", "flight-simulator", "drive.csv", "-o", "out.csv")[0] == 0
    code, _, err = run("solve", "flight-simulator", "drive.csv", "-o", "jerk.csv", "--jerk")
    assert code == 2
    assert "jerk too, or position alone" in err
    assert not Path("jerk.csv").exists()


def test_minus_is_csv_on_stdout_and_all_else_on_stderr(run: Parakin, general: xr.Dataset) -> None:
    code, out, err = run(*SOLVE, "-o", "-")
    assert code == 0
    assert not list(Path().iterdir())
    header, values = read_csv(out)
    assert header[0] == "time"
    assert values.shape == (3001, len(header))
    assert values.tobytes() == datasets.frame(general.drop_dims("body")).to_numpy(float).tobytes()
    assert err.startswith("flight-simulator, general: ")
    assert "worst residual" in err


def test_all_adds_the_joints_outside_the_tree(run: Parakin) -> None:
    assert run(*SOLVE, "-o", "all.csv", "--all", "--rate", "10")[0] == 0
    header, _ = read_csv(Path("all.csv").read_text())
    for name in ("B4.1", "C4.3", "D2", "E2", "B4.cone", "C4.cone"):
        assert f"{name}.position" in header


def test_an_old_result_is_replaced_and_a_link_followed(run: Parakin, here: Path) -> None:
    (here / "real.csv").write_text("old")
    (here / "link.csv").symlink_to("real.csv")
    assert run(*SOLVE, "--rate", "10", "-o", "link.csv")[0] == 0
    assert (here / "link.csv").is_symlink()
    assert (here / "real.csv").read_text().startswith("time,")
    assert sorted(path.name for path in here.iterdir()) == ["link.csv", "real.csv"]


def test_a_result_is_as_readable_as_any_new_file(run: Parakin, here: Path) -> None:
    (here / "other").touch()
    assert run(*SOLVE, "--rate", "10", "-o", "new.csv")[0] == 0
    assert (here / "new.csv").stat().st_mode == (here / "other").stat().st_mode


def test_a_result_can_be_the_next_motion(run: Parakin) -> None:
    assert run(*SOLVE, "-o", "first.csv", "--rate", "200")[0] == 0
    code, _, err = run("solve", "flight-simulator", "first.csv", "-o", "second.csv")
    assert code == 0, err
    header, first = read_csv(Path("first.csv").read_text())
    again, second = read_csv(Path("second.csv").read_text())
    assert again == header
    columns = [k for k, name in enumerate(header) if name.endswith(".position")]
    np.testing.assert_allclose(second[:, columns], first[:, columns], rtol=0, atol=1e-13)


def test_rate_sets_the_number_of_samples(run: Parakin) -> None:
    assert run(*SOLVE, "--rate", "50", "-o", "slow.csv")[0] == 0
    _, values = read_csv(Path("slow.csv").read_text())
    np.testing.assert_allclose(values[:, 0], np.arange(151) / 50, rtol=1e-15)


def test_set_changes_a_parameter(run: Parakin) -> None:
    arguments = ("--rate", "10", "-o", "-", "--set", "x_star=0.1", "--set", "h_G=1150 mm")
    code, out, _ = run(*SOLVE, *arguments)
    assert code == 0
    header, values = read_csv(out)
    x = values[:, header.index("platform.x.position")]
    y = values[:, header.index("platform.y.position")]
    assert x[-1] - x[0] == pytest.approx(0.2, abs=1e-12)
    assert y[0] == 1.15


@pytest.mark.parametrize(
    ("suffix", "magic"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_plot_draws_a_figure(run: Parakin, suffix: str, magic: bytes) -> None:
    code, out, err = run(*SOLVE, "--rate", "100", "--plot", f"figure{suffix}")
    assert (code, out) == (0, "")
    assert err.endswith(f"wrote figure{suffix}\n")
    assert Path(f"figure{suffix}").read_bytes().startswith(magic)
    assert Path(f"figure{suffix}").stat().st_size > 5000


def test_a_motion_that_leaves_the_workspace_keeps_its_good_part(run: Parakin) -> None:
    Path("high.toml").write_text(TOO_HIGH)
    arguments = ("solve", "flight-simulator", "high.toml", "-o", "high.csv", "--bodies")
    code, out, err = run(*arguments, "--plot", "high.png")
    assert (code, out) == (1, "")
    header, values = read_csv(Path("high.csv").read_text())
    status = values[:, header.index("status")]
    first = int(np.argmax(status != Status.CONVERGED))
    assert 100 < first < 200
    assert (status[:first] == Status.CONVERGED).all()
    assert status[first] not in (Status.CONVERGED, Status.NOT_REACHED)
    assert (status[first + 1 :] == Status.NOT_REACHED).all()
    told = ("time", "status", "stopped_by")
    others = [k for k, name in enumerate(header) if name not in told]
    assert np.isfinite(values[:first]).all()
    assert np.isnan(values[first:, others]).all()
    y = values[:, header.index("platform.y.position")]
    assert y[first - 1] > 1.1 + 0.1
    word = Status(int(status[first])).words
    assert f"flagged: 1 {word}, {200 - first} not reached; the first at sample {first}, t = " in err
    assert f"t = {first / 100:g} s: {word}" in err
    assert Path("high.png").stat().st_size > 5000


def test_a_limit_exceeded_is_flagged_and_its_values_kept(run: Parakin) -> None:
    Path("limited.toml").write_text(
        'variant_of = "flight-simulator"\nname = "limited"\nlimits = { C3 = [0, "300 mm"] }\n'
    )
    code, out, err = run("solve", "limited.toml", "general", "-o", "-")
    assert code == 1
    header, values = read_csv(out)
    status, c3 = values[:, header.index("status")], values[:, header.index("C3.position")]
    assert np.isfinite(values).all()
    np.testing.assert_array_equal(status == Status.LIMIT_EXCEEDED, (c3 > 0.3) | (c3 < 0))
    assert set(status) == {Status.CONVERGED, Status.LIMIT_EXCEEDED}
    assert f"flagged: {np.count_nonzero(status):,} limit exceeded; the first at sample" in err


def test_a_motion_with_nothing_solved_says_so(run: Parakin, general: xr.Dataset) -> None:
    Path("gone.toml").write_text(
        'duration = 1\nrate = 10\nlaws = { platform.y = { law = "constant", value = "9 m" } }\n'
    )
    code, _, err = run("solve", "flight-simulator", "gone.toml", "--plot", "gone.png")
    assert code == 1
    rows = {row[0]: row[1:] for row in lines(err)}
    assert rows["A2 [mm]"] == ["nothing solved"]
    assert "flagged: " in err
    assert "10 not reached; the first at sample 0" in err


def test_figures_are_known_by_the_suffixes_told() -> None:
    assert plots.SUFFIXES == (".png", ".svg", ".pdf")
    assert datasets.SUFFIXES == (".csv", ".nc", ".parquet")


def test_forces_are_summed_up_on_request(run: Parakin) -> None:
    Path("pendulum.toml").write_text(pendulum.TEXT)
    code, _, err = run("solve", "pendulum.toml", "swing", "--forces", "--reactions")
    assert code == 0
    effort, *_ = pendulum.efforts(np.linspace(0.0, 2.0, 20_001))
    assert re.search(rf"A, effort +{effort.max():.2f} N m +30 N m +64 %\n", err)
    assert "beyond its drive: A needs a torque" in err
    assert "largest force [N]" in err
    assert "effort" not in run("solve", "pendulum.toml", "swing")[2]
    assert "effort" in run("solve", "pendulum.toml", "swing", "--preload", "none")[2]


def test_efforts_that_are_not_known_end_with_1(run: Parakin) -> None:
    """A piston pushed askew, whose crank's friction locks it."""
    Path("crank.toml").write_text(LOCKED)
    code, _, err = run("solve", "crank.toml", "turn", "--forces")
    assert code == 1
    found = re.search(r"efforts are not known at (\d+) of 51 samples, first at [\d.]+ s: (.*)", err)
    assert found is not None
    assert int(found[1]) > 40
    assert found[2] == "friction under load locks the mechanism"
    code, _, err = run("report", "crank.toml", "turn", "-o", "page.html")
    assert (code, "efforts are not known" in err) == (1, True)
    assert "efforts are not known" in Path("page.html").read_text(encoding="utf-8")


def test_nothing_is_printed_where_forces_are_not_known_to_the_end(run: Parakin) -> None:
    """100,000 samples are more than a window; the file of forces ends in the second."""
    Path("w.csv").write_text("time,fx,fy,fz,mx,my,mz\n0,1,0,0,0,0,0\n0.7,1,0,0,0,0,0\n")
    text = LOCKED.replace("rate = 50", "rate = 100_000").replace(PUSH, 'csv = "w.csv"')
    Path("crank.toml").write_text(text)
    code, out, err = run("solve", "crank.toml", "turn", "--forces", "-o", "-")
    assert (code, out) == (2, "")
    assert "w.csv: found forces from 0 s to 0.7 s; expected from 0 s to 1 s, as the motion" in err


def test_a_simulation_is_written_and_summed_up(run: Parakin) -> None:
    Path("pendulum.toml").write_text(pendulum.TEXT)
    Path("e.toml").write_text('[efforts]\nA = { law = "constant", value = "9 N m" }\n')
    told = ("simulate", "pendulum.toml", "--efforts", "e.toml", "--start", "A=20 deg")
    code, out, err = run(*told, "--velocity", "A=10 deg/s", "--rate", "50", "-o", "s.csv")
    assert (code, out) == (0, "")
    assert "51 samples; worst residual" in err
    assert re.search(r"A \[N m\] +9\.000 +9\.000", err)
    assert "energy drifts by" in err
    with Path("s.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 51
    assert max(abs(float(row["energy_drift"])) for row in rows) < 1e-6
    assert all(float(row["closure_drift"]) == 0.0 for row in rows)  # it has no loops
    assert run("solve", "pendulum.toml", "s.csv", "--forces")[0] == 0  # as a motion
    assert float(rows[0]["A.position"]) == pytest.approx(np.radians(20.0))
    assert float(rows[0]["A.velocity"]) == pytest.approx(np.radians(10.0))
    gained = [
        float(row["kinetic_energy"]) + float(row["potential_energy"]) for row in (rows[0], rows[-1])
    ]
    angle = np.array([float(row["A.position"]) for row in rows])
    lost = pendulum.COULOMB * np.abs(np.diff(angle)).sum()
    assert gained[1] - gained[0] == pytest.approx(9.0 * (angle[-1] - angle[0]) - lost, abs=1e-3)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (("--duration", "3m"), "--duration: found '3m', a length; expected a time"),
        (("--rate", "0"), "rate: found 0"),
        (("--start", "B=1"), "unknown coordinate 'B'"),
        (("--start", "A=1", "--start", "A=2"), "--start: found A twice"),
        (("--velocity", "A=1 m/s"), "--velocity A: found '1 m/s'"),
        (("--efforts", "none.toml"), "none.toml: found no such file"),
        (("--efforts", "e.toml"), "e.toml: efforts: found 'B', not actuated"),
        (("--efforts", "e.csv"), "e.csv"),
        (("-o", "pendulum.toml"), "pendulum.toml"),
        (("-o", "x.mp3"), "x.mp3"),
    ],
)
def test_a_simulation_that_cannot_be_had_is_2(
    run: Parakin, told: tuple[str, ...], said: str
) -> None:
    Path("pendulum.toml").write_text(pendulum.TEXT)
    Path("e.toml").write_text("[efforts]\nB = 1\n")
    Path("e.csv").write_text("time,B\n0,1\n1,1\n")
    code, out, err = run("simulate", "pendulum.toml", *told)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_a_film_leaves_reactions_in_the_result(run: Parakin) -> None:
    Path("pendulum.toml").write_text(pendulum.TEXT)
    code, _, _ = run(
        *("solve", "pendulum.toml", "rest", "--rate", "10", "--reactions"),
        *("--animate", "rest.gif", "-o", "rest.nc"),
    )
    assert code == 0
    assert Path("rest.gif").stat().st_size > 0
    with xr.open_dataset("rest.nc") as ds:
        assert "body_position" not in ds
        weight = ds["reaction_force"].sel(joint="A").values[0]
    np.testing.assert_allclose(np.linalg.norm(weight), pendulum.MASS * pendulum.GRAVITY)


def test_redundant_actuators_are_reported_and_exported_with_a_preload(run: Parakin) -> None:
    text = (files("parakin") / "catalogue" / "four-bar.toml").read_text("utf-8")
    text = text.replace("rocker = {}", 'rocker = { mass = "1 kg", com = ["c/2", 0, 0] }')
    text = text.replace("[joints.D]", "[joints.D]\nactuated = true")
    Path("two.toml").write_text(text)
    page = Path("page.html")
    assert run("report", "two.toml", "turn", "-o", "page.html")[0] == 0
    assert "2 actuators for 1 freedom" in page.read_text(encoding="utf-8")
    preload = ("--preload", "D=0.2 N m")
    assert run("report", "two.toml", "turn", "-o", "page.html", *preload)[0] == 0
    assert "2 actuators for 1 freedom" not in page.read_text(encoding="utf-8")
    code, _, err = run("export", "two.toml", "k.c", "--forces")
    assert (code, "--preload none" in err) == (2, True)
    assert run("export", "two.toml", "k.c", *preload)[0] == 0
    assert "EFFORT_D = 1" in Path("k.h").read_text()
    code, _, err = run("export", "two.toml", "m.xml", *preload)
    assert (code, "--preload" in err, "an export to .xml" in err) == (2, True, True)


def test_a_report_says_what_is_beyond_a_drive(run: Parakin) -> None:
    Path("pendulum.toml").write_text(pendulum.TEXT)
    code, out, err = run("report", "pendulum.toml", "swing", "-o", "page.html")
    assert (code, out) == (0, "wrote page.html\n")
    assert err.startswith("beyond its drive: A needs a torque of ")
    assert "<p>None.</p>" in Path("page.html").read_text(encoding="utf-8")  # passive joints
    assert err.count("\n") == 1
