"""What the viewer costs, with a real Chromium looking on.

    python -m benchmarks.viewer [--long]

The largest mechanism of the catalogue plays at sixty poses a second: the share of one core that
Python takes. A slider is moved by a key: how long until the page's own scene has the new pose,
with the picture drawn by the processor, where there is no graphics card, and with the drawing
itself left out, as if a card took no time for it, and what of it Python takes. --long plays for
ten minutes and tells the memory on the way. Nothing else should run.
"""

import argparse
import gc
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "system"))

from browser import Page, chromium, until, viewed
from rich.console import Console
from rich.table import Table

from benchmarks.timing import machine

LARGEST = "hexapod-on-3rps"
_ANSWER = """() => new Promise(done => {
    const node = window.__viserMutable.nodeRefFromName['/mechanism/platform'];
    const before = node.position.toArray().join();
    let start = 0;
    const look = () => {
        if (start && node.position.toArray().join() !== before) done(performance.now() - start);
        else setTimeout(look, 0);
    };
    window.addEventListener('keydown', () => { start = performance.now(); }, {once: true});
    look();
})"""

_UNDRAWN = """for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced',
    'drawArraysInstanced']) WebGL2RenderingContext.prototype[name] = () => {};"""


def playing(page: Page, seconds: float) -> float:
    """The share of a core that this process takes while a motion plays."""
    session = page.session
    session.toggle()
    time.sleep(1.0)
    cpu, wall, at = time.process_time(), time.perf_counter(), session.poses
    page.page.wait_for_timeout(1e3 * seconds)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    rate = (session.poses - at) / wall
    session.toggle()
    assert rate > 55, f"only {rate:.0f} poses a second"
    return cpu / wall


def answers(page: Page, count: int = 40) -> list[float]:
    """Milliseconds from a key on a slider to the pose in the page's scene."""
    page.tab("Drive")
    page.press("Home")
    until(lambda: page.session.drive_tab.drive is not None)
    page.page.wait_for_timeout(500)
    found = []
    label = page.page.get_by_text("platform.z [mm]", exact=True)
    thumb = label.locator("xpath=following::*[@role='slider'][1]")
    thumb.focus()
    for k in range(count):
        handle = page.page.evaluate_handle(f"() => {{ window.answer = ({_ANSWER})(); }}")
        page.page.keyboard.press("ArrowRight" if k % 10 < 5 else "ArrowLeft")
        found.append(float(page.page.evaluate("() => window.answer")))
        handle.dispose()
        page.page.wait_for_timeout(250)
    return found


def steps(page: Page, count: int = 40) -> list[float]:
    """Milliseconds that this process takes for such a step, until the pose is on its way."""
    drive_tab, found = page.session.drive_tab, []
    assert drive_tab.drive is not None
    y = drive_tab.drive.y.copy()
    for k in range(count):
        y[2] += 1e-3 if k % 10 < 5 else -1e-3
        start = time.perf_counter()
        drive_tab.to(y)
        found.append(1e3 * (time.perf_counter() - start))
        page.page.wait_for_timeout(100)
    return found


def _spread(times: list[float]) -> str:
    return f"median {np.median(times):.0f} ms, worst of {len(times)} {max(times):.0f} ms"


def resident() -> float:
    """Memory of this process [MB]."""
    status = Path("/proc/self/status").read_text()
    (line,) = (line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--long", action="store_true")
    options = parser.parse_args()
    table = Table("what", "measured", "to reach", box=None, pad_edge=False)
    with chromium() as browser, viewed(browser, LARGEST) as page:
        share = playing(page, 10.0)
        what = f"{LARGEST}, {len(page.session.scene.bodies)} bodies, 60 poses/s"
        table.add_row(what, f"{100 * share:.1f} % of a core", "30 %")
        table.add_row("a slider moved, to the pose in the page", _spread(answers(page)), "")
        if options.long:
            page.session.toggle()
            seen = []
            for _ in range(11):
                gc.collect()
                seen.append(f"{resident():.0f}")
                page.page.wait_for_timeout(60e3)
            page.session.toggle()
            table.add_row("ten minutes' play, memory each minute [MB]", " ".join(seen), "no growth")
    with chromium() as browser:
        browser.add_init_script(_UNDRAWN)
        with viewed(browser, LARGEST) as page:
            table.add_row("the same without the drawing", _spread(answers(page)), "50 ms")
            table.add_row("Python's part of it", _spread(steps(page)), "")
    console = Console(width=120)
    console.print(machine())
    console.print(table)


if __name__ == "__main__":
    main()
