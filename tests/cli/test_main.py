"""Commands that do not solve, and parakin as a process."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from linkage import Refusal, process

import parakin
from parakin.files.reading import catalogue

Parakin = Callable[..., tuple[int, str, str]]


def lines(text: str) -> list[list[str]]:
    """A printed table by cells: what two or more spaces part."""
    return [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]


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
    code, out, err = run("check", "flight-simulator-upu")
    assert code == 2  # as when it is solved
    assert "3 coordinates are driven (platform.x, platform.y, platform.phi), but only 1" in err
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


@pytest.mark.parametrize("figure", [[], ["--plot", "general.png"]], ids=["table", "figure"])
def test_a_plain_solve_imports_only_what_it_uses(here: Path, figure: list[str]) -> None:
    """Results are plain arrays, tables are written without pandas, and common units are known."""
    command = ["solve", "flight-simulator", "general", "-o", "general.csv", *figure]
    done = process(
        "-c",
        "import sys\n"
        "from parakin.cli.main import main\n"
        f"assert main({command}) == 0\n"
        "print('loaded:', *sorted(sys.modules))",
    )
    assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.partition("loaded:")[2].split())
    assert {"numpy", "parakin.solving.solver"} <= loaded
    unused = {"pandas", "xarray", "pyarrow", "pint", "scipy", "dask", "h5netcdf", "h5py"}
    unused |= {"matplotlib.pyplot", "tkinter", "parakin.solving.modes", "parakin.design"}
    assert unused & loaded == set()
    assert ("matplotlib" in loaded) == bool(figure)


def test_checking_a_file_reads_its_motions_too(refusal: Refusal) -> None:
    text = Path("linkage.toml").read_text()
    Path("linkage.toml").write_text(
        text + '\n[motions.wrong]\nduration = "1 s"\nlaws = { A = { law = "cosin", by = 1 } }\n'
    )
    assert "motions.wrong.laws.A" in refusal("check", "linkage.toml")


@pytest.mark.skipif(sys.platform == "win32", reason="no such names")
def test_what_was_written_is_told_without_control_characters(run: Parakin) -> None:
    """They would be orders to the terminal."""
    for command in ("solve delta pick -o", "draw delta -o"):
        name = "red\x1b[31m" + (".csv" if command.startswith("solve") else ".svg")
        code, out, err = run(*command.split(), name)
        assert code == 0, err
        assert f"wrote {name!r}".replace("'", "") in out + err
