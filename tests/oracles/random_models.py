"""Random MJCF and URDF files read by parakin, and judged by MuJoCo's kinematics and SciPy's.

`python tests/oracles/random_models.py 1000` reads a thousand models of each. A model has to agree
to 1e-9 in every body's pose, the gaps of its loops, its freedom, home, limits, motors and masses,
and in the efforts of open MJCF trees, or to be refused with its place.
"""

from __future__ import annotations

import random
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import random_mjcf
import random_urdf
import yaml
from mjcf_twin import Array, adapted, elsewhere, judge_read

import parakin
from parakin.errors import InputError
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import Configuration, configure
from parakin.kinematics.free_motions import free_motions
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Parameters
from parakin.model.graph import Graph
from parakin.model.masses import mass_of

SAME = 1e-9  # [m, rad]
_WORDS = re.compile(r"(?<=<)[a-z]{3,}(?=[^<>]*/>)|(?<= )[a-z]{3,}\d?(?==[\"'])")


def misspelt(text: str, seed: int, unread: str = "$.") -> str:
    """The text with two neighbouring letters exchanged in the name of an attribute or element.

    unread: a pattern of elements in which no word is looked at.
    """
    chance = random.Random(seed)
    passed = [piece.span() for piece in re.finditer(unread, text)]
    words = _WORDS.finditer(text)
    word = chance.choice([w for w in words if not any(a <= w.start() < b for a, b in passed)])
    k = chance.randrange(len(word[0]) - 1)
    new = word[0][:k] + word[0][k + 1] + word[0][k] + word[0][k + 2 :]
    return text[: word.start()] + (new if new != word[0] else f"{new}s") + text[word.end() :]


def loaded(path: Path, text: str, loops: Path | None = None) -> parakin.Mechanism | InputError:
    path.write_text(text)
    try:
        return parakin.load(path, loops=loops)
    except InputError as error:
        return error


def judge_mjcf(seed: int, folder: Path) -> str:
    """How the model of this seed was read; AssertionError if wrongly."""
    rng = np.random.default_rng(seed)
    written = random_mjcf.Writer(seed).write()
    text, path = written.text, folder / f"model{seed}.xml"
    if seed % 4 == 0:
        return _judge_misspelt(misspelt(text, seed), path)
    found = loaded(path, text)
    if written.refused is not None:
        check_refusal(found, path, written.refused)
        return "refused"
    if isinstance(found, InputError):
        return judge_rigid(found, path)
    return judge_read(found, text, rng)


def judge_rigid(found: InputError, path: Path) -> str:
    """What chance makes of a sound model, and is refused with its place: nothing that moves."""
    assert str(path) in found.place, str(found)
    for said in ("one rigid body", "no joints that move", "already rigid", "helical joints alone"):
        if said in str(found):
            told = any(s in found.place for s in (", line", ".yaml: clos", ".xml: joints."))
            assert told or "no joints" in said, str(found)
            return "refused as rigid"
    raise AssertionError(f"refused: {found}")


def check_refusal(found: object, path: Path, said: str) -> None:
    """One line that names the file and a line in it, and says what was found."""
    assert isinstance(found, InputError), f"read, though it has {said!r}"
    assert re.match(rf"{re.escape(str(path))}, line \d+", found.place), str(found)
    assert said in str(found), str(found)


def _judge_misspelt(text: str, path: Path) -> str:
    found = loaded(path, text)
    try:
        random_mjcf.compiled(text)
    except ValueError as error:
        check_refusal(found, path, "expected")
        return "misspelt" if "Schema" in str(error) else "misspelt otherwise"
    check_refusal(found, path, "did you mean")  # MuJoCo does not check words in frames
    return "misspelt in a frame"


_UNREAD = r"<(visual|gazebo|material|transmission)\b.*?</\1>|<(ros2_control)[^>]*>"


def judge_urdf(seed: int, folder: Path) -> str:
    """How the URDF of this seed was read; AssertionError if wrongly."""
    rng = np.random.default_rng(seed)
    written = random_urdf.Writer(seed)
    text, path, loops = written.text(), folder / f"robot{seed}.urdf", None
    table = yaml.safe_dump(written.table, default_flow_style=None)
    if seed % 4 == 0:
        found = loaded(path, misspelt(text, seed, _UNREAD))
        check_refusal(found, path, "expected")
        return "misspelt"
    if seed % 10 == 1:
        end, said = list(random_urdf.REFUSED.items())[rng.integers(len(random_urdf.REFUSED))]
        check_refusal(loaded(path, text.replace("</robot>", f"{end}\n</robot>")), path, said)
        return "refused"
    if written.table:
        loops = folder / f"robot{seed}.yaml"
        loops.write_text(table)
    if loops is not None and seed % 10 == 3:
        more, said = list(random_urdf.REFUSED_BESIDE.items())[seed // 10 % 5]
        loops.write_text(_with(table, more))
        found = loaded(path, text, loops)
        assert isinstance(found, InputError), more
        assert str(loops) in found.place, str(found)
        assert said in str(found), str(found)
        return "refused beside"
    found = loaded(path, text, loops)
    if isinstance(found, InputError):
        return judge_rigid(found, loops if loops and str(loops) in found.place else path)
    return _compare_urdf(found, written, rng)


def _with(table: str, more: str) -> str:
    """A YAML table with another entry in place of its own of the same name, if it has one."""
    key = more.partition(":")[0]
    tables = yaml.safe_load(table)
    tables.pop(key, None)
    return str(yaml.safe_dump(tables)) + more


def _compare_urdf(
    mechanism: parakin.Mechanism, written: random_urdf.Writer, rng: np.random.Generator
) -> str:
    graph = graph_of(mechanism)
    _compare_joints(graph, written)
    if not written.loops:
        for _ in range(3):
            q = rng.normal(size=len(graph.coordinates))
            _compare_links(configure(graph, graph.tree(), q), written)
        return "tree"
    home = assembled(graph)
    told = {c.name: home.q[k] for k, c in enumerate(graph.coordinates)}
    for name, value in written.home.items():
        if name in told:
            assert abs(told[name] - value[0]) < 1e-6, "another home"
    _compare_links(home, written)
    tree = graph.posed_tree()
    motions = free_motions(graph, tree, configure(graph, tree, home.q)).shape[1]
    assert motions == _freedom(home, written), "another mobility"
    other = elsewhere(mechanism, home, rng)
    if other is None:
        return "loops, at home only"
    _compare_links(other, written)
    return "loops"


def _told(at: Configuration, written: random_urdf.Writer) -> dict[str, Array]:
    """The coordinates of the tree's joints that are independent."""
    graph = at.circuits.graph
    numbers = {c.name: k for k, c in enumerate(graph.coordinates)}
    told = {}
    for joint in written.joints:
        count = random_urdf.FREEDOMS[joint.kind]
        name = adapted(joint.name)
        if joint.mimics is not None or not count:
            continue
        names = [name] if count == 1 else [f"{name}.{k + 1}" for k in range(count)]
        if count == 6 and names[0] not in numbers:
            names = [f"platform.{k}" for k in ("x", "y", "z", "roll", "pitch", "yaw")]
        if count == 1 and name not in numbers:  # the hinge of a screw tells where its slide is
            names = [next(j.name for j in written.joints if j.mimics and j.mimics[0] == name)]
            _, ratio, offset = next(
                j.mimics for j in written.joints if j.name == names[0] and j.mimics
            )
            told[joint.name] = (at.q[[numbers[names[0]]]] - offset) / ratio
            continue
        told[joint.name] = at.q[[numbers[n] for n in names]]
    return told


def _compare_links(at: Configuration, written: random_urdf.Writer) -> None:
    """Every link where URDF's definition has it, and no gaps in the loops."""
    told, graph = _told(at, written), at.circuits.graph
    inside = {j.parent for j in written.joints if j.parent.startswith("n")}  # of screws
    for link, place in written.walk(told).items():
        if link in graph.bodies:
            pose = at.pose(graph.bodies.index(link))
            np.testing.assert_allclose(pose.R, place[:3, :3], atol=SAME, err_msg=link)
            p = np.array(pose.p)
        elif link in inside:
            continue
        else:
            key = next(k for k in graph.points if k.rpartition(".")[2] == link)
            body, local = graph.points[key]
            p = np.array(at.pose(body).R @ local + at.pose(body).p)
        np.testing.assert_allclose(p, place[:3, 3], atol=SAME, err_msg=link)
    assert np.abs(written.gaps(told)).max(initial=0.0) < SAME, "open loops"
    np.testing.assert_allclose(_weighed(at), written.moments(told), atol=1e-8)


def _weighed(at: Configuration) -> Array:
    """Of all bodies together, as `moments` of links."""
    found = np.zeros(13)
    for body in at.circuits.graph.mechanism.bodies:
        mass = mass_of(body, Parameters({}, ""), "")  # that of the base too
        if mass is not None:
            pose = at.pose(at.circuits.graph.bodies.index(body.name))
            R = np.array(pose.R)
            com = np.array(pose.p) + R @ np.array(mass.com)
            found += random_urdf.gathered(mass.mass, com, R @ np.array(mass.inertia) @ R.T)
    return found


def _freedom(at: Configuration, written: random_urdf.Writer) -> int:
    """In how many directions the loops let the tree move, by differences."""
    told = _told(at, written)
    columns, step = [], 1e-6
    for name, values in told.items():
        for k in range(len(values)):
            ends = []
            for sign in (1, -1):
                moved = {**told, name: values + sign * step * np.eye(len(values))[k]}
                ends.append(written.gaps(moved))
            columns.append((ends[0] - ends[1]) / (2 * step))
    return len(columns) - int(np.linalg.matrix_rank(np.array(columns), tol=1e-6))


def _compare_joints(graph: Graph, written: random_urdf.Writer) -> None:
    """Limits and motors."""
    for joint in written.joints:
        if random_urdf.FREEDOMS[joint.kind] == 1 and joint.mimics is None:
            known = {c.name: graph.limits(c.name) for c in graph.coordinates}
            if joint.name in known:
                expected = joint.limits or (-np.inf, np.inf)
                np.testing.assert_allclose(known[joint.name], expected, atol=SAME)
    driven = {joint.name for joint in written.joints if joint.driven}
    assert len(graph.mechanism.driven) == len(driven)


def main(count: int, first: int = 0) -> int:
    """Judges the models of `count` seeds, prints how they were read; 1 if any wrongly."""
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for kind, judge in JUDGES.items():
            outcomes: Counter[str] = Counter()
            for seed in range(first, first + count):
                try:
                    outcomes[judge(seed, Path(folder))] += 1
                except Exception as error:  # any, to be told with its seed
                    wrong += 1
                    outcomes["WRONG"] += 1
                    print(f"{kind} {seed}: {type(error).__name__}: {error}"[:600])
            print(kind, dict(sorted(outcomes.items())))
    return int(wrong > 0)


JUDGES: Mapping[str, Any] = {"MJCF": judge_mjcf, "URDF": judge_urdf}

if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
