"""What kinematics needs of a MuJoCo model, as a model for MuJoCo's own compiler.

Shapes, contacts, masses and references to other files are left out, so that no file is opened but
the one that the user named. What is left stands on the lines of the file, for MuJoCo's messages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

from parakin.errors import InputError, nearest
from parakin.files.parsing import number
from parakin.files.vocabulary import Word, check_words, language, line_number, line_of

if TYPE_CHECKING:
    from lxml.etree import _Element

_TURN = {"quat", "axisangle", "xyaxes", "zaxis", "euler"}
_COUPLED = {"name", "class", "active", "solref", "solimp"}
_KEPT: dict[str, set[str]] = {
    "mujoco": {"model"},
    "compiler": {"angle", "autolimits", "eulerseq", "coordinate"},
    "option": set(),
    "flag": {"equality", "constraint", "limit"},
    "default": {"class"},
    "worldbody": {"name", "pos", "childclass", *_TURN},
    "body": {"name", "pos", "childclass", *_TURN},
    "frame": {"name", "pos", "childclass", *_TURN},
    "joint": {"name", "class", "type", "pos", "axis", "range", "limited", "ref"},
    "freejoint": {"name"},
    "site": {"name", "class", "type", "size", "pos", "fromto", *_TURN},
    "equality": {"active"},
    "connect": {*_COUPLED, "body1", "body2", "anchor", "site1", "site2"},
    "weld": {*_COUPLED, "body1", "body2", "anchor", "relpose", "site1", "site2", "torquescale"},
}
_KEPT_COUPLING = {*_COUPLED, "joint1", "joint2", "polycoef"}
_NUMBERS = {
    *("pos", "axis", "range", "ref", "fromto", "anchor", "relpose", "torquescale", "polycoef"),
    *("size", "solref", "solimp"),
    *_TURN,
}
_CHOICES: dict[str, tuple[str, ...]] = {
    "limited": ("true", "false", "auto"),
    **dict.fromkeys(("active", "autolimits"), ("true", "false")),
    **dict.fromkeys(("equality", "constraint", "limit"), ("enable", "disable")),
    "angle": ("radian", "degree"),
    "joint type": ("free", "ball", "slide", "hinge"),
    "site type": ("sphere", "capsule", "ellipsoid", "cylinder", "box"),
}
_NAMED = {  # what an attribute names
    **dict.fromkeys(("body1", "body2"), "body"),
    **dict.fromkeys(("joint1", "joint2"), "joint"),
    **dict.fromkeys(("site1", "site2"), "site"),
    **dict.fromkeys(("class", "childclass"), "default"),
}
_HUGE = 1e10  # out of bounds for MuJoCo too
_WRITTEN_OUT = "bodies written out one by one"
_ONE_FILE = "one file, with what it {} written out"
_REFUSED = {
    "include": _ONE_FILE.format("includes"),
    "attach": _ONE_FILE.format("attaches"),
    "replicate": _WRITTEN_OUT,
    "composite": _WRITTEN_OUT,
    "flexcomp": "rigid bodies",
}
_LOOPS = "connect, weld, or joint"
# Ours, before those of the file: skeletons have no masses, and keep the names of fixed bodies.
_COMPILER = '<compiler boundmass="1" boundinertia="1" fusestatic="false"/>'


def mjcf_language(schema: str) -> Word:
    """The words of MJCF. schema: as `mujoco.mj_printSchema` prints it."""
    top = language(schema)
    root = top.inside["mujoco"]
    body = root.inside.pop("(world)body")
    frame = Word(frozenset(_KEPT["frame"]), body.inside)  # frames are not in the schema
    body.inside |= {"body": body, "frame": frame}
    root.inside["worldbody"] = Word(inside=body.inside)
    default = root.inside["default"]
    default.inside["default"] = default
    return top


def check_mjcf(root: _Element, schema: str, origin: str) -> None:
    """Raises InputError on words that are not MJCF's, and on what is not read here.

    schema: as `mujoco.mj_printSchema` prints it. origin: the file, for messages.
    """
    for element in root.iter(*_REFUSED):
        raise InputError(line_of(element, origin), f"<{element.tag}>", _REFUSED[str(element.tag)])
    check_words(root, mjcf_language(schema), origin)
    aligned = False  # the last word counts, as in MuJoCo
    for element in root.iterfind("compiler"):
        aligned = element.get("alignfree", str(aligned).lower()) == "true"
    for element in root.iter("body", "joint", "freejoint", "site", "tendon", "flex", "flexstrain"):
        place = line_of(element, origin)
        _check_body(element, aligned, place)
        within = element.getparent()
        loop = within is not None and within.tag == "equality"
        coupled = loop and element.tag in ("tendon", "flex", "flexstrain")
        if coupled and element.get("active") != "false":
            raise InputError(place, f"an equality of <{element.tag}>", _LOOPS)
    _check_names(root, origin)


def _check_names(root: _Element, origin: str) -> None:
    """Raises InputError on names that nothing in the model has."""
    known = {what: {"main"} if what == "default" else set[str]() for what in _NAMED.values()}
    known["body"].add("world")
    for what, names in known.items():
        key = "class" if what == "default" else "name"
        names |= {str(e.get(key)) for e in root.iter(what) if e.get(key)}
    for element in root.iter("body", "frame", "joint", "site", "connect", "weld"):
        for key, what in _NAMED.items():
            name = element.get(key)
            if name is not None and name not in known[what]:
                place = f"{line_of(element, origin)}: {key}"
                found = f"unknown {'class' if what == 'default' else what} {name!r:.80}"
                raise InputError(place, found, nearest(name, known[what]))


def _check_body(element: _Element, aligned: bool, place: str) -> None:
    """Raises InputError on bodies whose place is not told by joints, or follows from shapes."""
    if element.get("mocap") == "true":
        raise InputError(place, "mocap='true'", "a body that joints move: mocap is not supported")
    if element.tag == "site" and (element.get("mesh") or element.get("type") == "mesh"):
        raise InputError(place, "a site placed by a mesh", "a site with a place of its own")
    free = element.tag == "freejoint" or (element.tag == "joint" and element.get("type") == "free")
    body = next(element.iterancestors("body"), None)
    if not free or body is None or next(body.iterdescendants("body"), None) is not None:
        return
    align = element.get("align", "auto")
    if align == "true" or (align == "auto" and aligned):
        expected = "align='false': otherwise masses, which are not read, place the body's frame"
        raise InputError(place, "a free joint with align='true'", expected)


def skeleton(root: _Element, origin: str) -> str:
    """The model's skeleton as MJCF. Raises InputError on values that are not MJCF's."""
    pieces: list[str] = []
    line = [1]
    _write(root, origin, pieces, line)
    return "".join(pieces)


def used(element: _Element) -> bool:
    """Whether an element is read."""
    within = element.getparent()
    if within is not None and within.tag in ("actuator", "keyframe"):
        return True
    if element.tag == "option" and element.attrib:
        return False
    return element.tag in _KEPT or element.tag in ("actuator", "keyframe")


def _write(element: _Element, origin: str, pieces: list[str], line: list[int]) -> None:
    """Adds an element's text to `pieces`, on its line of the file; `line` is the one reached."""
    tag = str(element.tag)
    within = element.getparent()
    place = line_of(element, origin)
    coupling = tag == "joint" and within is not None and within.tag == "equality"
    made = [tag]
    if tag == "joint" and within is not None and within.tag in ("body", "frame"):
        made.append('armature="1"')  # MuJoCo tries a step, which needs inertia in all directions
    keys = _KEPT_COUPLING if coupling else _KEPT[tag]
    for key in sorted(keys & {str(k) for k in element.attrib}):
        value = str(element.get(key))
        if key in _NUMBERS:
            _check_numbers(value, f"{place}: {key}")
        choices = _CHOICES.get(f"{tag} {key}", _CHOICES.get(key, (value,)))
        if value not in choices:
            raise InputError(f"{place}: {key}", f"{value!r:.80}", nearest(value, choices))
        made.append(f"{key}={quoteattr(value)}")
    down = max(line_number(element) - line[0], 0)
    line[0] += down
    pieces += ["\n" * down, "<", " ".join(made), ">"]
    if within is None:
        pieces.append(_COMPILER)
    for child in element:
        if str(child.tag) in _KEPT:
            _write(child, origin, pieces, line)
    pieces.append(f"</{tag}>")


def _check_numbers(text: str, place: str) -> None:
    """Raises InputError on numbers that MuJoCo would only log a warning about, or accept."""
    if not text.isascii() or not all(abs(number(word)) < _HUGE for word in text.split()):
        raise InputError(place, f"{text!r:.80}", f"finite numbers below {_HUGE:g}")
