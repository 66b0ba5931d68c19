"""Exported MuJoCo models move in MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.exports import export as exports

mujoco = pytest.importorskip("mujoco")

pytest.importorskip("lxml")

pytest.importorskip("yaml")


@pytest.mark.parametrize("name", ["flight-simulator", "gough-stewart", "delta", "seat-3dof"])
def test_a_newcomer_moves_it_and_the_loops_stay_closed(name: str, tmp_path: Path) -> None:
    """Two seconds in MuJoCo, the servos following sines: no loop opens by a tenth of a millimetre
    in a machine of metres, and the actuators are where they were told to be.
    """
    path = exports.export(parakin.load(name), tmp_path / "model.xml")[0]
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    rest = data.ctrl.copy()
    reach = 0.05 * model.stat.extent * (model.jnt_type[model.actuator_trnid[:, 0]] == 2) + 0.05
    places = model.jnt_qposadr[model.actuator_trnid[:, 0]]
    opened = behind = 0.0
    for step in range(round(2.0 / model.opt.timestep)):
        time = step * model.opt.timestep
        swing = np.sin(3.0 * time + np.arange(model.nu)) * min(1.0, time / 0.4)
        data.ctrl[:] = rest + 0.2 * reach * swing
        mujoco.mj_step(model, data)
        opened = max(opened, float(np.abs(data.efc_pos[: data.ne]).max()))
        behind = max(behind, float(np.abs(data.qpos[places] - data.ctrl).max()))
    assert opened < 1e-4
    assert 0.0 < behind < 0.5 * reach.max()


def test_bodies_may_have_the_name_that_mujoco_gives_the_world(tmp_path: Path) -> None:
    """As what is read from MJCF has, where no other body stands still."""
    read, back = tmp_path / "read.xml", tmp_path / "back.xml"
    hinges = (
        "<body name='a'><joint name='x'/><body name='world body'><joint name='y'/></body></body>"
    )
    read.write_text(f"<mujoco><worldbody>{hinges}</worldbody></mujoco>")
    mechanism = parakin.load(read)
    assert [body.name for body in mechanism.bodies] == ["world", "a", "world body"]
    exports.export(mechanism, back)
    again = parakin.load(back)
    assert [body.name for body in again.bodies] == ["world body'", "a", "world body"]
    assert [joint.kind for joint in again.joints] == ["revolute", "revolute"]
