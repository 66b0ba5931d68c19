"""The viewer in a real browser, and what it may read and do."""

from __future__ import annotations

import gc
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import ELSEWHERE, Page, chromium, needs_chromium, until, viewed

import parakin
from parakin.views.browser.content import Content
from parakin.views.browser.viewer import Viewer, exposure, is_cross_origin, serving
from parakin.views.solids.drawing import COLOURS

pytestmark = needs_chromium
FOUR_BAR = (Path(parakin.__file__).parent / "catalogue" / "four-bar.toml").read_text("utf-8")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def simulator(browser: Any) -> Iterator[Page]:
    with viewed(browser, "flight-simulator") as page:
        yield page


def _like(pixels: np.ndarray, rgb: tuple[int, int, int]) -> int:
    """How many pixels have a colour's hue, whatever its light."""
    wanted = np.array(rgb) / np.linalg.norm(rgb)
    size = np.linalg.norm(pixels, axis=2)
    near = (pixels @ wanted > 0.985 * size) & (size > 60) & (np.ptp(pixels, axis=2) > 40)
    return int(near.sum())


def test_it_loads_without_a_word_and_shows_the_machine(simulator: Page) -> None:
    until(lambda: _like(simulator.pixels(), COLOURS["actuated"]) > 300)
    pixels = simulator.pixels()
    assert _like(pixels, COLOURS["platform"]) > 300
    assert pixels.std() > 10
    assert simulator.said == []
    start = simulator.viewer.url
    assert all(url.startswith((start, f"blob:{start}", "data:")) for url in simulator.asked)


def test_play_moves_it_and_pause_holds_it(simulator: Page) -> None:
    before, _ = simulator.poses()
    pixels = simulator.pixels()
    simulator.press("Play")
    until(lambda: simulator.session.time > 0.5)
    simulator.press("Pause")
    until(lambda: not simulator.session.playing)
    held = simulator.session.time
    time.sleep(0.2)
    assert simulator.session.time == held
    after, _ = simulator.poses()
    assert np.abs(after - before).max() > 0.01
    assert np.abs(simulator.pixels() - pixels).max() > 50


def test_bodies_stand_where_the_solver_says(simulator: Page) -> None:
    solver = parakin.compile("flight-simulator")
    simulator.choose("Motion", "general")
    until(
        lambda: (
            simulator.session.playback is not None and simulator.session.playback.name == "general"
        )
    )
    ds = solver.solve("general", bodies=True)
    for k in (0, 700, 1500, 3000):
        simulator.session.seek(float(ds["time"][k]))
        position, wxyz = ds["body_position"].values[k], ds["body_orientation"].values[k]
        _agree(simulator, position, wxyz)


def _drive_from_home(page: Page) -> None:
    page.tab("Drive")
    page.press("Home")
    until(lambda: page.session.drive_tab.drive is not None)


def _stand_on_the_second_branch(page: Page, of: int) -> None:
    _drive_from_home(page)
    page.press("Search for branches here")
    page.page.get_by_text(re.compile(f"{of} distinct among [0-9,]+ assemblies")).wait_for()
    page.choose("Branch", f"2 of {of}")
    page.page.get_by_text(re.compile(f"branch 2 of {of}")).wait_for()


def _agree(page: Page, position: np.ndarray, wxyz: np.ndarray) -> None:
    """The page's scene comes to these poses, within what single precision tells."""

    def arrived() -> bool:
        seen, turned = page.poses()
        across = np.abs((turned * wxyz).sum(axis=1))
        return bool(np.abs(seen - position).max() < 1e-6 and (across > 1 - 1e-6).all())

    until(arrived)


def test_a_slider_moves_it(simulator: Page) -> None:
    _drive_from_home(simulator)
    simulator.enter("platform.y [mm]", "1200")
    solver = parakin.compile("flight-simulator")
    y = np.array([solver.home[name] for name in solver.driven])
    y[1] = 1.2
    tick = solver.at(y)
    _agree(simulator, *solver.poses(y, tick))
    assert simulator.said == []


def test_forward_drives_the_actuators_from_where_it_stands(simulator: Page) -> None:
    _drive_from_home(simulator)
    simulator.choose("Kinematics", "forward")
    until(
        lambda: (
            simulator.session.drive_tab.drive is not None
            and simulator.session.drive_tab.drive.solver.driven == ("A2", "B3", "C3")
        )
    )
    simulator.enter("B3 [mm]", "40")
    forward = parakin.compile("flight-simulator", ("A2", "B3", "C3"))
    y = [forward.home["A2"], 0.04, forward.home["C3"]]
    _agree(simulator, *forward.poses(y, forward.at(y)))
    simulator.choose("Kinematics", "inverse")


def test_the_handle_leads_the_platform(simulator: Page) -> None:
    _drive_from_home(simulator)
    simulator.page.wait_for_function("window.__viserMutable.nodeRefFromName['/handle']")
    before = simulator.session.drive_tab.drive.y.copy()  # type: ignore[union-attr]
    x, y = _at_rest(simulator, 0.14 * simulator.session.scene.drawing.arrangement.size)
    mouse = simulator.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x, y - 40, steps=5)
    until(lambda: simulator.session.drive_tab.drive.y[1] > before[1] + 0.01)  # type: ignore[union-attr]
    mouse.up()
    drive = simulator.session.drive_tab.drive
    assert drive is not None
    _agree(simulator, *drive.solver.poses(drive.y, drive.tick))


def _at_rest(page: Page, size: float) -> list[float]:
    """Where the handle's arrow is once it, and the camera, have come to rest."""
    seen: list[list[float]] = []

    def still() -> bool:
        seen.append(page.page.evaluate(_ON_SCREEN, size))
        page.page.wait_for_timeout(300)
        return len(seen) > 2 and seen[-1] == seen[-2] == seen[-3]

    until(still)
    return seen[-1]


# Where the tip of the handle's arrow along y is on the screen, in pixels.
_ON_SCREEN = """size => {
    const {nodeRefFromName, camera} = window.__viserMutable;
    const node = nodeRefFromName['/handle'];
    node.updateWorldMatrix(true, false);
    const tip = node.position.clone().set(0, size, 0).applyMatrix4(node.matrixWorld);
    tip.project(camera);
    const box = document.querySelector('canvas').getBoundingClientRect();
    return [box.x + box.width * (tip.x + 1) / 2, box.y + box.height * (1 - tip.y) / 2];
}"""


def test_another_branch_is_searched_and_driven(browser: Any) -> None:
    with viewed(browser, "five-bar") as page:
        drive_tab = page.session.drive_tab
        _stand_on_the_second_branch(page, of=4)
        other = parakin.compile("five-bar", near="2", coordinates="all")
        y = np.array([other.home[name] for name in other.driven])
        _agree(page, *other.poses(y, other.at(y)))
        page.enter("platform.x [mm]", "20")
        y[0] = 0.02
        _agree(page, *other.poses(y, other.at(y)))
        found = drive_tab._found
        page.press("Search for branches here")  # of these driven values
        until(lambda: drive_tab._found is not found)
        page.page.get_by_text(re.compile("branch [234] of 4")).wait_for()
        page.page.get_by_role("combobox", name="Branch").click()
        page.page.get_by_role("option", name="4 of 4").wait_for()
        options = page.page.get_by_role("option").filter(visible=True).all_inner_texts()
        assert options == ["home", "2 of 4", "3 of 4", "4 of 4"]
        page.page.keyboard.press("Escape")
        _agree(page, *other.poses(y, other.at(y)))
        page.choose("Kinematics", "forward")  # from where it stands, on its assembly mode
        page.page.get_by_text(re.compile("driven by hand, forward")).wait_for()
        _agree(page, *other.poses(y, other.at(y)))
        page.choose("Kinematics", "inverse")
        page.page.get_by_text(re.compile("branch unnumbered")).wait_for()
        _agree(page, *other.poses(y, other.at(y)))
        page.choose("Branch", "home")  # for the same driven values
        page.page.get_by_text(re.compile("branch home")).wait_for()
        own = parakin.compile("five-bar", coordinates="all")
        _agree(page, *own.poses(y, own.at(y)))
        assert page.said == []


def test_far_from_home_sliders_reach_to_where_it_stands(browser: Any) -> None:
    with viewed(browser, "flight-simulator") as page:
        drive_tab = page.session.drive_tab
        _stand_on_the_second_branch(page, of=16)
        page.choose("Kinematics", "forward")
        until(lambda: drive_tab.drive is not None and "A2" in drive_tab.drive.solver.driven)
        assert drive_tab.drive is not None
        y = drive_tab.drive.y.copy()
        until(lambda: page.value("A2 [mm]") == f"{1e3 * y[0]:.0f}")
        assert y[0] < -2.0
        page.enter("B3 [mm]", "5")
        until(lambda: abs(drive_tab.drive.y[1] - 0.005) < 1e-12)  # type: ignore[union-attr]
        assert drive_tab.drive.y[0] == y[0]
        assert drive_tab.drive.y[2] == y[2]


def test_at_a_limit_it_stops_and_the_joint_lights_up(browser: Any) -> None:
    with viewed(browser, "seat-2dof") as page:
        page.tab("Drive")
        page.choose("Kinematics", "forward")
        until(lambda: page.session.drive_tab.drive is not None)
        page.enter("A1 [deg]", "20")
        until(lambda: abs(page.session.drive_tab.drive.y[0] - np.radians(20)) < 1e-9)  # type: ignore[union-attr]
        assert COLOURS["offending"] not in page.colours("/mechanism/crank1/joint A1")
        with page.session._lock:
            page.session.drive_tab.to([2.0, 0.0])
        until(lambda: COLOURS["offending"] in page.colours("/mechanism/crank1/joint A1"))
        assert COLOURS["offending"] not in page.colours("/mechanism/crank2/joint A2")
        np.testing.assert_allclose(page.session.drive_tab.drive.y[0], np.radians(75), atol=1e-5)  # type: ignore[union-attr]
        page.page.get_by_text(re.compile("stopped: A1 is at its limit")).wait_for()
        page.enter("A1 [deg]", "120")
        until(lambda: page.value("A1 [deg]") == "75")


def test_a_bad_file_shows_its_message_while_the_last_good_one_stays(
    browser: Any, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(FOUR_BAR, "utf-8")
    with viewed(browser, path) as page:
        ds = parakin.compile("four-bar").solve("turn", bodies=True)
        home = ds["body_position"].values[0], ds["body_orientation"].values[0]
        _agree(page, *home)
        path.write_text(FOUR_BAR.replace("[parameters]", "[parameter]"), "utf-8")
        page.page.get_by_text(re.compile("Error: .*unknown key 'parameter'")).wait_for()
        _agree(page, *home)
        path.write_text(re.sub(r"(?m)^b = .*$", 'b = "130 mm"', FOUR_BAR), "utf-8")
        until(lambda: page.session.loaded.graph.parameters["b"] == 0.13)
        until(lambda: not page.page.get_by_text(re.compile("Error:")).is_visible())
        assert page.said == []


def test_two_pages_are_apart_and_closing_one_frees_it(browser: Any) -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        one, two = Page(browser, viewer), Page(browser, viewer)
        two.choose("Mechanism", "slider-crank")
        until(
            lambda: two.session.loaded.name == "slider-crank" and two.session.playback is not None
        )
        two.drawn()
        assert one.session.loaded.name == "four-bar"
        one.press("Play")
        until(lambda: one.session.time > 0.1)
        assert two.session.time == 0.0
        assert not two.session.playing
        players = _players()
        kept = weakref.ref(two.session)
        scene = weakref.ref(two.session.scene)
        two.close()
        until(lambda: len(viewer.sessions) == 1)

        def freed() -> bool:
            gc.collect()
            return kept() is None and scene() is None

        until(freed)
        assert _players() == players - 1
        assert one.session.playing
        one.close()


def _players() -> int:
    """How many threads play, of all pages in this process."""
    return sum(thread.name == "parakin player" for thread in threading.enumerate())


def test_a_page_may_close_while_it_plays(browser: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    left = Viewer._disconnected

    def late(viewer: Viewer, client: Any) -> None:
        time.sleep(0.5)
        left(viewer, client)

    monkeypatch.setattr(Viewer, "_disconnected", late)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # which ends the player's thread, and fails the test
        with viewed(browser, "four-bar") as page:
            page.press("Play")
            until(lambda: page.session.playing)
            session = page.session
            page.close()
            at = session.poses
            until(lambda: session.poses > at + 10)


def test_the_server_ends_and_closes_all_connections(browser: Any) -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        page = Page(browser, viewer)
        page.press("Play")
        silent = socket.create_connection(("127.0.0.1", viewer.server.get_port()))
        until(lambda: page.session.playing)
        time.sleep(0.2)
    assert silent.recv(1) == b""
    silent.close()
    page.page.close()
    gc.collect()  # what is left open is told


def test_without_loop_it_stops_at_the_end(browser: Any) -> None:
    with viewed(browser, "four-bar") as page:
        page.choose("Speed", "4")
        page.page.get_by_role("checkbox", name="Loop").uncheck()
        page.press("Play")
        until(lambda: page.session.playing)
        until(lambda: not page.session.playing)
        playback = page.session.playback
        assert playback is not None
        assert page.session.time == playback.time[-1]
        _agree(page, playback.position[-1], playback.wxyz[-1])


_TOO_FAR = """
[motions.far]
duration = "1 s"
laws = { platform.y = { law = "cosine", by = "1 m" } }
"""


def test_a_motion_that_cannot_go_on_ends_at_its_last_good_pose(
    browser: Any, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    file = Path(parakin.__file__).parent / "catalogue" / "five-bar.toml"
    path.write_text(file.read_text("utf-8") + _TOO_FAR, "utf-8")
    with viewed(browser, path) as page:
        page.choose("Motion", "far")
        until(lambda: page.session.playback is not None and page.session.playback.name == "far")
        playback = page.session.playback
        assert playback is not None
        assert playback.stop is not None
        page.session.seek(float(playback.time[-1]))
        page.page.get_by_text(re.compile("stopped: ended at 0.[0-9]+ s")).wait_for()
        # Both arms stretched, on the axis of symmetry: the paper-and-pencil end of the reach.
        end = np.sqrt((0.15 + 0.22) ** 2 - 0.1**2)
        assert playback.point is not None
        assert 0 < end - playback.point[-1, 1] < 5e-3
        names = {page.session.loaded.graph.joints[k].name for k in playback.stop.joints}
        assert names
        lit = page.colours(f"/mechanism/{'base'}/joint A1")
        assert (COLOURS["offending"] in lit) == ("A1" in names)


def test_a_bad_motion_is_told_and_the_one_before_stays(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "recorded.csv"
    path.write_text("time [s],A [deg]\n0,10\n0,20\n", "utf-8")
    with viewed(browser, "four-bar", motions=(str(path),)) as page:
        page.choose("Motion", str(path))
        page.page.get_by_text(re.compile("Error: .*recorded.csv")).wait_for()
        assert page.session.playback is not None
        assert page.session.playback.name == "turn"


def test_what_cannot_be_driven_is_shown_and_told(browser: Any) -> None:
    with viewed(browser, "flight-simulator-upu") as page:
        page.page.get_by_text(re.compile("only 1 can move independently")).wait_for()
        assert page.session.playback is None


def test_text_from_a_file_is_only_text(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    evil = "<img src=x onerror=console.error(1)> **[a](http://elsewhere.example)**"
    path.write_text(re.sub(r"(?m)^title = .*$", f'title = "{evil}"', FOUR_BAR), "utf-8")
    with viewed(browser, path) as page:
        page.page.get_by_text(evil).wait_for()
        assert page.said == []
        assert not any("elsewhere" in url or url.endswith("/x") for url in page.asked)


def test_it_is_bound_to_the_loopback_address_alone() -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        port = viewer.server.get_port()
        socket.create_connection(("127.0.0.1", port), 5).close()
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", port), 5)
        assert viewer.server.request_share_url() is None


@pytest.mark.parametrize(
    ("origin", "foreign"),
    [
        ("http://localhost:8080", False),
        ("http://127.0.0.1", False),
        ("http://[::1]:8080", False),
        (None, False),
        ("https://elsewhere.example", True),
        ("http://127.0.0.1.elsewhere.example", True),
        ("http://localhost@elsewhere.example", True),
        ("null", True),
    ],
)
def test_whose_page_it_is(origin: str | None, foreign: bool) -> None:
    assert is_cross_origin(origin) == foreign


def test_pages_of_other_sites_are_refused(browser: Any) -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        page = browser.new_page()
        page.goto(viewer.url.replace("127.0.0.1", ELSEWHERE))
        page.get_by_text(re.compile(f"Refused: http://{ELSEWHERE}:[0-9]+ is not this")).wait_for()
        assert not viewer.sessions
        assert not page.get_by_text("slider-crank").count()
        page.close()
        until(lambda: not viewer.server.get_clients())


def test_ctrl_c_is_how_it_ends() -> None:
    # What a shell starts in the background, these tests perhaps, is told to ignore Ctrl-C.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    start = f"{heard}; import sys; from parakin.cli.main import main; sys.exit(main())"
    view = [sys.executable, "-c", start, "view", "four-bar", "--port", "0"]
    process = subprocess.Popen(view, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    said = process.stdout.readline()
    assert said.startswith("four-bar at http://127.0.0.1:")
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate(timeout=600)
    assert (process.returncode, rest, errors) == (0, "", "")


@pytest.mark.parametrize(
    "arguments",
    [["nothing"], ["four-bar", "--port", "70000"], ["four-bar", "--host", "300.1.1.1"]],
)
def test_what_cannot_be_served_is_told_in_one_line(arguments: list[str]) -> None:
    view = [sys.executable, "-m", "parakin", "view", *arguments]
    done = subprocess.run(view, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert arguments[-1] in done.stderr


def test_without_viser_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with (
        pytest.raises(parakin.InputError, match=r"pip install 'parakin\[view\]'"),
        serving(Content("four-bar")),
    ):
        pass


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "127.0.0.9"])
def test_nothing_is_said_of_loopback(host: str) -> None:
    assert exposure(host) == ""


def test_another_address_says_what_it_exposes() -> None:
    view = ["-m", "parakin", "view", "four-bar", "--host", "0.0.0.0", "--port", "0"]
    process = subprocess.Popen([sys.executable, *view], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    said = process.stdout.readline()
    process.kill()
    process.communicate()
    assert "0.0.0.0" in said
    assert "without a password" in said


_STL = """solid s
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid s
"""


def test_only_meshes_that_are_named_are_read(tmp_path: Path) -> None:
    shape, path = tmp_path / "coupler.stl", tmp_path / "mine.toml"
    shape.write_text(_STL, "ascii")
    body = re.search(r"(?m)^coupler = \{.*$", FOUR_BAR)
    assert body is not None, "the catalogue's file has changed"
    place = 'scale = 0.001, on_body = { at = [0, 0, "10 mm"] }'
    mesh = f'coupler = {{ mesh = {{ file = "coupler.stl", {place} }} }}'
    path.write_text(FOUR_BAR.replace(body[0], mesh), "utf-8")
    script = (
        "import sys; seen = []; "
        "sys.addaudithook(lambda e, given: seen.append(str(given[0])) if e == 'open' else None); "
        "from parakin.views.browser.content import Content; "
        "loaded = Content(sys.argv[1], meshes=tuple(sys.argv[2:])).load(sys.argv[1]); "
        "print(len(loaded.meshes), any('coupler.stl' in name for name in seen), loaded.problem)"
    )
    run = [sys.executable, "-c", script, str(path)]
    said = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert said.startswith("0 False Not read")
    said = subprocess.run([*run, str(shape)], capture_output=True, text=True, check=True).stdout
    assert said.startswith("1 True ")
    loaded = Content(str(path), meshes=(str(shape),)).load(str(path))
    corners = np.unique(np.round(loaded.meshes["coupler"].vertices, 9), axis=0)
    np.testing.assert_allclose(corners, [[0, 0, 0.01], [0, 0.001, 0.01], [0.001, 0, 0.01]])


def test_meshes_of_limbs_are_numbered(tmp_path: Path) -> None:
    path = tmp_path / "legs.toml"
    path.write_text(
        """
name = "legs"
[bodies]
[joints]
[limbs.leg]
count = 2
each = { x = [0, 1] }
[limbs.leg.bodies]
"leg{i}" = { mesh = { file = "x{i}.stl", on_body = { at = ["x", 0, 0] } } }
[limbs.leg.joints]
"A{i}" = { kind = "revolute", parent = "base", child = "leg{i}", on_parent = { at = ["x", 0, 0] } }
""",
        "utf-8",
    )
    bodies = parakin.load(path).bodies
    assert [body.mesh and body.mesh.file for body in bodies] == ["x1.stl", "x2.stl"]


def test_a_broken_mesh_is_told_by_its_name(tmp_path: Path) -> None:
    from parakin.views.browser.content import read_mesh

    for name, content in (
        ("a.stl", b"\x00" * 90),
        ("b.obj", b"f 1 2 3"),
        ("c.glb", b"glTF"),
        ("d.ply", b""),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(parakin.InputError, match=re.escape(name)):
            read_mesh(tmp_path / name)
    with pytest.raises(parakin.InputError, match="suffix"):
        read_mesh(tmp_path / "e.dae")
