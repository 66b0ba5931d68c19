"""A browser, and the page of the flight simulator in it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from browser import Page, chromium, viewed


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def simulator(browser: Any) -> Iterator[Page]:
    with viewed(browser, "flight-simulator") as page:
        yield page
