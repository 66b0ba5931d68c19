"""What mechanics needs of a MuJoCo model, as a model for MuJoCo's own compiler.

Contacts, pictures and references to other files are left out, so that no file is opened but the one
that the user named; shapes are kept, as bodies weigh what these do. What is left stands on the
lines of the file, for MuJoCo's messages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

from parakin.errors import InputError, nearest
from parakin.files.parsing import number
from parakin.files.vocabulary import Word, check_words, language, line_number, line_of

if TYPE_CHECKING:
    from lxml.etree import _Element

BOUND = 1e-12
"""[kg, kg m²] What MuJoCo has to take for bodies that weigh nothing: it compiles none of these."""
UNSHAPED = "shape "
"""How the skeleton's names of geoms begin whose shape is in another file."""
_AMOUNTS = {"inertiagrouprange", "boundmass", "boundinertia", "settotalmass"}
_TURN = {"quat", "axisangle", "xyaxes", "zaxis", "euler"}
_WEIGHING = {"inertiafromgeom", "balanceinertia", *_AMOUNTS}
_WEIGHED = {"mass", "density", "group", "shellinertia"}
_RESISTING = {"armature", "damping", "frictionloss", "stiffness", "springref"}
_COUPLED = {"name", "class", "active", "solref", "solimp"}
_KEPT: dict[str, set[str]] = {
    "mujoco": {"model"},
    "compiler": {"angle", "autolimits", "eulerseq", "coordinate", *_WEIGHING},
    "option": {"gravity"},
    "flag": {"equality", "constraint", "limit", "gravity", "spring", "damper", "frictionloss"},
    "default": {"class"},
    "worldbody": {"name", "pos", "childclass", *_TURN},
    "body": {"name", "pos", "childclass", *_TURN},
    "frame": {"name", "pos", "childclass", *_TURN},
    "inertial": {"pos", "mass", "diaginertia", "fullinertia", *_TURN},
    "geom": {"class", "type", "size", "pos", "fromto", *_TURN, *_WEIGHED},
    "joint": {"name", "class", "type", "pos", "axis", "range", "limited", "ref", *_RESISTING},
    "freejoint": {"name"},
    "site": {"name", "class", "type", "size", "pos", "fromto", *_TURN},
    "equality": {"active"},
    "connect": {*_COUPLED, "body1", "body2", "anchor", "site1", "site2"},
    "weld": {*_COUPLED, "body1", "body2", "anchor", "relpose", "site1", "site2", "torquescale"},
}
_KEPT_COUPLING = {*_COUPLED, "joint1", "joint2", "polycoef"}
_NUMBERS = {
    *("pos", "axis", "range", "ref", "fromto", "anchor", "relpose", "torquescale", "polycoef"),
    *("size", "solref", "solimp", "mass", "density", "group", "diaginertia", "fullinertia"),
    *("gravity", *_AMOUNTS, *_RESISTING),
    *_TURN,
}
_CHOICES: dict[str, tuple[str, ...]] = {
    "limited": ("true", "false", "auto"),
    **dict.fromkeys(("active", "autolimits"), ("true", "false")),
    **dict.fromkeys((f"flag {key}" for key in _KEPT["flag"]), ("enable", "disable")),
    "inertiafromgeom": ("false", "true", "auto"),
    **dict.fromkeys(("balanceinertia", "shellinertia"), ("true", "false")),
    "angle": ("radian", "degree"),
    "joint type": ("free", "ball", "slide", "hinge"),
    "geom type": (
        *("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"),
    ),
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
# Ours, before those of the file: bodies may weigh nothing, and fixed ones keep their names.
_COMPILER = f'<compiler boundmass="{BOUND}" boundinertia="{BOUND}" fusestatic="false"/>'


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
        expected = "align='false': otherwise masses place the body's frame"
        raise InputError(place, "a free joint with align='true'", expected)


def skeleton(root: _Element, origin: str) -> str:
    """The model's skeleton as MJCF. Raises InputError on values that are not MJCF's."""
    writer = _Writer(root, origin)
    writer.write(root)
    return "".join(writer.pieces)


def used(element: _Element) -> bool:
    """Whether an element is read."""
    within = element.getparent()
    if within is not None and within.tag in ("actuator", "keyframe"):
        return True
    if element.tag == "option":
        return {str(key) for key in element.attrib} <= _KEPT["option"]
    return element.tag in _KEPT or element.tag in ("actuator", "keyframe")


class _Writer:
    """Writes a skeleton; `line` is the line of the file that is reached."""

    def __init__(self, root: _Element, origin: str) -> None:
        self.origin, self.line, self.unshaped = origin, 1, 0
        self.pieces: list[str] = []
        # Classes tell what a geom is that does not say so itself.
        classed = [geom for top in root.iterfind("default") for geom in top.iter("geom")]
        self.vague = any(_mesh_of(geom) for geom in classed)

    def write(self, element: _Element) -> None:
        """Adds an element's text, on its line of the file."""
        tag = str(element.tag)
        within = element.getparent()
        keys = _KEPT_COUPLING if tag == "joint" and _in(within, "equality") else _KEPT[tag]
        made = [tag, *(['contype="0" conaffinity="0"'] if tag == "geom" else [])]
        if tag == "geom" and not _in(within, "default") and self._unshaped(element):
            keys = _WEIGHED | {"class"}
            self.unshaped += 1
            made.append(f'name="{UNSHAPED}{self.unshaped}" type="sphere" size="1"')
        made += self._attributes(element, keys)
        down = max(line_number(element) - self.line, 0)
        self.line += down
        self.pieces += ["\n" * down, "<", " ".join(made), ">"]
        if within is None:
            self.pieces.append(_COMPILER)
        for child in element:
            still = (
                child.tag == "geom" and next(child.iterancestors("body", "default"), None) is None
            )
            if str(child.tag) in _KEPT and not still:
                self.write(child)
        self.pieces.append(f"</{tag}>")

    def _unshaped(self, geom: _Element) -> bool:
        """Whether a geom's shape is in another file."""
        return _mesh_of(geom) or (self.vague and geom.get("type") is None)

    def _attributes(self, element: _Element, keys: set[str]) -> list[str]:
        made, place = [], line_of(element, self.origin)
        for key in sorted(keys & {str(k) for k in element.attrib}):
            value = str(element.get(key))
            if key in _NUMBERS and element.tag != "flag":
                _check_numbers(value, f"{place}: {key}")
            choices = _CHOICES.get(f"{element.tag} {key}", _CHOICES.get(key, (value,)))
            if value not in choices:
                raise InputError(f"{place}: {key}", f"{value!r:.80}", nearest(value, choices))
            if key not in ("boundmass", "boundinertia") or number(value) > BOUND:
                made.append(f"{key}={quoteattr(value)}")
        return made


def _in(within: _Element | None, tag: str) -> bool:
    return within is not None and within.tag == tag


def _mesh_of(geom: _Element) -> bool:
    """Whether a geom names a mesh or a height field, or is said to be one."""
    named = geom.get("mesh") is not None or geom.get("hfield") is not None
    return named or geom.get("type") in ("mesh", "hfield", "sdf")


def _check_numbers(text: str, place: str) -> None:
    """Raises InputError on numbers that MuJoCo would only log a warning about, or accept."""
    if not text.isascii() or not all(abs(number(word)) < _HUGE for word in text.split()):
        raise InputError(place, f"{text!r:.80}", f"finite numbers below {_HUGE:g}")
