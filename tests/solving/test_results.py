"""Results plot with their units."""

from __future__ import annotations

import pytest

import parakin

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module", autouse=True)
def _without_a_screen() -> None:
    import matplotlib as mpl

    mpl.use("Agg")


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile("flight-simulator", machine_code=False, derivatives=3)


@pytest.mark.parametrize(
    ("coordinate", "quantity", "unit"),
    [
        ("A2", "position", "m"),
        ("A2", "velocity", "m s-1"),
        ("platform.phi", "acceleration", "rad s-2"),
        ("platform.phi", "jerk", "rad s-3"),
    ],
)
def test_a_history_plots_with_its_unit(
    coordinate: str, quantity: str, unit: str, solver: parakin.Solver
) -> None:
    from matplotlib import pyplot as plt

    result = solver.solve("general")
    (line,) = parakin.history(result, coordinate)[quantity].plot()  # type: ignore[call-arg]
    assert line.axes.get_xlabel() == "time [s]"
    label = " ".join(line.axes.get_ylabel().split())  # long ones are broken
    assert label == f"{quantity} of {coordinate} [{unit}]"
    assert line.axes.get_title() == f"coordinate = {coordinate}"
    plt.close("all")
    assert result[quantity].attrs["units"].startswith("m or rad")  # the result is left as it is


def test_a_result_of_lengths_alone_has_their_unit() -> None:
    from matplotlib import pyplot as plt

    sliders = parakin.compile("flight-simulator", coordinates=["A2", "B3"], machine_code=False)
    result = sliders.solve("general")
    lines = result["velocity"].plot.line(x="time")
    assert lines[0].axes.get_ylabel() == "velocity [m s-1]"
    plt.close("all")


def test_a_coordinate_that_is_not_in_the_result(solver: parakin.Solver) -> None:
    with pytest.raises(parakin.InputError, match="did you mean 'A2'"):
        parakin.history(solver.solve("general"), "a2")
