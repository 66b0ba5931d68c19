"""Files that cannot be written, and old ones that are kept."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from linkage import Refusal, contents, in_a_process


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "x.txt"], "x.txt: found the suffix '.txt'; expected one of: .csv, .nc, .parquet"),
        (["-o", "x.cvs"], "did you mean '.csv'?"),
        (["-o", "x"], "x: found no suffix; expected one of: .csv, .nc, .parquet"),
        (["-o", ""], "found no suffix; expected one of: .csv, .nc, .parquet"),
        (["--plot", "x.jpg"], "x.jpg: found the suffix '.jpg'; expected one of: .pdf, .png, .svg"),
        (
            ["-o", "nowhere/x.csv"],
            "nowhere/x.csv: found no such file or directory; expected a file",
        ),
        (
            ["-o", "linkage.toml/x.nc"],
            "linkage.toml/x.nc: found not a directory; expected a file t",
        ),
        (["-o", "folder.csv"], "folder.csv: found a folder; expected a file to write"),
        (
            ["-o", "full.csv"],
            "full.csv: found a special file, such as a device; expected a file to write",
        ),
        (["-o", "loop.csv"], "expected a"),
        (["-o", "a\0.csv"], r"'a\x00.csv': found embedded null byte; expected a path"),
        (["-o", "/proc/x.csv"], "/proc/x.csv: found"),
        (["-o", "x" * 300 + ".csv"], ".csv: found file name too long; expected a file that can be"),
        (["-o", "x.csv", "--plot", "nowhere/x.png"], "nowhere/x.png: found no such file or direct"),
        (["-o", "old.csv", "--plot", "folder.png"], "folder.png: found a folder; expected a file"),
        (
            ["-o", "recorded.csv"],
            "recorded.csv: found a file that the command reads; expected another file",
        ),
        (
            ["-o", "link.csv"],
            "link.csv: found a file that the command reads; expected another file",
        ),
    ],
)
def test_a_result_that_cannot_be_written(arguments: list[str], said: str, refusal: Refusal) -> None:
    Path("folder.csv").mkdir()
    Path("folder.png").mkdir()
    Path("full.csv").symlink_to("/dev/full")
    Path("loop.csv").symlink_to("loop.csv")
    Path("link.csv").symlink_to("recorded.csv")
    Path("recorded.csv").write_text("time,A\n0,0\n")
    assert said in refusal("solve", "linkage.toml", "recorded.csv", *arguments)


@pytest.mark.parametrize(
    ("library", "option", "extra"),
    [
        ("h5netcdf", "-o old.nc", "files"),
        ("h5py", "-o old.nc", "files"),
        ("pyarrow", "-o old.parquet", "files"),
        ("matplotlib", "--plot old.png", "plot"),
    ],
)
def test_a_library_that_is_not_installed_is_named(
    library: str, option: str, extra: str, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda n: None if n == library else find(n))
    message = refusal("solve", "linkage.toml", "motion.toml", *option.split())
    file = option.split()[1]
    assert (
        message
        == f"{file}: found {library} is not installed; expected pip install 'parakin[{extra}]'"
    )


def test_a_device_is_never_replaced(refusal: Refusal) -> None:
    Path("full.csv").symlink_to("/dev/full")
    refusal("solve", "linkage.toml", "motion.toml", "-o", "full.csv")
    assert Path("/dev/full").is_char_device()
    assert Path("full.csv").is_symlink()


LIMITED = """
import resource, sys
import parakin.solving.recipes
from parakin.cli.main import main

# heyoka keeps what it compiles on disk too: not in here
parakin.solving.recipes.has_machine_code = lambda: False
resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))
sys.exit(main())
"""


@pytest.mark.parametrize(
    "command",
    [
        *(f"solve flight-simulator general -o old.{suffix}" for suffix in ("csv", "nc", "parquet")),
        *(f"plot flight-simulator general -o old.{suffix}" for suffix in ("png", "svg", "pdf")),
        *(f"film linkage.toml motion.toml -o old.{suffix}" for suffix in ("gif", "mp4")),
        *(f"draw flight-simulator -o old.{suffix}" for suffix in ("png", "svg", "pdf")),
        "report linkage.toml motion.toml -o old.html",
        "export flight-simulator old.c",
        "export gough-stewart old.xml",
        "export gough-stewart old.urdf",
    ],
)
def test_a_disk_that_fills_up_leaves_the_old_file_and_no_other(
    command: str, linkage_folder: Path
) -> None:
    name = command.rsplit(maxsplit=1)[-1]
    Path(name).write_text("old")
    before = contents(linkage_folder)
    code, err = in_a_process(*command.split(), start=("-c", LIMITED))
    said = f"error: {name}: found file too large; expected a file that can be written\n"
    assert (code, err) == (2, said)
    assert contents(linkage_folder) == before
