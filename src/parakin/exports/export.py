"""Mechanisms written for other programs; the suffix of the file chooses MJCF, URDF or C."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

from parakin.errors import InputError
from parakin.files.writing import check_writable, replacing
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Mechanism

SUFFIXES = (".xml", ".urdf", ".c")


def check_export(path: Path) -> list[Path]:
    """The files that an export to `path` writes. Raises InputError if one cannot be written."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        found = repr(suffix) if suffix else "no suffix"
        raise InputError(str(path), found, ".xml (MJCF), .urdf or .c")
    paths = [path]
    if suffix == ".urdf":
        paths.append(path.with_suffix(".loops.yaml"))
    elif suffix == ".c":
        paths += [path.with_suffix(".h"), path.with_name(f"{path.stem}_test.c")]
        if re.search(r'["\\\x00-\x1f\x7f]', path.stem):
            expected = "a name that C can include: no quotes, backslashes or control characters"
            raise InputError(str(path), repr(path.stem), expected)
    for each in paths:
        check_writable(each)
    return paths


def export(
    mechanism: Mechanism,
    path: Path,
    driven: Sequence[str] | None = None,
    *,
    forces: bool = False,
    preload: Mapping[str, float] | None = None,
) -> list[Path]:
    """Write a mechanism for another program. If it fails, no file is changed.

    driven: the driven coordinates of the C code, by default the mechanism's own. forces: a function
    of efforts in it, too; preload: what those of redundant actuators are to be nearest to
    [N or N m]. Returns the paths written. Raises InputError, AssemblyError, DrivenError.
    """
    paths = check_export(path)
    suffix = path.suffix.lower()
    if driven is not None and suffix != ".c":
        raise InputError(
            "--driven", f"an export to {suffix}", "one to .c; a model leaves open what is driven"
        )
    if (forces or preload is not None) and suffix != ".c":
        found = f"an export to {suffix}"
        option = "--forces" if forces else "--preload"
        raise InputError(option, found, "one to .c; a model brings its masses along anyway")
    texts: tuple[str, ...]
    if suffix == ".c":
        from parakin.exports.c99.code import c_code

        forces = forces or preload is not None
        texts = c_code(mechanism, path.stem, driven, forces=forces, preload=preload)
    elif suffix == ".urdf":
        from parakin.exports.urdf import urdf

        texts = urdf(graph_of(mechanism))
    else:
        from parakin.exports.mjcf import mjcf

        texts = (mjcf(graph_of(mechanism)),)
    _write(dict(zip(paths, texts, strict=True)))
    return paths


def _write(texts: Mapping[Path, str]) -> None:
    with ExitStack() as stack:
        for path, text in texts.items():
            temporary = stack.enter_context(replacing(path))
            # C includes a file by its name, which need not be UTF-8.
            temporary.write_text(text, "utf-8", "surrogateescape", newline="\n")
