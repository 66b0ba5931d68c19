"""Each command's function does what the command does, and the front shows all of them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import pandas as pd
import pytest

import parakin
from parakin.cli.main import main

pytest.importorskip("matplotlib")
VERBS = {
    *("load", "catalogue", "check", "compile", "modes", "singularities", "plot", "draw", "film"),
    *("report", "view", "export", "save", "record"),
}


def test_the_front_shows_what_there_is() -> None:
    assert set(dir(parakin)) >= VERBS | {"Mechanism", "Solver", "Tick", "Status", "InputError"}
    for name in dir(parakin):
        assert getattr(parakin, name).__doc__


def test_importing_costs_nothing() -> None:
    heavy = "numpy", "xarray", "heyoka", "matplotlib", "pydantic"
    said = f"import parakin, sys; print([m for m in {heavy} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


@pytest.mark.parametrize("given", ["delta", parakin.load("delta")], ids=["name", "mechanism"])
def test_check(given: str | parakin.Mechanism) -> None:
    """A Delta with balls has three freedoms."""
    found = parakin.check(given)
    assert found.mobility.generic == 3
    assert (found.refusal, found.warnings) == (None, ())


def test_check_reads_the_motions_as_the_command_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    motion = '[motions.bad]\nduration = "1 s"\nlaws = { A = { law = "leap" } }\n'
    path.write_text(f'name = "mine"\nvariant_of = "four-bar"\n{motion}', "utf-8")
    with pytest.raises(parakin.InputError, match=r"motions\.bad") as error:
        parakin.check(path)
    assert main(["check", str(path)]) == 2
    assert str(error.value) in capsys.readouterr().err


def test_draw_as_the_command_does(tmp_path: Path) -> None:
    parakin.draw("four-bar", tmp_path / "one.svg")
    assert main(["draw", "four-bar", "-o", str(tmp_path / "other.svg")]) == 0
    assert (tmp_path / "one.svg").read_text() == (tmp_path / "other.svg").read_text()


def test_plot(tmp_path: Path) -> None:
    result = parakin.compile("four-bar").solve("turn")
    figure = parakin.plot(result, tmp_path / "turn.png", title="a turn")
    assert len(figure.axes) == 3  # position, velocity, acceleration of one angle
    assert figure.axes[0].get_legend_handles_labels()[1] == ["A"]
    figure = parakin.plot(result, coordinates=["D"], symbols={"D": r"\delta"})
    assert figure.axes[0].get_legend_handles_labels()[1] == [r"$\delta$"]
    assert main(["plot", "four-bar", "turn", "-o", str(tmp_path / "other.png")]) == 0
    for name in ("turn.png", "other.png"):
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG"


def test_film(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    image = pytest.importorskip("PIL.Image")
    solver = parakin.compile("four-bar")
    parakin.film(solver, solver.motion("turn", rate=20.0), tmp_path / "one.gif")
    arguments = ["film", "four-bar", "turn", "--rate", "20", "-o", str(tmp_path / "other.gif")]
    assert main(arguments) == 0
    with image.open(tmp_path / "one.gif") as one, image.open(tmp_path / "other.gif") as other:
        assert one.n_frames == other.n_frames > 10
    assert str(tmp_path / "other.gif") in capsys.readouterr().err


def test_report_as_the_command_does(tmp_path: Path) -> None:
    parakin.report("four-bar", "turn", tmp_path / "one.html")
    assert main(["report", "four-bar", "turn", "-o", str(tmp_path / "other.html")]) == 0
    one, other = ((tmp_path / n).read_text("utf-8") for n in ("one.html", "other.html"))

    def body(page: str) -> str:  # without when and by what it was made
        return re.sub(r"(?s)<footer.*?</footer>", "", page)

    assert body(one) == body(other) != ""
    assert "parakin.report(&#x27;four-bar&#x27;" in one


def test_report_of_a_motion_made_in_python(tmp_path: Path) -> None:
    motion = parakin.compile("four-bar").motion("turn", rate=50.0)
    parakin.report("four-bar", motion, tmp_path / "turn.html")
    assert "51 samples" in (tmp_path / "turn.html").read_text("utf-8")


def test_export_as_the_command_does(tmp_path: Path) -> None:
    (tmp_path / "one").mkdir()
    (tmp_path / "other").mkdir()
    written = parakin.export("four-bar", tmp_path / "one" / "kernel.c")
    assert main(["export", "four-bar", str(tmp_path / "other" / "kernel.c")]) == 0
    for path in written:
        assert path.read_text() == (tmp_path / "other" / path.name).read_text()
    assert len(written) == 3


def test_save(tmp_path: Path) -> None:
    solver = parakin.compile("four-bar")
    motion = solver.motion("turn", rate=50.0)
    parakin.save(solver.solve(motion), tmp_path / "one.csv")
    parakin.save(solver.stream(motion, 7), tmp_path / "windows.csv")
    one, windows = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("one", "windows"))
    pd.testing.assert_frame_equal(one, windows, rtol=0, atol=1e-12)
    assert len(one) == motion.count
    command = ["solve", "four-bar", "turn", "--rate", "50", "-o", str(tmp_path / "other.csv")]
    assert main(command) == 0
    pd.testing.assert_frame_equal(one, pd.read_csv(tmp_path / "other.csv"))


def test_record_and_view(tmp_path: Path) -> None:
    pytest.importorskip("viser")
    parakin.record("four-bar", "turn", tmp_path / "turn.html")
    assert "<html" in (tmp_path / "turn.html").read_text("utf-8")[:400]
    with parakin.view("four-bar", port=0) as viewer, urlopen(viewer.url) as page:
        assert page.status == 200


def test_a_mechanism_made_in_python_is_recorded_and_viewed(tmp_path: Path) -> None:
    pytest.importorskip("viser")
    mechanism = parakin.load("four-bar", {"b": "130 mm"})
    motion = tmp_path / "rock.toml"
    law = 'laws = { A = { law = "poly345", by = "9 deg" } }'
    motion.write_text(f'duration = "1 s"\nrate = 50\n{law}\n', "utf-8")
    parakin.record(mechanism, motion, tmp_path / "rock.html")
    assert (tmp_path / "rock.html").stat().st_size > 10_000
    with parakin.view(mechanism, [motion], port=0) as viewer:
        loaded = viewer.content.load("four-bar")
        assert loaded.mechanism is mechanism
        assert loaded.motions == (*mechanism.motions, str(motion))
    with parakin.view("four-bar", parameters={"b": "130 mm"}, port=0) as viewer:
        assert viewer.content.load("four-bar").graph.parameters["b"] == 0.13


@pytest.mark.parametrize(
    ("verb", "arguments"),
    [
        (parakin.draw, ("four-bar", "scheme.txt")),
        (parakin.report, ("four-bar", "turn", "page.pdf")),
        (parakin.record, ("four-bar", "turn", "scene.mp4")),
        (parakin.export, ("four-bar", "model.step")),
        (parakin.check, ("five-barr",)),
    ],
)
def test_what_cannot_be_is_refused_at_once(verb: object, arguments: tuple[str, ...]) -> None:
    assert callable(verb)
    with pytest.raises(parakin.InputError):
        verb(*arguments)
    assert not any(Path(name).exists() for name in arguments)


def test_plot_takes_the_coordinates_that_the_command_takes(tmp_path: Path) -> None:
    result = parakin.compile("four-bar", coordinates="all").solve("turn")
    figure = parakin.plot(result, coordinates=["B", "D"])
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert len(legend.get_texts()) == 2
    arguments = ["plot", "four-bar", "turn", "--coordinates", "B, D"]
    assert main([*arguments, "-o", str(tmp_path / "some.png")]) == 0
    assert (tmp_path / "some.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize("names", [["X"], [], ["B", "B"]])
def test_coordinates_that_a_result_does_not_have_are_refused(
    names: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = parakin.compile("four-bar").solve("turn")
    with pytest.raises(parakin.InputError, match="coordinates"):
        parakin.plot(result, coordinates=names)
    path = tmp_path / "none.png"
    assert (
        main(["plot", "four-bar", "turn", "--coordinates", ",".join(names), "-o", str(path)]) == 2
    )
    assert "error: coordinates: found " in capsys.readouterr().err
    assert not path.exists()


def test_motions_are_made_from_public_names() -> None:
    law = parakin.laws.cosine(0.0, 0.1, 1.0)
    made = parakin.from_laws("nod", {"A": law}, 1.0, 10.0)
    assert made.count == 11
    time = [0.1 * k for k in range(11)]
    sampled = parakin.from_arrays("nod", ("A",), time, [[t * t for t in time]])
    assert sampled.coordinates == made.coordinates == ("A",)
