"""The oracle against the numbers printed in the notes, and against equations (1)-(11)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from closed_form import (
    MP,
    Number,
    Parameters,
    State,
    corrected_eq_11,
    example,
    home,
    home_inclinations,
    printed_eq_11,
    state,
)

P = Parameters()
SLIDERS = ("A2", "B3", "C3")
EXACT = MP.mpf("1e-35")


def agrees(value: Number, printed: str) -> bool:
    """Whether value rounds to the printed digits."""
    decimals = len(printed.partition(".")[2])
    return bool(abs(value - MP.mpf(printed)) <= MP.mpf("0.5000001") * MP.mpf(10) ** -decimals)


def at(n: int, t: Number) -> State:
    return state(P, *example(n, t))


@pytest.mark.parametrize(
    ("name", "printed"),
    [
        ("gamma0", "2.158"),
        ("alpha1", "66.7016"),
        ("alpha3", "55.7131"),
        ("alpha4", "125.1961"),
        ("alpha5", "64.753"),
    ],
)
def test_home_angles_in_degrees(name: str, printed: str) -> None:
    assert agrees(MP.degrees(getattr(home(P), name)), printed)


def test_home_inclination_of_the_rod() -> None:
    assert agrees(home(P).gamma0, "0.0376701440560")
    assert abs(home(P).alpha1 - home(P).alpha2 - home(P).gamma0) < EXACT
    papers, other = (MP.degrees(gamma) for gamma in home_inclinations(P))
    assert agrees(papers, "2.158")
    assert agrees(other, "152.233")


def test_home_lengths() -> None:
    assert agrees(home(P).s, "0.611555")
    assert agrees(home(P).A1A3, "1.140254")
    assert agrees(home(P).B1B4, "1.331353")
    assert abs(P.s_A + P.l1 - MP.mpf("1.14")) < EXACT
    assert abs(P.s_B + P.l2 - MP.mpf("1.33")) < EXACT
    assert agrees(1000 * at(1, 0)["A2"][0], "0.254")
    assert agrees(1000 * at(1, 0)["B3"][0], "1.353")
    assert agrees(1000 * at(1, 0)["C3"][0], "1.353")


def test_cranks_cross_at_home() -> None:
    """The segments D1D2 and E1E2 intersect: the ends of each lie on both sides of the other."""
    z = home(P)
    d1, e1 = MP.mpc(P.d2 + P.d3), MP.mpc(P.d2)
    d2, e2 = d1 + P.l3 * MP.expj(z.alpha4), e1 + P.l4 * MP.expj(z.alpha5)

    def left(p: Any, q: Any, r: Any) -> Number:
        return (MP.conj(q - p) * (r - p)).imag

    assert left(d1, d2, e1) * left(d1, d2, e2) < 0
    assert left(e1, e2, d1) * left(e1, e2, d2) < 0


@pytest.mark.parametrize(
    ("name", "printed"),
    [
        ("A2", ("0.0165156318", "0.0301135217", "0.0204906800")),
        ("B3", ("-0.0184882742", "-0.0286864726", "0.0113278630")),
        ("C3", ("0.1118410600", "0.2071525692", "0.1458868034")),
    ],
)
def test_reference_table(name: str, printed: tuple[str, str, str]) -> None:
    assert all(map(agrees, at(3, 1)[name], printed))


@pytest.mark.parametrize(
    ("n", "printed"),
    [
        (1, ("-0.03758", "0.16948", "0.16948")),
        (2, ("0.06943", "0.17281", "0.17281")),
        (3, ("0.06943", "-0.01972", "0.46829")),
    ],
)
def test_displacements_at_the_end(n: int, printed: tuple[str, str, str]) -> None:
    start, end = at(n, 0), at(n, 3)
    assert all(
        agrees(end[k][0] - start[k][0], text) for k, text in zip(SLIDERS, printed, strict=True)
    )


def test_parasitic_motion_depends_on_x_and_y_alone() -> None:
    printed = {1: "10.6", 2: "7.4", 3: "7.4"}
    assert all(agrees(MP.degrees(at(n, 3)["psi"][0]), text) for n, text in printed.items())
    assert at(2, "1.7")["psi"] == at(3, "1.7")["psi"]


def test_misprint_of_eq_11() -> None:
    yd = example(3, 1.5)[1]
    here = at(3, 1.5)
    assert agrees(here["C3"][1], "0.2491")
    assert agrees(corrected_eq_11(P, here, yd)[2], "0.2491")
    assert agrees(printed_eq_11(P, here, yd)[2], "0.2093")


@pytest.mark.parametrize("n", [1, 2, 3])
def test_eq_11_against_the_jets(n: int) -> None:
    for t in ("0.4", "1", "2.3"):
        here, yd = at(n, t), example(n, t)[1]
        exact = [here[name][1] for name in SLIDERS]
        corrected, printed = corrected_eq_11(P, here, yd), printed_eq_11(P, here, yd)
        assert all(abs(v - w) < EXACT for v, w in zip(corrected, exact, strict=True))
        assert all(abs(v - w) < EXACT for v, w in zip(printed[:2], exact[:2], strict=True))
        assert (abs(printed[2] - exact[2]) < EXACT) == (n < 3)  # phi = 0 hides the misprint


def test_jets_against_numerical_differentiation() -> None:
    t = MP.mpf("1.1")
    for name, (_, velocity, acceleration) in at(3, t).items():
        assert abs(MP.diff(lambda u, k=name: at(3, u)[k][0], t) - velocity) < EXACT
        assert abs(MP.diff(lambda u, k=name: at(3, u)[k][1], t) - acceleration) < EXACT


def rot_z(angle: Number) -> Any:
    """The paper's passive rot(z, angle)."""
    c, s = MP.cos(angle), MP.sin(angle)
    return MP.matrix([[c, s, 0], [-s, c, 0], [0, 0, 1]])


@pytest.mark.parametrize("t", ["0", "1", "2.6"])
def test_state_closes_the_loops_of_eq_7(t: str) -> None:
    """The matrices (1) and vectors (8) bring all five chains to G."""
    theta = MP.matrix([[0, 0, -1], [0, 1, 0], [1, 0, 0]])
    u1, u3 = MP.matrix([1, 0, 0]), MP.matrix([0, 0, 1])
    (x, y, phi), *_ = example(3, t)
    q = {name: values[0] for name, values in at(3, t).items()}

    a10 = rot_z(q["A1"])
    a20 = theta * a10
    a30 = rot_z(q["A3"]) * theta * a20
    a40 = rot_z(q["A4"]) * theta.T * a30
    b20 = rot_z(q["B1.2"]) * theta * rot_z(q["B1.1"])
    c20 = rot_z(q["C1.2"]) * theta.T * rot_z(q["C1.1"])
    foot = P.d2 + P.d3 + P.d4
    chains = (
        a10.T * u1 * (P.s_A + q["A2"]) + a20.T * u3 * P.l1 + a40.T * u3 * P.h,
        MP.matrix([foot, 0, P.d5])
        + b20.T * u1 * (P.s_B + q["B3"])
        + (theta * b20).T * u3 * P.l2
        + a40.T * u1 * P.b / 2,
        MP.matrix([foot, 0, -P.d5])
        + c20.T * u1 * (P.s_C + q["C3"])
        + (theta * c20).T * u3 * P.l2
        - a40.T * u1 * P.b / 2,
        u1 * (P.d2 + P.d3) + rot_z(q["D1"]).T * u1 * P.l3 + a30.T * u1 * (P.d1 - P.h),
        u1 * P.d2 + rot_z(q["E1"]).T * u1 * P.l4 + a30.T * u1 * (q["E2P"] + P.d1 - P.h),
    )
    assert all(MP.norm(chain - MP.matrix([x, y, 0])) < EXACT for chain in chains)

    orientation = MP.matrix(
        [[1, 0, 0], [0, MP.cos(phi), MP.sin(phi)], [0, -MP.sin(phi), MP.cos(phi)]]
    )
    assert MP.norm(theta.T * a40 - orientation * rot_z(q["gamma"])) < EXACT  # (3), (4)
    assert abs(q["A1"] - q["A3"] - q["gamma"]) < EXACT  # (5)


def test_out_of_reach() -> None:
    (x, y, phi), yd, ydd = example(1, 0)
    with pytest.raises(ValueError, match="out of reach"):
        state(P, (x, y + 2, phi), yd, ydd)
    with pytest.raises(ValueError, match="out of reach"):
        home(replace(P, l4=MP.mpf("0.9")))
