"""Compiled solvers kept in the user's folder: the plan and its machine code, by what made them."""

from __future__ import annotations

import functools
import hashlib
import io
import os
import pickle
import platform
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from parakin.files import keeping
from parakin.kernel.backends import Kernel, has_machine_code, made_by, packed, unpacked
from parakin.kernel.outputs import Outputs
from parakin.model.mechanism import Mechanism
from parakin.planning.plan import Plan
from parakin.version import __version__

_MECHANISM = "mechanism"  # it is at hand, as part of the key, and not kept


class Kept(NamedTuple):
    """own: all coordinates at home; reported: how many of the outputs' coordinates are."""

    own: tuple[float, ...]
    plan: Plan
    outputs: Outputs
    reported: int
    kernel: Kernel


def key_of(mechanism: Mechanism, *asked: object) -> str | None:
    """All that a solver depends on: the mechanism, what is asked of it, the programs that make it
    and the processor. None where nothing is to be kept, or that cannot be told.
    """
    if keeping.folder() is None or not has_machine_code():
        return None
    source = _source()
    try:
        return source and f"{source}\n{made_by()}\n{_told((mechanism, asked))}"
    except (TypeError, RecursionError):
        return None


def found(key: str, mechanism: Mechanism) -> Kept | None:
    """What was kept of a solver of this mechanism."""
    content = keeping.find(key)
    if content is None:
        return None
    try:
        own, plan, outputs, reported, code = _Reader(content, mechanism).load()
        return Kept(own, plan, outputs, reported, unpacked(code))
    except Exception:  # whatever a foreign object raises: it is compiled anew
        return None


def keep(key: str, mechanism: Mechanism, made: Kept) -> None:
    """Keep what was made."""
    code = packed(made.kernel)
    if code is None:
        return
    stream = io.BytesIO()
    try:
        _Writer(stream, mechanism).dump((*made[:-1], code))
    except Exception:  # whatever somebody else's object raises
        return
    keeping.keep(key, stream.getvalue())


class _Writer(pickle.Pickler):
    def __init__(self, stream: io.BytesIO, mechanism: Mechanism) -> None:
        super().__init__(stream, protocol=5)
        self._mechanism = mechanism

    def persistent_id(self, obj: Any) -> str | None:
        return _MECHANISM if obj is self._mechanism else None


class _Reader(pickle.Unpickler):
    def __init__(self, content: bytes, mechanism: Mechanism) -> None:
        super().__init__(io.BytesIO(content))
        self._mechanism = mechanism

    def persistent_load(self, pid: Any) -> Mechanism:
        if pid != _MECHANISM:
            raise pickle.UnpicklingError
        return self._mechanism


@functools.cache
def _source() -> str:
    """The programs, but for heyoka: parakin by the text of its source, as that of a version under
    development changes. "" where it has none.
    """
    root = Path(__file__).parents[1]
    paths = sorted(
        os.path.join(where, name)
        for where, _, names in os.walk(root)
        for name in names
        if name.endswith(".py")
    )
    if not paths:
        return ""
    digest = hashlib.sha256()
    try:
        for path in paths:
            with open(path, "rb") as stream:
                text = stream.read()
            digest.update(f"{os.path.relpath(path, root)} {len(text)}\n".encode() + text)
    except OSError:
        return ""
    system = f"{platform.system()} {platform.release()} {platform.machine()}"
    versions = f"Python {sys.version}, NumPy {np.__version__}, {system}"
    return f"parakin {__version__} {digest.hexdigest()}, {versions}"


def _told(value: object) -> str:
    """A value as text, the same for equal ones alone. Raises TypeError on one of another kind."""
    kind = type(value)
    if value is None or kind in (bool, int, float, str, np.float64):
        return repr(value)
    if isinstance(value, BaseModel):
        fields = ", ".join(f"{n}={_told(getattr(value, n))}" for n in type(value).model_fields)
        more = _told((value.__pydantic_extra__, value.__pydantic_private__))
        return f"{kind.__module__}.{kind.__qualname__}({fields}, {more})"
    if kind in (tuple, list):
        return f"{kind.__name__}({', '.join(_told(each) for each in value)})"  # type: ignore[attr-defined]
    if isinstance(value, Mapping):  # in its order, which numbers what it names
        pairs = ", ".join(f"{_told(name)}: {_told(each)}" for name, each in value.items())
        return f"{kind.__name__}({pairs})"
    raise TypeError(f"{kind}")
