"""What the documents and examples show works as shown."""

from __future__ import annotations

import csv
import importlib
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import xarray as xr

import parakin
from parakin.cli.main import main
from parakin.files.mechanism_toml import mechanism_from_table

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.repository


def blocks(document: str, language: str) -> list[str]:
    text = (ROOT / document).read_text("utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def commands(document: str) -> list[list[str]]:
    """The commands of shell blocks, what stands between && apart."""
    lines = [line for block in blocks(document, "bash") for line in block.splitlines()]
    return [part.split() for line in lines for part in line.split(" && ")]


def test_the_readmes_first_command_leaves_a_table_and_a_figure(tmp_path: Path) -> None:
    (command,) = [c for c in commands("README.md") if c[0].endswith("/parakin")]
    run = subprocess.run(
        [sys.executable, "-m", "parakin", *command[1:]],
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    )
    assert run.stdout == ""
    assert "3,001 samples solved" in run.stderr
    assert (tmp_path / "general.csv").read_text().count("\n") == 3002
    assert (tmp_path / "general.png").read_bytes()[:4] == b"\x89PNG"


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder for what examples write."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("elsewhere")
def test_the_readmes_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    for code in blocks("README.md", "python"):
        exec(compile(code, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert "loops closed to" in said
    assert "converged" in said


@pytest.mark.usefixtures("elsewhere")
def test_the_guides_python_runs() -> None:
    names: dict[str, object] = {}
    for code in blocks("docs/guide.md", "python"):
        if "last.position" in code:
            names["last"] = parakin.compile("flight-simulator").at([1.85, 1.1, 0.0])
        exec(compile(code, "guide.md", "exec"), names)
    assert Path("delta.html").stat().st_size > 100_000


@pytest.mark.usefixtures("elsewhere")
def test_the_python_about_forces_runs(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {}
    for code in blocks("docs/forces.md", "python"):
        exec(compile(code, "forces.md", "exec"), names)
    assert "False\nTrue\n" in capsys.readouterr().out


@pytest.mark.usefixtures("elsewhere")
def test_the_python_about_simulation_runs(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {}
    for code in blocks("docs/simulation.md", "python"):
        exec(compile(code, "simulation.md", "exec"), names)
    told = re.findall(r"-?[\d.]+(?:e-?\d+)?", capsys.readouterr().out)
    height, drift, *rest = map(float, told)
    heights, frequencies = rest[:64], rest[64:]
    assert heights == sorted(heights, reverse=True)  # the heavier, the lower
    assert heights[0] < 1.05
    assert len(frequencies) == 6
    assert max(frequencies) < 1.0  # nothing holds it but constant efforts
    assert height < 1.1  # of what falls when a leg lets go
    assert drift < 1e-4
    settled = names["settled"]
    assert isinstance(settled, xr.Dataset)
    assert float(abs(settled["velocity"][-1]).max()) < 0.01


@pytest.mark.usefixtures("elsewhere")
def test_the_command_that_simulates_leaves_a_table_and_a_figure() -> None:
    (command,) = [c for c in commands("docs/simulation.md") if c[0] == "parakin"]
    Path("efforts.toml").write_text(
        '[efforts]\nP1 = "600 N"\nP2 = { law = "constant", value = 550 }\n'
    )
    assert main(command[1:]) == 0
    assert Path("fall.csv").read_text().count("\n") == 502
    assert Path("fall.png").read_bytes()[:4] == b"\x89PNG"
    payload = ("--payload", "100 kg at platform", "--hold", "--load", "payload=0")
    assert main(["simulate", "gough-stewart", *payload, "--duration", "20 ms", "-o", "up.csv"]) == 0
    first, *_, last = csv.DictReader(Path("up.csv").read_text().splitlines())
    assert float(last["platform.z.position"]) > float(first["platform.z.position"])


@pytest.mark.usefixtures("elsewhere")
def test_the_servo_in_the_document_about_simulation_is_read() -> None:
    (text,) = blocks("docs/simulation.md", "toml")
    Path("park.toml").write_text(text)
    hexapod = parakin.compile("gough-stewart")
    result = hexapod.simulate(0.2, "park.toml", hold=True, rate=100)
    leg = result.sel(coordinate="P1").position
    assert float(leg[-1]) < float(leg[0])


@pytest.mark.usefixtures("elsewhere")
def test_figures_of_simulations_are_drawn_by_the_example() -> None:
    script = [sys.executable, str(ROOT / "examples" / "simulations.py"), "drawn"]
    subprocess.run(script, check=True, capture_output=True)
    made = {path.name for path in Path("drawn").iterdir()}
    assert made == set(
        re.findall(r"figures/([\w.-]+)\)", (ROOT / "docs" / "simulation.md").read_text())
    )


def test_the_rig_in_the_document_about_design_is_the_examples() -> None:
    (text,) = blocks("docs/design.md", "toml")
    assert text == (ROOT / "examples" / "rig.toml").read_text("utf-8")


@pytest.mark.usefixtures("elsewhere")
def test_commands_about_design_say_what_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(ROOT / "examples" / "rig.toml", "rig.toml")
    text = (ROOT / "docs" / "design.md").read_text("utf-8")
    shown = re.findall(
        r"^```bash\nparakin ([^\n]*)\n```\n\n```text\n(.*?)^```$", text, re.DOTALL | re.M
    )
    assert len(shown) == 9
    for command, expected in shown:
        main(shlex.split(command))
        said = capsys.readouterr().out.splitlines()
        assert [line.rstrip() for line in said] == expected.splitlines()


@pytest.mark.usefixtures("elsewhere")
def test_the_other_commands_about_design_run() -> None:
    shutil.copy(ROOT / "examples" / "rig.toml", "rig.toml")
    ranges = [b for b in blocks("docs/design.md", "bash") if "parakin range" in b]
    others = [b for b in ranges if "--pairs" in b or "payload" in b]
    assert [main(shlex.split(block)[1:]) for block in others] == [0, 0]
    assert Path("range.png").read_bytes()[:4] == b"\x89PNG"
    assert Path("range.csv").read_text().count("\n") == 1 + 12 + 15 * 72


@pytest.mark.usefixtures("elsewhere")
def test_commands_about_workspaces_write_what_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(ROOT / "examples" / "rig.toml", "rig.toml")
    drawing = [b for b in blocks("docs/design.md", "bash") if "workspace" in b and "--plot" in b]
    assert [main(shlex.split(block)[1:]) for block in drawing] == [0, 0, 0]
    assert {path.name for path in Path().iterdir()} == {
        *("rig.toml", "slice.png", "slice.csv", "surface.png", "surface.stl", "forces.png")
    }
    (told,) = re.findall(
        r"The volume there is (.*?)\.\s", Path(ROOT / "docs/design.md").read_text()
    )
    assert f"volume {told}\n" in capsys.readouterr().out


@pytest.mark.usefixtures("elsewhere")
def test_the_python_about_design_runs(capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(ROOT / "examples" / "rig.toml", "rig.toml")
    names: dict[str, object] = {}
    for code in blocks("docs/design.md", "python"):
        exec(compile(code, "design.md", "exec"), names)
    ends, words, length, _, size, node, proof, stroke = capsys.readouterr().out.splitlines()
    assert 0.0 < float(size.split()[1]) < 1e-3 * float(size.split()[0])
    assert node.startswith("True")
    assert [float(end) for end in ends.strip("[]").split()] == pytest.approx(
        [-0.18699, 0.12622], abs=1e-5
    )
    assert words == "P4 > 1.26 m"
    assert float(length) == pytest.approx(1.26, abs=1e-12)
    assert proof.startswith("proved ")
    assert all(0.86 < float(end) < 1.26 for end in stroke.split())


@pytest.mark.usefixtures("elsewhere")
def test_the_python_about_other_designs_says_what_is_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    shutil.copy(ROOT / "examples" / "rig.toml", "rig.toml")
    names: dict[str, object] = {}
    for code in blocks("docs/designs.md", "python"):
        exec(compile(code, "designs.md", "exec"), names)
    said = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert said == "".join(blocks("docs/designs.md", "text")).splitlines()


@pytest.mark.usefixtures("elsewhere")
def test_the_figure_of_a_range_is_drawn_by_the_example() -> None:
    script = [sys.executable, str(ROOT / "examples" / "range.py"), "drawn"]
    subprocess.run(script, check=True, capture_output=True)
    (made,) = Path("drawn").iterdir()
    assert f"figures/{made.name})" in (ROOT / "docs" / "design.md").read_text("utf-8")


@pytest.mark.usefixtures("elsewhere")
def test_the_figures_of_workspaces_are_drawn_by_the_example() -> None:
    script = [sys.executable, str(ROOT / "examples" / "workspace.py"), "drawn"]
    subprocess.run(script, check=True, capture_output=True)
    text = (ROOT / "docs" / "design.md").read_text("utf-8")
    made = {path.name for path in Path("drawn").iterdir()}
    assert made == set(re.findall(r"figures/(workspace[\w.-]+)\)", text))


@pytest.mark.usefixtures("elsewhere")
def test_forces_by_hand_are_those_shown(capsys: pytest.CaptureFixture[str]) -> None:
    pendulum, shaking, hexapod = blocks("docs/mechanics.md", "python")
    names: dict[str, object] = {}
    exec(compile(pendulum, "mechanics.md", "exec"), names)
    found, by_hand = map(float, capsys.readouterr().out.split())
    assert found == pytest.approx(by_hand)
    exec(compile(shaking, "mechanics.md", "exec"), names)
    assert float(capsys.readouterr().out.split()[-2]) < 1e-9
    exec(compile(hexapod, "mechanics.md", "exec"), names)
    *legs, expected = map(float, re.findall(r"[\d.]+", capsys.readouterr().out))
    assert legs == pytest.approx([expected] * 6, rel=1e-6)


def test_the_tables_about_forces_are_read(tmp_path: Path) -> None:
    bodies, joint, acting = blocks("docs/forces.md", "toml")
    text = f"""name = "rig"
driven = ["P1"]
{bodies}
points = {{}}
[bodies.cylinder]
[bodies.piston]
[joints.F]
kind = "fixed"
parent = "base"
child = "cylinder"
[joints.H]
kind = "fixed"
parent = "piston"
child = "leg"
[joints.G]
kind = "fixed"
parent = "leg"
child = "platform"
{joint}{acting}"""
    text = text.replace("inertia = [", "points = { hook = [1, 0, 0] }\ninertia = [", 1)
    (tmp_path / "rig.toml").write_text(text)
    assert parakin.compile(tmp_path / "rig.toml").at([0.1], forces=True, loads={"gust": 1}).forces


@pytest.mark.usefixtures("elsewhere")
def test_the_mechanism_of_the_file_format_is_the_one_in_python(tmp_path: Path) -> None:
    text = blocks("docs/mechanism-files.md", "toml")[0]
    path = tmp_path / "slider-crank.toml"
    path.write_text(text)
    result = parakin.compile(path).solve("turn")
    assert not result.status.any()
    names: dict[str, object] = {}
    for code in blocks("docs/mechanism-files.md", "python"):
        exec(compile(code, "mechanism-files.md", "exec"), names)
    solver = names["solver"]
    assert isinstance(solver, parakin.Solver)
    home = parakin.compile(path).home
    assert solver.home == pytest.approx(home, abs=1e-14)


def test_the_platform_table_of_the_file_format_is_read() -> None:
    (text,) = [t for t in blocks("docs/mechanism-files.md", "toml") if t.startswith("[platform]")]
    table = tomllib.loads(text)
    table |= {"name": "t", "bodies": {"platform": {"points": {"G": [0, 0, 0]}}}}
    table |= {"joints": {"J": {"kind": "spherical", "parent": "base", "child": "platform"}}}
    assert mechanism_from_table(table, "t").platform is not None


def test_the_motion_of_the_guide_is_read(tmp_path: Path) -> None:
    (text,) = blocks("docs/guide.md", "toml")
    path = tmp_path / "shake.toml"
    path.write_text(text)
    result = parakin.compile("flight-simulator").solve(str(path))
    assert not result.status.any()


def test_the_figures_are_drawn_by_the_example(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, str(ROOT / "examples" / "paper_figures.py"), str(tmp_path)],
        check=True,
        capture_output=True,
    )
    made = {path.name for path in tmp_path.iterdir()}
    shown = set(re.findall(r"figures/([\w.-]+)\)", (ROOT / "docs" / "paper.md").read_text()))
    assert shown <= made
    assert {f"figure-{n:02d}.{s}" for n in range(3, 12) for s in ("png", "svg")} <= made


def resolved(dotted: str) -> object:
    """What a dotted name within parakin stands for."""
    parts = dotted.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module("parakin." + ".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            annotated = getattr(found, "__annotations__", {})
            found = annotated[part] if part in annotated else getattr(found, part)
        return found
    raise AssertionError(dotted)


@pytest.mark.parametrize("document", ["notation.md", "paper.md", "mechanics.md"])
def test_every_name_beside_a_word_or_an_equation_is_one_of_the_code(document: str) -> None:
    text = (ROOT / "docs" / document).read_text("utf-8")
    packages = "algebra|model|motion|files|kinematics|mechanics|planning|kernel|solving|analysis"
    names = re.findall(rf"`((?:{packages})\.[\w.]+)`", text)
    assert len(names) > 5
    for name in names:
        resolved(name)


def test_every_test_that_the_paper_page_names_exists() -> None:
    text = (ROOT / "docs" / "paper.md").read_text("utf-8")
    named = re.findall(r"`(?:([\w/]+\.py)::)?(test_\w+)`", text)
    assert len(named) > 5
    sources = {
        p.relative_to(ROOT / "tests"): p.read_text("utf-8")
        for p in (ROOT / "tests").rglob("test_*.py")
    }
    for path, test in named:
        within = [sources[Path(path)]] if path else list(sources.values())
        assert any(f"def {test}(" in source for source in within), test


def test_what_is_cited_is_this_version() -> None:
    cited = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {parakin.__version__}\n" in cited
