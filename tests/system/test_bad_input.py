"""Mechanisms that cannot be assembled or driven: one message, exit code 2, nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest
from linkage import LINKAGE, Refusal, edited

import parakin
from parakin import InputError


@pytest.fixture(autouse=True)
def _here(linkage_folder: Path) -> None:
    """Every test runs in the folder."""


def test_a_mechanism_that_cannot_be_assembled_names_the_joint_and_its_gap(
    refusal: Refusal,
) -> None:
    # The base is 3 m long, the crank, coupler and rocker 0.2 + 0.5 + 0.4 m.
    Path("linkage.toml").write_text(edited(LINKAGE, '"0.5 m"', '"3 m"'))
    message = refusal("check", "linkage.toml")
    assert message.startswith("linkage.toml: cannot be assembled from its guess; the largest gap")
    assert "at joint C: 1900 mm and 0 degrees" in message


@pytest.mark.parametrize("size", ["1e60", "1e160", "1e300", "-1e300"])
def test_dimensions_beyond_sense_are_refused_too(size: str, refusal: Refusal) -> None:
    said = refusal("check", "flight-simulator", "--set", f"d1={size}")
    assert ("cannot be assembled" if size == "1e60" else "expected less than 1e+100 m") in said


@pytest.mark.parametrize(
    ("driven", "said"),
    [
        ([], "no driven coordinates are given"),
        (["A", "A"], "a coordinate is driven twice: A, A"),
        (
            ["A", "D"],
            "(A, D), but only 1 can move independently near home: A, D depend on one another",
        ),
        (["a"], "found unknown coordinate 'a'; expected one of: A, B, C, D; did you mean"),
    ],
)
def test_driven_coordinates_that_do_not_fit_a_linkage(
    driven: list[str], said: str, refusal: Refusal
) -> None:
    Path("linkage.toml").write_text(edited(LINKAGE, '["A"]', f"{driven}"))
    message = refusal("solve", "linkage.toml", "motion.toml", "-o", "old.csv")
    assert message.startswith("linkage.toml: ")
    assert said in message


@pytest.mark.parametrize(
    ("driven", "reasons"),
    [
        (["platform.x"], ["mobility is 3", "1 coordinate is driven", "platform.phi"]),
        (["A2", "B3", "C3", "D1"], ["4 coordinates are driven", "only 3 can", "depend on one"]),
        (["platform.x", "platform.y", "platform.z"], ["only 2 can", "platform.z cannot move"]),
        (
            ["A4", "platform.x", "platform.phi"],
            ["only 2 can", ": A4, platform.phi depend on one another"],
        ),
    ],
)
def test_driven_coordinates_too_few_too_many_or_dependent(
    driven: list[str], reasons: list[str]
) -> None:
    with pytest.raises(parakin.DrivenError) as caught:
        parakin.compile("flight-simulator", driven, machine_code=False)
    for reason in (*reasons, *driven):
        assert reason in str(caught.value)


def test_a_mechanism_too_stiff_to_be_driven(refusal: Refusal) -> None:
    assert "but only 1 can move independently" in refusal(
        "solve", "flight-simulator-upu", "general", "-o", "old.csv"
    )


def test_a_motion_of_other_coordinates_is_refused_in_python_too() -> None:
    from parakin.motion.laws import constant, from_laws

    solver = parakin.compile("linkage.toml", machine_code=False)
    for laws in ({"B": constant(0.0)}, {"A": constant(0.0), "B": constant(0.0)}):
        with pytest.raises(InputError) as caught:
            solver.solve(from_laws("other", laws, 1.0, 10.0))
        assert "other" in caught.value.place
        assert "B" in caught.value.found
        assert "A" in caught.value.expected


def test_an_unknown_body_or_point_is_named() -> None:
    solver = parakin.compile("linkage.toml", machine_code=False)
    with pytest.raises(InputError) as caught:
        solver.solve("turn", bodies=["coupler.Q"])
    assert caught.value.found == "unknown body or point 'coupler.Q'"
    assert caught.value.expected.startswith("one of: base, coupler, coupler.P, crank, rocker")
