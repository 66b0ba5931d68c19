"""Masses, damping and friction of URDF: efforts against Pinocchio's, and what is left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from weighty import efforts, masses

import parakin
from parakin.errors import InputError
from parakin.model.evaluation import graph_of

pytest.importorskip("lxml")

Rng = np.random.Generator
KINDS = ("revolute", "continuous", "prismatic", "fixed")


def text_of(values: object) -> str:
    return " ".join(repr(float(v)) for v in np.atleast_1d(values))  # type: ignore[call-overload]


def origin(rng: Rng) -> str:
    return f'<origin xyz="{text_of(rng.normal(size=3))}" rpy="{text_of(rng.normal(size=3))}"/>'


def inertial(rng: Rng) -> str:
    """Of six masses at random points."""
    points = rng.normal(size=(6, 3)) * 0.3
    tensor = np.einsum("ij,ij->", points, points) * np.eye(3) - points.T @ points
    six = {f"i{'xyz'[i]}{'xyz'[j]}": tensor[i, j] for i in range(3) for j in range(i, 3)}
    told = " ".join(f'{key}="{value!r}"' for key, value in six.items()).replace("np.float64", "")
    told = told.replace("(", "").replace(")", "")
    return (
        f'<inertial>{origin(rng)}<mass value="{6 * rng.random()!r}"/><inertia {told}/></inertial>'
    )


def tree(rng: Rng, count: int = 8) -> str:
    """A random tree of links."""
    made = ['<link name="l0"/>']
    for k in range(1, count):
        kind = KINDS[0] if k == 1 else str(rng.choice(KINDS))
        weight = inertial(rng) if k in (1, count - 1) or rng.random() < 0.8 else ""
        axis = rng.normal(size=3)
        inside = f'<axis xyz="{text_of(axis / np.linalg.norm(axis))}"/>'
        if kind in ("revolute", "prismatic"):
            inside += '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
        if rng.random() < 0.5:
            inside += f'<dynamics damping="{rng.random()!r}" friction="{rng.random()!r}"/>'
        parent = f"l{rng.integers(max(0, k - 2), k)}"
        made.append(
            f'<link name="l{k}">{weight}</link><joint name="j{k}" type="{kind}">{origin(rng)}'
            f'<parent link="{parent}"/><child link="l{k}"/>{inside}</joint>'
        )
    return '<robot name="tree">' + "\n".join(made) + "</robot>"


@pytest.mark.parametrize("seed", range(12))
def test_efforts_of_random_trees_are_those_of_pinocchio(seed: int, tmp_path: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(seed)
    text = tree(rng)
    (tmp_path / "tree.urdf").write_text(text)
    mechanism = parakin.load(tmp_path / "tree.urdf")
    names = [c.name for c in graph_of(mechanism).coordinates]
    q, qd, qdd = rng.normal(size=(3, len(names)))
    model = pinocchio.buildModelFromXML(text)
    model.gravity.linear = np.array([0.0, 0.0, -9.80665])
    at, v, a = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    rows = []
    for name, value, rate, second in zip(names, q, qd, qdd, strict=True):
        joint = model.joints[model.getJointId(name)]
        turns = joint.nq == 2  # a continuous joint, by its cosine and sine
        at[joint.idx_q : joint.idx_q + joint.nq] = (
            [np.cos(value), np.sin(value)] if turns else [value]
        )
        v[joint.idx_v], a[joint.idx_v] = rate, second
        rows.append(joint.idx_v)
    expected = pinocchio.rnea(model, model.createData(), at, v, a)
    expected = expected + model.damping * v + model.friction * np.sign(v)
    found = efforts(mechanism, q, qd, qdd)
    size = np.abs(expected).max()
    np.testing.assert_allclose(found / size, expected[rows] / size, rtol=0, atol=1e-9)


ONE = """<robot name="one"><link name="base"/><link name="a">{}</link>
<joint name="j" type="{}"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>{}</joint>
{}</robot>"""
BALL = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="{}"/></inertial>'


def loaded(folder: Path, *parts: str) -> parakin.Mechanism:
    (folder / "one.urdf").write_text(ONE.format(*parts))
    return parakin.load(folder / "one.urdf")


def test_links_that_are_fixed_to_one_another_weigh_together(tmp_path: Path) -> None:
    """Two balls of 2 kg, 1 kg m² each, a metre apart: 2 m² · 1 kg more about their middle."""
    more = (
        f'<link name="b">{BALL.format(1)}</link><joint name="f" type="fixed"><origin xyz="1 0 0"/>'
        '<parent link="a"/><child link="b"/></joint>'
    )
    mechanism = loaded(tmp_path, BALL.format(1), "continuous", "", more)
    (found,) = masses(graph_of(mechanism)).values()
    np.testing.assert_allclose(found, [4, 0.5, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 3], atol=1e-14)


def test_what_has_no_counterpart_is_told(tmp_path: Path) -> None:
    resisted = '<dynamics damping="1" rotor_inertia="2"/>'
    said = loaded(tmp_path, BALL.format(3), "continuous", resisted, "").notes
    assert "with inertias that no body has: a (principal moments 1, 1, 3 kg m²)." in said
    assert "Not used: rotor_inertia of 'j'." in said
    said = loaded(tmp_path, BALL.format(1), "spherical", resisted, "").notes
    assert "<dynamics> of 'j', a spherical joint." in said


SCREW = """<robot name="s"><link name="base"/><link name="n">{}</link><link name="a"/>
<joint name="h" type="continuous"><parent link="base"/><child link="n"/><axis xyz="0 0 1"/>
<dynamics damping="1" friction="2"/></joint>
<joint name="s" type="prismatic"><parent link="n"/><child link="a"/><axis xyz="0 0 1"/>
<mimic joint="h" multiplier="0.5"/><dynamics damping="4" friction="2"/></joint></robot>"""


def test_a_screw_resists_as_its_parts_and_has_no_body_within(tmp_path: Path) -> None:
    (tmp_path / "s.urdf").write_text(SCREW.format(BALL.format(1)))
    mechanism = parakin.load(tmp_path / "s.urdf")
    assert "Masses left out of links within screws: n." in mechanism.notes
    (passive,) = graph_of(mechanism).dynamics.passive.values()
    assert (passive.viscous, passive.coulomb) == (1 + 0.25 * 4, 2 + 0.5 * 2)


def test_a_joint_whose_kind_the_file_of_loops_changes_loses_what_it_met(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    more = (
        f'<link name="b">{BALL.format(1)}</link><joint name="k" type="continuous">'
        '<parent link="a"/><child link="b"/><dynamics damping="1"/></joint>'
        '<link name="e"/><joint name="f" type="fixed"><parent link="b"/><child link="e"/></joint>'
        '<link name="g"/><joint name="d" type="fixed"><parent link="base"/><child link="g"/>'
        "</joint>"
    )
    (tmp_path / "one.urdf").write_text(ONE.format("", "continuous", "", more))
    (tmp_path / "l.yaml").write_text(
        "closed_loop: [[e, g]]\ntype: [3d]\njoint_name: [k]\njoint_type: [SPHERICAL]\n"
    )
    mechanism = parakin.load(tmp_path / "one.urdf", loops=tmp_path / "l.yaml")
    assert "Not used: <dynamics> of 'k', whose kind is changed." in mechanism.notes
    assert not any(joint.friction for joint in mechanism.joints)


@pytest.mark.parametrize(
    ("inside", "after", "said"),
    [
        ('<inertial><mass value="-1"/></inertial>', "", "inertial of 'a': mass: found -1"),
        ('<inertial><mass value="x"/></inertial>', "", "mass: found 'x'; expected 1 finite"),
        ('<inertial><inertia ixz="x"/></inertial>', "", "ixz: found 'x'"),
        ('<inertial><mas value="1"/></inertial>', "", "<mas> in <inertial>"),
        ("", '<dynamics damping="-1"/>', "joint 'j': damping: found -1; expected zero or more"),
        ("", '<dynamics damp="1"/>', "an attribute 'damp' of <dynamics>"),
    ],
)
def test_values_that_mean_nothing_are_refused(
    inside: str, after: str, said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, inside, "continuous", after, "")
    assert said in str(refusal.value)
    assert "one.urdf, line " in refusal.value.place
