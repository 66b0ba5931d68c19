"""The only room that opens files: mechanisms and motions in, tables out, whole or not at all."""

from __future__ import annotations

import os
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

from parakin.errors import InputError, nearest
from parakin.expressions import Parameters, Value
from parakin.graph import Graph
from parakin.mechanism import Body, Joint, Mechanism, Platform
from parakin.motion import Motion, from_table
from parakin.motion_csv import read_motion_csv
from parakin.validation import validated

MAX_BYTES = 1_000_000
_MAX_DEPTH = 12
_COORDINATE_TABLES = ("home", "stated", "guess", "limits")


def catalogue() -> dict[str, str]:
    """Mechanisms that come with parakin: name and title."""
    found = {}
    for entry in sorted(_catalogue_folder().iterdir(), key=lambda item: item.name):
        if entry.name.endswith(".toml"):
            title = tomllib.loads(entry.read_text("utf-8")).get("title", "")
            found[entry.name.removesuffix(".toml")] = str(title)
    return found


def _catalogue_folder() -> Any:
    return resources.files("parakin") / "catalog"


def load(mechanism: str | Path, parameters: Mapping[str, Value] | None = None) -> Mechanism:
    """A mechanism of the catalogue by name, or from a TOML file by path.

    parameters: overrides by name. Raises InputError with file, place, found and expected.
    """
    path = Path(mechanism)
    if str(mechanism) in catalogue():
        text = (_catalogue_folder() / f"{mechanism}.toml").read_text("utf-8")
        origin = str(mechanism)
    elif isinstance(mechanism, str) and not path.suffix and not path.exists():
        raise InputError(
            "mechanism", f"unknown name {mechanism!r}", nearest(mechanism, catalogue())
        )
    else:
        text, origin = read_text(path), str(path)
    table = _with_original(parse_toml(text, origin), origin)
    made = mechanism_from_table(table, origin)
    return made.with_parameters(parameters) if parameters else made


def _with_original(table: dict[str, Any], origin: str) -> dict[str, Any]:
    """A variant's tables laid over those of the catalogue's mechanism it is a variant of."""
    name = table.pop("variant_of", None)
    if name is None:
        return table
    if not isinstance(name, str) or name not in catalogue():
        raise InputError(f"{origin}: variant_of", repr(name)[:80], nearest(str(name), catalogue()))
    text = (_catalogue_folder() / f"{name}.toml").read_text("utf-8")
    original = _with_original(parse_toml(text, name), name)
    for key in ("bodies", "joints"):
        for inner, changes in _table(table.get(key, {}), f"{origin}: {key}").items():
            if inner in original[key]:
                place = f"{origin}: {key}.{inner}"
                original[key][inner] = {**original[key][inner], **_table(changes, place)}
            else:
                original[key][inner] = changes
        table.pop(key, None)
    for key, value in table.items():
        old = original.get(key)
        both = isinstance(value, dict) and isinstance(old, dict)
        original[key] = {**old, **value} if both else value  # type: ignore[dict-item]
    return original


def read_text(path: Path) -> str:
    """A small text file. Raises InputError where it is missing, a folder, too large or no text."""
    try:
        if path.is_dir():
            raise InputError(str(path), "a folder", "a file")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(str(path), error.strerror or "an error", "a readable file") from None
    except ValueError as error:  # a null byte in the path
        raise InputError(repr(str(path)), str(error), "a path") from None
    if len(data) > MAX_BYTES:
        raise InputError(str(path), f"more than {MAX_BYTES} bytes", "a smaller file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}, byte {error.start}", "no UTF-8 text", "UTF-8") from None
    if not text.strip():
        raise InputError(str(path), "an empty file", "a TOML file")
    return text


def parse_toml(text: str, origin: str) -> dict[str, Any]:
    """TOML as nested tables. Raises InputError with the line of a syntax error."""
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(origin, str(error), "TOML") from None
    except (RecursionError, ValueError, OverflowError) as error:
        raise InputError(origin, f"no usable TOML ({error})"[:200], "TOML") from None
    if _depth(table) > _MAX_DEPTH:
        raise InputError(origin, f"tables nested over {_MAX_DEPTH} deep", "a mechanism")
    return table


def _depth(value: object) -> int:
    level, depth = [value], 0
    while level:
        depth += 1
        if depth > _MAX_DEPTH:
            break
        level = [
            inner
            for item in level
            if isinstance(item, (dict, list))
            for inner in (item.values() if isinstance(item, dict) else item)
        ]
    return depth


def mechanism_from_table(table: Mapping[str, Any], origin: str) -> Mechanism:
    """A mechanism from the tables of its file; joints and bodies are tables by name.

    Raises InputError.
    """
    data = dict(table)
    for key in ("bodies", "joints"):
        if key not in data:
            raise InputError(origin, f"no table [{key}]", f"[{key}.NAME] tables")
    data["bodies"] = tuple(
        validated(
            Body,
            {"name": name, **_table(body, f"{origin}: bodies.{name}")},
            f"{origin}: bodies.{name}",
        )
        for name, body in _table(data["bodies"], f"{origin}: bodies").items()
    )
    data["joints"] = tuple(
        validated(
            Joint,
            {"name": name, **_table(joint, f"{origin}: joints.{name}")},
            f"{origin}: joints.{name}",
        )
        for name, joint in _table(data["joints"], f"{origin}: joints").items()
    )
    if "platform" in data:
        place = f"{origin}: platform"
        data["platform"] = validated(Platform, _table(data["platform"], place), place)
    for key in _COORDINATE_TABLES:
        if key in data:
            data[key] = flattened(_table(data[key], f"{origin}: {key}"))
    if "origin" in data:
        raise InputError(f"{origin}: origin", "a key 'origin'", "no such key")
    return Mechanism(**data, origin=origin)


def _table(value: object, place: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError(place, repr(value)[:80], "a table")
    return value


def flattened(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, their keys joined by dots: TOML reads `platform.x = 1` as nested."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= flattened(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat


def load_motion(
    motion: str | Path,
    graph: Graph,
    driven: Mapping[str, float],
    rate: float | None = None,
    smoothing: Mapping[str, float] | float | None = None,
    max_gap: float | None = None,
) -> Motion:
    """A motion of the mechanism by name, or from a TOML or CSV file by path.

    driven: home position of each driven coordinate. rate: samples per second, of motions given
    by laws. smoothing: standard deviation of the noise of recorded positions, SI. max_gap: the
    longest step allowed in recorded data [s]. Raises InputError.
    """
    mechanism = graph.mechanism
    dimensions = {name: graph.dimension(graph.index(name, "driven")) for name in driven}
    path = Path(motion)
    if str(motion) in mechanism.motions:
        table = mechanism.motions[str(motion)]
        name, place = str(motion), f"{mechanism.where}: motions.{motion}"
    elif isinstance(motion, str) and not path.suffix and not path.exists():
        raise InputError(
            f"motion of {mechanism.name}",
            f"unknown name {motion!r}",
            nearest(motion, mechanism.motions),
        )
    elif path.suffix.lower() == ".toml":
        table, name, place = parse_toml(read_text(path), str(path)), path.stem, str(path)
    else:
        if rate is not None:
            raise InputError(str(path), "a rate for recorded data", "no rate: it has its own times")
        return read_motion_csv(path, dimensions, smoothing=smoothing, max_gap=max_gap)
    parameters = Parameters(mechanism.parameters, mechanism.where)
    return from_table(table, name, parameters, driven, dimensions, place, rate=rate)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path`, moved over it at the end; removed if anything fails.

    Raises InputError where it cannot be written.
    """
    try:
        handle, name = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix
        )
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(str(path), reason, "a path that can be written") from None
    os.close(handle)
    temporary = Path(name)
    try:
        if path.is_dir():
            raise InputError(str(path), "a folder", "a file to write")
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    except OSError as error:
        raise InputError(
            str(path), error.strerror or str(error), "a path that can be written"
        ) from None
    finally:
        temporary.unlink(missing_ok=True)
