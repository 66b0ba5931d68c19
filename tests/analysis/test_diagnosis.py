"""What `check` finds wrong, and its exit codes."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import parakin
from parakin import DrivenError
from parakin.cli.main import main

LINKAGE = """\
name = "linkage"
driven = ["A"]
[bodies]
crank = {}
[joints]
A = { kind = "revolute", parent = "base", child = "crank", actuated = true }
"""


def given(tmp_path: Path, more: str = "", old: str = "", new: str = "") -> Path:
    path = tmp_path / "linkage.toml"
    path.write_text(LINKAGE.replace(old, new) + more, "utf-8")
    return path


def code(path: Path) -> int:
    return main(["check", str(path)])


def test_nothing_wrong_is_0(tmp_path: Path) -> None:
    assert code(given(tmp_path)) == 0
    assert parakin.check(given(tmp_path)).warnings == ()


@pytest.mark.parametrize(
    ("driven", "said"),
    [
        ('["A"]', None),
        ("[]", "no driven coordinates are given"),
        ('["A", "A"]', "driven twice"),
    ],
)
def test_what_solve_would_refuse_is_2(tmp_path: Path, driven: str, said: str | None) -> None:
    path = given(tmp_path, old='["A"]', new=driven)
    refusal = parakin.check(path).refusal
    assert (refusal is None) == (said is None)
    if said is not None:
        assert said in str(refusal)
        with pytest.raises(DrivenError) as error:
            parakin.compile(path)
        assert str(error.value) == str(refusal)
    assert code(path) == (0 if said is None else 2)


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ('csv = "missing.csv"', "missing.csv: found no such file"),
        ("law = {}", "forces.w.law"),
        ('law = { law = "nonsense" }', "'nonsense'"),
        ('law = { law = "sine", amplitude = 1, frequency = 1e300 }', "at most 1e+12 Hz"),
    ],
)
def test_forces_over_time_that_cannot_be_had_are_2(
    tmp_path: Path, over: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    more = f'[forces.w]\nkind = "wrench"\nat = "crank"\n{over}\n'
    assert code(given(tmp_path, more)) == 2
    assert said in capsys.readouterr().err


def test_too_few_driven_is_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more = 'B = { kind = "revolute", parent = "crank", child = "rod" }\n[bodies.rod]\n'
    assert code(given(tmp_path, more)) == 2
    out, err = capsys.readouterr()
    assert "1 more freedom than driven coordinates" in out  # the report is printed all the same
    assert "mobility is 2 near home, but 1 coordinate is driven" in err


def test_home_outside_limits_is_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert code(given(tmp_path, '[limits]\nA = ["10 deg", "90 deg"]\n')) == 1
    said = capsys.readouterr().out
    assert "warning: home is outside limits: A at 0.000°, limit 10.000°" in said
    assert "warning: home is flagged: A at 0.000°, limit 10.000°" in said


def test_a_cone_is_told_too(tmp_path: Path) -> None:
    path = given(
        tmp_path,
        "[limits]\nS.cone = [0, 0.1]\n[home]\nS.1 = 0.3\n",
        'A = { kind = "revolute", parent = "base", child = "crank", actuated = true }\n',
        'S = { kind = "spherical", parent = "base", child = "crank", on_parent.x = [1, 0, 0] }\n',
    )
    text = path.read_text().replace('driven = ["A"]', 'driven = ["S.1", "S.2", "S.3"]')
    path.write_text(text)
    assert parakin.check(path).warnings == (
        "home is outside limits: S.cone at 17.189°, limit 5.730°",
        "home is flagged: S.cone at 17.189°, limit 5.730°",
    )
    assert math.degrees(0.3) == pytest.approx(17.189, abs=1e-3)


def test_a_motion_whose_first_sample_is_flagged_is_1(tmp_path: Path) -> None:
    motion = '[motions.go]\nduration = "1 s"\nlaws = { A = { law = "sine", amplitude = 0.1, '
    motion += 'frequency = "1 Hz" } }\n[limits]\nA.velocity = [-0.5, 0.5]\n'
    path = given(tmp_path, motion)
    (warning,) = parakin.check(path).warnings
    assert warning.startswith("motion go: the first sample is flagged: limit exceeded: A.velocity")
    assert code(path) == 1


@pytest.mark.parametrize(
    ("more", "old", "new", "place"),
    [
        ("[guess]\nA = 90\n", "", "", "guess.A = 90"),
        ("", "true }", 'true, on_parent.turns = [["x", 30]] }', "joints.A.on_parent.turns[0] = 30"),
        ("[limits]\nA = [-45, 45]\n", "", "", "limits.A = 45"),
        (
            '[motions.go]\nduration = "1 s"\n'
            'laws = { A = { law = "cosine", by = 30, over = "1 s" } }\n',
            "",
            "",
            "motions.go, by = 30",
        ),
    ],
)
def test_bare_angles_above_a_turn_are_1(
    tmp_path: Path, more: str, old: str, new: str, place: str
) -> None:
    path = given(tmp_path, more.replace(', over = "1 s"', ""), old, new)
    (warning,) = [each for each in parakin.check(path).warnings if "radians" in each]
    assert place in warning
    assert " deg' was meant" in warning
    assert code(path) == 1


def test_angles_that_say_their_unit_are_none(tmp_path: Path) -> None:
    more = '[limits]\nA = ["-720 deg", "4*pi"]\n[guess]\nA = 1.5\n'
    assert code(given(tmp_path, more)) in (0, 1)
    assert not any("radians" in each for each in parakin.check(given(tmp_path, more)).warnings)


@pytest.mark.parametrize(("length", "warned"), [("850", True), ("0.85", False), ("'850 m'", False)])
def test_bare_lengths_that_make_it_a_kilometre_wide_are_1(
    tmp_path: Path, length: str, warned: bool
) -> None:
    arm = f"on_parent.at = [{length}, 0, 0]"
    more = f'B = {{ kind = "revolute", parent = "crank", child = "rod", {arm} }}\n[bodies.rod]\n'
    path = given(tmp_path, more, '["A"]', '["A", "B"]')
    warnings = parakin.check(path).warnings
    assert code(path) == int(warned)
    assert any("850 m wide" in each and "'850 mm' was meant" in each for each in warnings) == warned


def test_a_home_far_from_its_guess_is_1(tmp_path: Path) -> None:
    # Neither of the two ways in which the four-bar closes is near.
    path = tmp_path / "other.toml"
    guess = '[guess]\nB = "100 deg"\nD = "-30 deg"\n'
    path.write_text(f'name = "other"\nvariant_of = "four-bar"\n{guess}', "utf-8")
    (warning,) = parakin.check(path).warnings
    assert warning.startswith("far from the guess, or of opposite sign: B, D.")
    assert code(path) == 1


@pytest.mark.parametrize("name", sorted(parakin.catalogue()))
def test_the_catalogue_is_sound(name: str) -> None:
    found = parakin.check(name)
    assert found.warnings == ()
    assert (found.refusal is None) == (name != "flight-simulator-upu")


def test_a_parameter_in_bare_degrees_is_told_where_its_sine_is_taken(tmp_path: Path) -> None:
    more = '[parameters]\nq = 20\nr = "20 deg"\nn = 20\n'
    arm = 'B = { kind = "revolute", parent = "crank", child = "rod", on_parent.at = '
    more = f'{arm}["cos(q)", "sin(r)", "n/20"] }}\n[bodies.rod]\n{more}'
    (warning,) = parakin.check(given(tmp_path, more, '["A"]', '["A", "B"]')).warnings
    assert "parameters.q = 20. Perhaps '20 deg' was meant" in warning


def test_a_choice_that_cannot_be_driven_is_told_before_its_motions(tmp_path: Path) -> None:
    path = tmp_path / "few.toml"
    path.write_text('name = "few"\nvariant_of = "gough-stewart"\ndriven = ["platform.x"]\n')
    assert "mobility is 6" in str(parakin.check(path).refusal)
