"""Pipes and devices in place of files are refused, and never waited for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from linkage import Refusal

import parakin
from parakin.files.parsing import read_bytes

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
SPECIAL = "a special file"


@pytest.fixture(autouse=True)
def _pipes(linkage_folder: Path) -> None:
    for suffix in ("", ".toml", ".xml", ".urdf", ".yaml", ".csv", ".stl"):
        os.mkfifo(f"pipe{suffix}")
    Path("zero.toml").symlink_to("/dev/zero")
    Path("zero.csv").symlink_to("/dev/zero")
    Path("robot.urdf").write_text('<robot name="r"><link name="base"/></robot>')


@pytest.mark.parametrize(
    "command",
    [
        "check pipe",
        "check pipe.toml",
        "check pipe.xml",
        "check pipe.urdf",
        "check robot.urdf --loops pipe.yaml",
        "check zero.toml",
        "check /dev/zero",
        "check /dev/stdin",
        "check --expand pipe.toml",
        "modes pipe.toml",
        "draw pipe.toml -o old.png",
        "export pipe.toml old.xml",
        "solve pipe.toml turn",
        "solve linkage.toml pipe",
        "solve linkage.toml pipe.toml",
        "solve linkage.toml pipe.csv",
        "solve linkage.toml zero.toml",
        "solve linkage.toml zero.csv",
        "plot linkage.toml pipe.csv -o old.png",
        "film linkage.toml pipe.toml -o old.gif",
        "report linkage.toml pipe.csv -o old.html",
        "view pipe.toml",
    ],
)
def test_every_command_refuses_them(command: str, refusal: Refusal, tmp_path: Path) -> None:
    if "/dev/stdin" in command:
        read, write = os.pipe()
        kept = os.dup(0)
        os.dup2(read, 0)
    try:
        message = refusal(*command.split())
    finally:
        if "/dev/stdin" in command:
            os.dup2(kept, 0)
            for number in (read, write, kept):
                os.close(number)
    assert "special file" in message


def test_a_mesh_too() -> None:
    pytest.importorskip("trimesh")
    from parakin.views.browser.content import Content, read_mesh

    with pytest.raises(parakin.InputError, match=SPECIAL):
        read_mesh(Path("pipe.stl"))
    content = Content("four-bar", motions=("pipe.csv", "pipe.toml"), meshes=("pipe.stl",))
    findings = content.findings(content.load("four-bar"))
    assert [finding.split(":")[0] for finding in findings] == ["pipe.csv", "pipe.toml", "pipe.stl"]
    assert all("special file" in finding for finding in findings)


def test_a_link_to_a_file_is_a_file() -> None:
    Path("link.toml").symlink_to("linkage.toml")
    assert read_bytes(Path("link.toml"), 10**6) == Path("linkage.toml").read_bytes()
