"""Random models of other programs, a few of them; `tests/oracles/random_models.py` reads more."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("mujoco")
pytest.importorskip("lxml")
pytest.importorskip("yaml")

from random_models import JUDGES


@pytest.mark.parametrize("kind", JUDGES)
def test_files_of_others_are_read_rightly_or_refused(kind: str, tmp_path: Path) -> None:
    """Poses, loops, freedom, home, limits and motors as MuJoCo or SciPy have them, to 1e-9."""
    found = {JUDGES[kind](seed, tmp_path) for seed in range(60)}
    assert found >= {"tree", "loops", "misspelt", "refused"}
