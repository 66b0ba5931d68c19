"""Both ways of reading the recursion pass the same tests: machine code and NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import parakin
from parakin.kernel.backends import has_machine_code

READINGS = [
    pytest.param(
        True,
        id="machine-code",
        marks=pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed"),
    ),
    pytest.param(False, id="arrays"),
]


@pytest.fixture(scope="session", params=READINGS)
def reading(request: pytest.FixtureRequest) -> bool:
    """Whether machine code is used."""
    return bool(request.param)


@pytest.fixture(scope="session")
def compiled(reading: bool) -> Callable[..., parakin.Solver]:
    """The flight simulator, compiled once per choice of driven coordinates."""
    kept: dict[tuple[str, ...], parakin.Solver] = {}

    def solver(*driven: str) -> parakin.Solver:
        if driven not in kept:
            kept[driven] = parakin.compile(
                "flight-simulator", driven or None, coordinates="all", machine_code=reading
            )
        return kept[driven]

    return solver
