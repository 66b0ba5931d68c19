"""A single HTML file that plays a motion without a server: viser's page with the scene in it."""

from __future__ import annotations

import contextlib
import io

import numpy as np

from parakin.errors import not_installed
from parakin.views.browser.content import LoadedMechanism
from parakin.views.browser.playback import Playback
from parakin.views.browser.scene import Scene

_RATE = 25.0  # poses a second
_LONGEST = 20.0  # seconds; longer motions are played faster


def standalone_page(loaded: LoadedMechanism, playback: Playback | None) -> str:
    """A page that plays a motion in a loop or, without a playback, shows the mechanism at home.

    Raises InputError if viser is not installed.
    """
    try:
        import viser
    except ImportError:
        raise not_installed("recording", "viser", "view") from None
    view = loaded.drawing.view
    with contextlib.redirect_stdout(io.StringIO()):  # viser's banner
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        server.initial_camera.up = view.up
        server.initial_camera.position = view.middle + 0.85 * view.span * view.eye
        server.initial_camera.look_at = view.middle
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        scene = Scene(server.scene, loaded.drawing, loaded.meshes)
        scene.trace(None if playback is None else playback.point)
        serializer = server.get_scene_serializer()
        if playback is not None:
            forces = playback.forces
            if forces is not None:
                scene.efforts.scale_to(forces.effort, forces.units)
            span = float(playback.time[-1] - playback.time[0])
            count = max(2, round(min(span, _LONGEST) * _RATE))
            for at in np.linspace(playback.time[0], playback.time[-1], count):
                k = playback.index(float(at))
                poses = playback.position[k], playback.wxyz[k]
                scene.place(*poses)
                if forces is not None:
                    now = forces.effort[k]
                    scene.efforts.show(*poses, forces.actuators, forces.units, now)
                serializer.insert_sleep(1 / _RATE)
        return str(serializer.as_html())
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
