"""The command line: what it prints where, what it writes, and how it ends."""

from __future__ import annotations

import csv
import io
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from linkage import Refusal

import parakin
from parakin import Status
from parakin.arrays import ORDERS
from parakin.cli.main import main
from parakin.files import datasets
from parakin.files.reading import catalogue
from parakin.views import plots

SOLVE = ("solve", "flight-simulator", "general")
# The platform is raised by 3 m, far beyond its legs, after 1 s at rest.
TOO_HIGH = """
duration = "2 s"
rate = 100

[laws]
platform.y = { law = "poly345", by = "3 m", begin = "1 s" }
"""

Parakin = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Parakin:
    """Runs a command in this process: exit code, stdout, stderr."""

    def command(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        code = main(arguments)
        return (code, *capsys.readouterr())

    return command


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile("flight-simulator")


@pytest.fixture(scope="module")
def general(solver: parakin.Solver) -> xr.Dataset:
    return solver.solve("general", bodies=True)


def lines(text: str) -> list[list[str]]:
    """A printed table by cells: what two or more spaces part."""
    return [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]


# ---- list and check


def test_list_names_the_catalogue_its_titles_and_motions(run: Parakin) -> None:
    code, out, err = run("list")
    assert (code, err) == (0, "")
    heading, *rows = lines(out)
    assert heading == ["mechanism", "what it is", "motions"]
    assert [row[:2] for row in rows] == [[name, title] for name, title in catalogue().items()]
    assert {row[0]: row[2] for row in rows}["flight-simulator"] == "vertical, rectilinear, general"


def test_check_explains_home_and_mobility(run: Parakin) -> None:
    code, out, err = run("check", "flight-simulator")
    assert (code, err) == (0, "")
    assert out.startswith("flight-simulator: 3-DOF parallel flight simulator\n")
    assert "Grübler-Kutzbach: -3 (12 bodies with the base, 15 joints)" in out
    assert "by rank: 3 at home, 3 at 6 closed configurations around it" in out
    assert "driven: platform.x, platform.y, platform.phi" in out
    rows = {row[0]: row[1:] for row in lines(out)}
    solver_home = parakin.compile("flight-simulator", machine_code=False).home
    assert rows["C3 *"] == [f"{1e3 * solver_home['C3']:.4f} mm", "0.0000 mm stated", "1.3527 mm"]
    assert rows["A1"][0] == f"{np.degrees(solver_home['A1']):.4f} deg"
    assert rows["platform.x"][1] == "1850.0000 mm held"
    assert "the largest difference is 1.3527 mm at C3." in out


def test_check_names_the_joints_that_hold_a_mechanism(run: Parakin) -> None:
    code, out, _ = run("check", "flight-simulator-upu")
    assert code == 0
    assert "3 coordinates are to be driven, but only 1 can move" in out
    assert "cause: joints B4 and C4" in out


def test_check_takes_other_parameters(run: Parakin) -> None:
    code, out, _ = run("check", "flight-simulator", "--set", "h_G=1.2", "--set", "d1=410 mm")
    assert code == 0
    rows = {row[0]: row[1:] for row in lines(out)}
    assert rows["platform.y"][0] == "1200.0000 mm"


def test_a_file_that_states_its_home_to_the_last_digit_is_told_so(run: Parakin) -> None:
    home = parakin.compile("flight-simulator", machine_code=False).home
    stated = "\n".join(f"{name} = {home[name]!r}" for name in ("A2", "B3", "C3"))
    Path("exact.toml").write_text(
        f'variant_of = "flight-simulator"\nname = "exact"\n[stated]\n{stated}\n'
    )
    code, out, _ = run("check", "exact.toml")
    assert code == 0
    assert "The stated values close the loops." in out


# ---- solve: the table


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


ARM = """
name = "arm"
driven = ["shoulder", "slide"]
home = { shoulder = "10 deg", slide = "100 mm" }
bodies = { upper = {}, lower = {} }

[joints.shoulder]
kind = "revolute"
parent = "base"
child = "upper"

[joints.slide]
kind = "prismatic"
parent = "upper"
child = "lower"
on_parent = { at = [0.5, 0, 0] }

[motions.wave]
duration = "2 s"
laws.shoulder = { law = "poly345", by = "40 deg" }
laws.slide = { law = "sine", amplitude = "50 mm", frequency = 1 }
"""


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


def test_square_brackets_in_a_title_are_shown_as_they_are(run: Parakin) -> None:
    Path("arm.toml").write_text(ARM.replace('name = "arm"', 'name = "arm"\ntitle = "[/b] [red]x"'))
    assert run("solve", "arm.toml", "wave")[2].startswith("arm, wave: [/b] [red]x\n")
    assert run("check", "arm.toml")[1].startswith("arm: [/b] [red]x\n")


# ---- solve: files


def read_csv(text: str) -> tuple[list[str], np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    header, *rows = csv.reader(io.StringIO(text))
    return header, np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])


def test_csv_has_the_columns_told_and_every_bit(
    run: Parakin, general: xr.Dataset, solver: parakin.Solver
) -> None:
    assert run(*SOLVE, "-o", "general.csv")[0] == 0
    header, values = read_csv(Path("general.csv").read_text())
    coordinates = [f"{name}.{order}" for name in solver.coordinates for order in ORDERS[:3]]
    assert header == ["time", *coordinates, "status", "residual"]
    for name in ("A2", "B3", "C3", "platform.x", "platform.y", "platform.phi", "platform.psi"):
        assert name in solver.coordinates
    expected = datasets.frame(general.drop_dims("body")).to_numpy(dtype=float)
    assert values.tobytes() == expected.tobytes()
    np.testing.assert_array_equal(values[:, 0], general["time"])
    for order in ORDERS[:3]:
        column = header.index(f"C3.{order}")
        np.testing.assert_array_equal(values[:, column], general[order].sel(coordinate="C3"))


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


def test_netcdf_opens_in_xarray_as_the_dataset(run: Parakin, general: xr.Dataset) -> None:
    assert run(*SOLVE, "-o", "general.nc", "--bodies")[0] == 0
    with xr.open_dataset("general.nc") as opened:
        xr.testing.assert_equal(opened, general)
        assert opened.attrs == general.attrs
        for name in general.variables:
            assert opened[name].dtype.kind == general[name].dtype.kind
        for name in (*ORDERS[:3], "residual", "time"):
            assert opened[name].attrs["units"] == general[name].attrs["units"]
            assert opened[name].values.tobytes() == general[name].values.tobytes()


def test_parquet_holds_the_same_table_as_csv(run: Parakin, general: xr.Dataset) -> None:
    import pandas as pd

    assert run(*SOLVE, "-o", "general.parquet", "--bodies")[0] == 0
    pd.testing.assert_frame_equal(
        pd.read_parquet("general.parquet"), datasets.frame(general), check_exact=True
    )


def test_bodies_come_before_the_last_two_columns(run: Parakin, general: xr.Dataset) -> None:
    assert run(*SOLVE, "-o", "bodies.csv", "--bodies")[0] == 0
    header, values = read_csv(Path("bodies.csv").read_text())
    vectors = ("position", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
    for body in general["body"].values:
        for vector in vectors:
            assert [f"{body}.{vector}.{axis}" in header for axis in "xyz"] == [True] * 3
        assert [f"{body}.orientation.{part}" in header for part in "wxyz"] == [True] * 4
    assert header[-2:] == ["status", "residual"]
    column = values[:, header.index("rod.angular_velocity.z")]
    np.testing.assert_array_equal(
        column, general["body_angular_velocity"].sel(body="rod", axis="z")
    )
    # The rod turns with the platform's psi about z.
    psi = values[:, header.index("platform.psi.velocity")]
    np.testing.assert_allclose(column, psi, atol=1e-12)


def test_all_adds_the_joints_outside_the_tree(run: Parakin) -> None:
    assert run(*SOLVE, "-o", "all.csv", "--all", "--rate", "10")[0] == 0
    header, _ = read_csv(Path("all.csv").read_text())
    for name in ("B4.1", "C4.3", "D2", "E2", "B4.cone", "C4.cone"):
        assert f"{name}.position" in header


@pytest.mark.parametrize("suffix", [".csv", ".nc", ".parquet"])
def test_windows_are_written_as_one_result(
    suffix: str, solver: parakin.Solver, general: xr.Dataset, here: Path
) -> None:
    import pandas as pd

    motion = solver.motion("general")
    windows = list(solver.stream(motion, 700, bodies=True))
    assert [ds.sizes["time"] for ds in windows] == [700, 700, 700, 700, 201]
    datasets.write(windows, here / f"windows{suffix}")
    datasets.write([xr.concat(windows, "time", data_vars="minimal")], here / f"whole{suffix}")
    if suffix == ".csv":
        assert (here / "windows.csv").read_bytes() == (here / "whole.csv").read_bytes()
        assert (here / "windows.csv").read_text().count("time") == 1
    elif suffix == ".nc":
        with xr.open_dataset("windows.nc") as windowed, xr.open_dataset("whole.nc") as whole:
            xr.testing.assert_identical(windowed, whole)
            turned = "body_orientation"  # q and -q are the same orientation
            xr.testing.assert_allclose(
                windowed.drop_vars(turned), general.drop_vars(turned), rtol=1e-11, atol=1e-11
            )
            same = (windowed[turned] * general[turned]).sum("quaternion")
            np.testing.assert_allclose(abs(same), 1.0, rtol=1e-11)
    else:
        pd.testing.assert_frame_equal(
            pd.read_parquet("windows.parquet"), pd.read_parquet("whole.parquet"), check_exact=True
        )


def test_a_long_motion_is_written_in_windows_and_drawn(run: Parakin) -> None:
    code, _, err = run(*SOLVE, "--rate", "40000", "-o", "long.nc", "--plot", "long.png")
    assert code == 0
    assert "120,001 samples solved" in err
    with xr.open_dataset("long.nc") as ds:
        assert ds.sizes["time"] == 120_001
        np.testing.assert_allclose(np.diff(ds["time"]), 1 / 40000, rtol=1e-9)
        assert int(ds["status"].max()) == 0


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


# ---- options


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


def test_colours_are_obeyed_and_refused(run: Parakin, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    assert "\x1b[1;31merror" in run("check", "nothing")[2]
    assert "\x1b[" in run("check", "flight-simulator-upu")[1]
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[" not in run("check", "nothing")[2]
    assert "\x1b[" not in run("check", "flight-simulator-upu")[1]
    assert "\x1b[" not in run("list")[1]
    assert "\x1b[" not in run(*SOLVE, "--rate", "10")[2]


# ---- flagged samples


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
    others = [k for k, name in enumerate(header) if name not in ("time", "status")]
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


# ---- a process of its own


def process(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env=os.environ | environment,
    )


def test_python_m_parakin_and_version() -> None:
    done = process("-m", "parakin", "--version")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"parakin {parakin.__version__}\n"


def test_the_installed_script_runs() -> None:
    script = Path(sys.executable).with_name("parakin")
    if not script.exists():
        pytest.skip("parakin is not installed with its script")
    done = subprocess.run(
        [script, "list"], capture_output=True, text=True, check=False, timeout=600
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "flight-simulator" in done.stdout


def test_help_costs_no_heavy_import() -> None:
    done = process(
        "-c",
        "import sys\n"
        "from parakin.cli.main import main\n"
        "try:\n    main(['solve', '--help'])\nexcept SystemExit as end:\n    assert not end.code\n"
        "print('loaded:', *sorted(sys.modules))",
    )
    assert done.returncode == 0, done.stderr
    text, _, loaded = done.stdout.partition("loaded:")
    for option in ("-o", "--plot", "--bodies", "--rate", "--set"):
        assert option in text
    heavy = {"numpy", "scipy", "heyoka", "xarray", "pandas", "matplotlib", "pydantic", "pint"}
    assert not heavy & set(loaded.split())


def test_letters_that_the_terminal_lacks_are_spelt_out() -> None:
    done = process("-m", "parakin", "check", "flight-simulator", PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert r"Gr\xfcbler-Kutzbach: -3" in done.stdout


def test_a_reader_that_leaves_early_is_no_mistake() -> None:
    command = f"{sys.executable} -m parakin solve flight-simulator general -o - | head -n 1"
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env={k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"},
    )
    assert done.returncode == 0
    assert done.stdout.startswith("time,A1.position,")
    assert done.stdout.count("\n") == 1
    assert done.stderr == ""


def test_a_progress_bar_comes_only_when_it_takes_long(
    run: Parakin, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    assert "solving" not in run(*SOLVE, "--rate", "10")[2]
    monkeypatch.setattr("parakin.cli.run._PATIENCE", -1.0)
    assert "solving" in run(*SOLVE, "--rate", "10")[2]
    monkeypatch.delenv("FORCE_COLOR")
    assert "solving" not in run(*SOLVE, "--rate", "10")[2]


def test_an_interrupt_leaves_no_file(
    run: Parakin, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(windows: Iterator[xr.Dataset], stream: io.TextIOBase) -> None:
        stream.write("time,")
        next(windows)
        raise KeyboardInterrupt

    monkeypatch.setattr(datasets, "write_csv", interrupted)
    code, out, err = run(*SOLVE, "--rate", "10", "-o", "stopped.csv")
    assert (code, out, err) == (130, "", "stopped\n")
    assert not list(here.iterdir())


def test_figures_are_known_by_the_suffixes_told() -> None:
    assert plots.SUFFIXES == (".png", ".svg", ".pdf")
    assert datasets.SUFFIXES == (".csv", ".nc", ".parquet")


def test_checking_a_file_reads_its_motions_too(refusal: Refusal) -> None:
    text = Path("linkage.toml").read_text()
    Path("linkage.toml").write_text(
        text + '\n[motions.wrong]\nduration = "1 s"\nlaws = { A = { law = "cosin", by = 1 } }\n'
    )
    assert "motions.wrong.laws.A" in refusal("check", "linkage.toml")
