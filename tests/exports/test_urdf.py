"""Exported URDF, read by another program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.exports import export as exports
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of

mujoco = pytest.importorskip("mujoco")

pytest.importorskip("lxml")

pytest.importorskip("yaml")


def test_mujoco_has_the_urdf_where_we_have_it(tmp_path: Path) -> None:
    """The exported tree, read by MuJoCo's own URDF reader, at our home. (It leaves out fixed
    links' names; bodies with a joint of their own are compared.)
    """
    mechanism = parakin.load("tricept")
    text = exports.export(mechanism, tmp_path / "model.urdf")[0].read_text()
    text = text.replace(
        "<visual>",
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial><visual>",
    ).replace("<robot ", '<robot xmlns:mujoco="x" ', 1)
    extra = '<mujoco><compiler boundmass="1" boundinertia="1" fusestatic="false"/></mujoco>'
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", f"{extra}</robot>"))
    data = mujoco.MjData(model)
    graph = graph_of(mechanism)
    at = assembled(graph)
    for c, value in zip(graph.coordinates, at.q, strict=True):
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, c.name)
        if joint >= 0:
            data.qpos[model.jnt_qposadr[joint]] = value
    mujoco.mj_kinematics(model, data)
    for k, name in enumerate(graph.bodies[1:], start=1):
        np.testing.assert_allclose(at.pose(k).p, data.xpos[model.body(name).id], atol=1e-12)
