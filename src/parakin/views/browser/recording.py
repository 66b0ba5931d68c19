"""A motion recorded as one file of HTML that plays by itself: viser's page with the scene in it."""

from __future__ import annotations

import contextlib
import io

import numpy as np

from parakin.errors import not_installed
from parakin.views.browser.repertoire import Shown, Take
from parakin.views.browser.scene import Scene

_RATE = 25.0  # poses a second
_LONGEST = 20.0  # seconds; what lasts longer plays faster


def recorded(shown: Shown, take: Take | None) -> str:
    """A page that plays a motion over and over, or shows the mechanism at home without one.

    Raises InputError where viser is not installed.
    """
    try:
        import viser
    except ImportError:
        raise not_installed("recording", "viser", "view") from None
    view = shown.drawing.view
    with contextlib.redirect_stdout(io.StringIO()):  # viser's banner
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        server.initial_camera.up = view.up
        server.initial_camera.position = view.middle + 0.85 * view.span * view.eye
        server.initial_camera.look_at = view.middle
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        scene = Scene(server.scene, shown.drawing, shown.meshes)
        if take is not None and take.point is not None:
            scene.trace(take.point[:: max(1, len(take.point) // 400)])
        recording = server.get_scene_serializer()
        if take is not None:
            span = float(take.time[-1] - take.time[0])
            count = max(2, round(min(span, _LONGEST) * _RATE))
            for at in np.linspace(take.time[0], take.time[-1], count):
                k = take.index(float(at))
                scene.place(take.position[k], take.wxyz[k])
                recording.insert_sleep(1 / _RATE)
        return str(recording.as_html())
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
