"""Mechanisms and motions by name or path, from any file."""

from __future__ import annotations

from pathlib import Path

import pytest

import parakin
from parakin.exports import export as exports
from parakin.files import reading as files


def test_a_model_read_is_a_file_too(tmp_path: Path) -> None:
    """`parakin check model.xml --expand` gives the TOML of it."""
    pytest.importorskip("mujoco")
    path = exports.export(parakin.load("tricept"), tmp_path / "model.xml")[0]
    (tmp_path / "model.toml").write_text(files.expanded(path))
    assert parakin.load(tmp_path / "model.toml").joints == parakin.load(path).joints
