"""The whole catalogue on the viewer's page: `python tests/system/screenshots.py FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

from browser import chromium, until, viewed

import parakin


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with chromium() as browser:
        for name in parakin.catalogue():
            with viewed(browser, name) as page:
                session = page.session
                until(lambda s=session: s.playback is not None or s.loaded.problem)  # type: ignore[misc]
                notice = page.page.get_by_role("alert").get_by_role("button")
                if notice.count():
                    notice.first.click()
                if page.session.playback is not None:
                    page.session.seek(0.3 * float(page.session.playback.time[-1]))
                page.page.wait_for_timeout(1500)
                page.page.screenshot(path=folder / f"{name}.png")
                print(name, *page.said)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
