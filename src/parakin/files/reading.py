"""Mechanisms and motions, by name or from a file of any format that parakin reads."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from parakin.errors import InputError, nearest, printable
from parakin.files.mechanism_toml import mechanism_from_table, table_at
from parakin.files.mesh_moments import with_mesh_moments
from parakin.files.motion_csv import read_motion_csv
from parakin.files.motion_toml import motion_from_table
from parakin.files.parsing import parse_toml, parse_xml, parse_yaml, read_text
from parakin.model.expressions import Bare, Parameters, Value
from parakin.model.graph import Graph
from parakin.model.limbs import expand_limbs
from parakin.model.mechanism import Mechanism
from parakin.motion.motion import Motion


def catalogue() -> dict[str, str]:
    """The mechanisms that come with parakin: titles by name."""
    return {
        name: str(tomllib.loads(_catalogue_text(name)).get("title", ""))
        for name in _catalogue_names()
    }


def _catalogue_names() -> list[str]:
    files = (entry.name for entry in _catalogue_folder().iterdir())
    return sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml"))


def _catalogue_text(name: str) -> str:
    return str((_catalogue_folder() / f"{name}.toml").read_text("utf-8"))


def _catalogue_folder() -> Any:
    return resources.files("parakin") / "catalogue"


def loaded(
    mechanism: Mechanism | str | Path, parameters: Mapping[str, Value] | None = None
) -> Mechanism:
    """A mechanism as it is, or `load`ed, with parameters overridden by name, and its meshes of a
    density measured. Raises InputError.
    """
    if not isinstance(mechanism, Mechanism):
        mechanism = load(mechanism)
    mechanism = with_mesh_moments(mechanism)
    return mechanism.with_parameters(parameters) if parameters else mechanism


def load(
    mechanism: str | Path,
    parameters: Mapping[str, Value] | None = None,
    loops: str | Path | None = None,
) -> Mechanism:
    """A mechanism of the catalogue by name, or from a TOML, MJCF (.xml) or URDF file by path.

    parameters: overrides by name. loops: the YAML file that specifies the loops of a URDF. No
    other file is read, but for meshes of a density in the mechanism's folder or below. Raises
    InputError with file, place, found and expected.
    """
    if _is_xml(mechanism):
        made = _from_xml(Path(mechanism), None if loops is None else Path(loops))
    elif loops is not None:
        raise InputError(
            str(mechanism), "a separate file of loops", "a URDF; other files contain their loops"
        )
    else:
        table, origin = _tables(mechanism)
        made = mechanism_from_table(table, origin)
    made = with_mesh_moments(made)
    return made.with_parameters(parameters) if parameters else made


def _is_xml(mechanism: str | Path) -> bool:
    return Path(mechanism).suffix.lower() in (".xml", ".urdf")


def _as_table(mechanism: Mechanism) -> dict[str, Any]:
    """A mechanism as the tables of a TOML file."""
    table = mechanism.model_dump(exclude_defaults=True, exclude={"origin"}, by_alias=True)
    for key in ("bodies", "joints"):
        table[key] = {entry.pop("name"): entry for entry in table[key]}
    return table


def _from_xml(path: Path, loops: Path | None) -> Mechanism:
    """A mechanism from MJCF or URDF, whichever the root element says it is."""
    root = parse_xml(read_text(path), str(path))
    if root.tag == "mujoco":
        from parakin.files.mjcf import mechanism_from_mjcf

        if loops is not None:
            raise InputError(
                str(path), "a separate file of loops", "a URDF; other files contain their loops"
            )
        return mechanism_from_mjcf(root, str(path))
    if root.tag == "robot":
        from parakin.files.urdf import mechanism_from_urdf

        table = None if loops is None else parse_yaml(read_text(loops), str(loops))
        return mechanism_from_urdf(root, str(path), table, str(loops))
    raise InputError(str(path), f"<{root.tag}>", "<mujoco> (MJCF) or <robot> (URDF)")


def expanded(
    mechanism: str | Path,
    parameters: Mapping[str, Value] | None = None,
    loops: str | Path | None = None,
) -> str:
    """A mechanism as TOML, with variants, repeated limbs and overrides written out.

    The arguments are those of `load`. Raises InputError.
    """
    import tomli_w

    if _is_xml(mechanism):
        return tomli_w.dumps(_as_table(load(mechanism, parameters, loops)))
    table, origin = _tables(mechanism)
    table = expand_limbs(table, origin)
    if parameters:
        table["parameters"] = {**table.get("parameters", {}), **parameters}
    return tomli_w.dumps(table)


def _tables(mechanism: str | Path) -> tuple[dict[str, Any], str]:
    """The tables of a mechanism's file, merged into those it is a variant of, and its name."""
    path = Path(mechanism)
    known = _catalogue_names()
    if str(mechanism) in known:
        text = _catalogue_text(str(mechanism))
        origin = str(mechanism)
    elif isinstance(mechanism, str) and _is_name(mechanism):
        expected = f"a file, or {nearest(mechanism, known)}"
        raise InputError("mechanism", f"unknown name {mechanism!r}", expected)
    else:
        text, origin = read_text(path), str(path)
    return _with_original(parse_toml(text, origin), origin), origin


def _is_name(text: str) -> bool:
    """Whether `text`, unknown to the catalogue, was meant as a name rather than as a file."""
    try:
        return not text or not (Path(text).suffix or Path(text).exists())
    except OSError:  # too long for a file's name
        return True


def _with_original(table: dict[str, Any], origin: str) -> dict[str, Any]:
    """A variant's tables merged into those of the catalogue's mechanism it is a variant of."""
    name = table.pop("variant_of", None)
    if name is None:
        return table
    if not isinstance(name, str) or name not in _catalogue_names():
        raise InputError(
            f"{origin}: variant_of", repr(name), nearest(str(name), _catalogue_names())
        )
    text = _catalogue_text(name)
    original = _with_original(parse_toml(text, name), name)
    for key in ("bodies", "joints"):
        original.setdefault(key, {})  # there are none if all are in limbs
        for inner, changes in table_at(table.get(key, {}), f"{origin}: {key}").items():
            if inner in original[key]:
                place = f"{origin}: {key}.{inner}"
                original[key][inner] = {**original[key][inner], **table_at(changes, place)}
            else:
                original[key][inner] = changes
        table.pop(key, None)
    for key, value in table.items():
        old = original.get(key)
        both = isinstance(value, dict) and isinstance(old, dict)
        original[key] = {**old, **value} if both else value  # type: ignore[dict-item]
    return original


def load_motion(
    motion: str | Path,
    graph: Graph,
    driven: Mapping[str, float],
    rate: float | None = None,
    smoothing: Mapping[str, float] | float | None = None,
    max_gap: float | None = None,
    bare: list[Bare] | None = None,
) -> Motion:
    """A motion of the mechanism by name, or from a TOML or CSV file by path.

    driven: home positions of the driven coordinates [m or rad]. rate: samples per second, for
    motions given by laws. smoothing: standard deviation of the noise in sampled positions [m or
    rad], one for all or by coordinate. max_gap: longest step allowed between samples [s]. bare: a
    list that takes note of numbers without a unit. Raises InputError.
    """
    mechanism = graph.mechanism
    dimensions = {name: graph.dimension(graph.index(name, "driven")) for name in driven}
    path = Path(motion)
    if str(motion) in mechanism.motions:
        table = mechanism.motions[str(motion)]
        name, place = str(motion), f"{mechanism.where}: motions.{motion}"
    elif isinstance(motion, str) and _is_name(motion):
        raise InputError(
            f"motion of {mechanism.name}",
            f"unknown name {motion!r}",
            f"a file, or {nearest(motion, mechanism.motions)}",
        )
    elif path.suffix.lower() == ".toml":
        table, name = parse_toml(read_text(path), str(path)), printable(path.stem)
        place = f"{path}: motion"
    else:
        if rate is not None:
            raise InputError(
                str(path),
                "a rate for a motion given by samples",
                "no rate: samples have their own times",
            )
        return read_motion_csv(path, dimensions, smoothing=smoothing, max_gap=max_gap)
    for option, given in (("smoothing", smoothing), ("max_gap", max_gap)):
        if given is not None:
            raise InputError(place, f"{option} for a motion given by laws", "one given by samples")
    parameters = Parameters(mechanism.parameters, mechanism.where, bare)
    return motion_from_table(table, name, parameters, driven, dimensions, place, rate=rate)
