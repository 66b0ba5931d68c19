"""Fuzzing of every reader of files with atheris: `python fuzz/readers.py -max_total_time=45`.

An input's first byte chooses the reader, what follows is the file. Seeds are the catalogue and
what is exported from it; options are libFuzzer's, and a file that is named is tried alone.
Anything but something read or an error of ours of one short line stops the run, and so do
crashes, hangs and memory beyond the limits given.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["parakin"]):
    import parakin
    from parakin.exports.export import export
    from parakin.files.datasets import write
    from parakin.files.reading import load_motion
    from parakin.model.evaluation import graph_of

LINKAGE = "four-bar"  # whose motions are read, and whose URDF the YAML is read beside
WORDS = """
<!DOCTYPE <!ENTITY <include file= xi:include <![CDATA[ &amp; &#0; connect weld joint site body
default class= childclass= compiler eulerseq= angle= autolimits= range= limited= ref= axis= pos=
euler= quat= xyaxes= zaxis= axisangle= fromto= anchor= relpose= body1= joint1= polycoef= keyframe
qpos= freejoint frame active= torquescale= loop loop_joint coupling mimic multiplier= predecessor
successor origin xyz= rpy= limit lower= upper= revolute continuous floating planar spherical
inertial mass= diaginertia= fullinertia= inertia ixx= geom density= armature= damping= stiffness=
springref= frictionloss= gravity= tendon spatial springlength= custom gear= dynamics friction=
closures: closed_loop: type: name_mot: joint_name: joint_type: link_a: point: axis: home:
!!python/object &a *a <<: ~ .inf .nan 0x 0o 1:60:60 2020-01-01 [limbs.a] count each {i}
variant_of kind parent child on_parent on_child at axis turns pitch length guess limits stated
nan inf 1e308 1e-308 -0.0 1e999 99999999999999999999 time [mm] [deg/s] .velocity
"""


def seeds(folder: Path) -> None:
    """One file for each reader and mechanism, its first byte the reader's number."""
    names = sorted(parakin.catalogue())
    for number, name in enumerate(names):
        text = Path(parakin.__file__).with_name("catalogue") / f"{name}.toml"
        (folder / f"{name}-toml").write_bytes(b"\0" + text.read_bytes())
        if number % 3:
            continue  # models are long, and much alike
        for place, suffix in ((1, ".xml"), (2, ".urdf")):
            paths = export(parakin.load(name), folder / f"model{suffix}")
            (folder / f"{name}{suffix}").write_bytes(bytes([place]) + paths[0].read_bytes())
            for path in paths[1:]:
                (folder / f"{name}-yaml").write_bytes(b"\3" + path.read_bytes())
            for path in paths:
                path.unlink()
    solver = parakin.compile(LINKAGE, machine_code=False)
    motion = next(iter(solver.mechanism.motions))
    write([solver.solve(solver.motion(motion, rate=10))], folder / "motion.csv")
    (folder / "csv").write_bytes(b"\4" + (folder / "motion.csv").read_bytes())
    (folder / "motion.csv").unlink()
    law = f'{solver.driven[0]} = {{ law = "poly345", by = "10 deg" }}'
    (folder / "law").write_bytes(f'\5duration = "2 s"\n[laws]\n{law}\n'.encode())


def readers(folder: Path) -> list[tuple[str, Callable[[Path], object]]]:
    """Suffix and reader, in the order of an input's first byte."""
    graph = graph_of(parakin.load(LINKAGE))
    driven = dict.fromkeys(graph.mechanism.driven, 0.0)
    (tree, *_) = export(graph.mechanism, folder / "tree.urdf")

    def mechanism(path: Path) -> object:
        return graph_of(parakin.load(path))

    return [
        (".toml", mechanism),
        (".xml", mechanism),
        (".urdf", mechanism),
        (".yaml", lambda path: graph_of(parakin.load(tree, loops=path))),
        (".csv", lambda path: load_motion(path, graph, driven)),
        (".toml", lambda path: load_motion(path, graph, driven)),
    ]


def main() -> None:
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        corpus = folder / "corpus"
        corpus.mkdir()
        seeds(corpus)
        words = folder / "words"
        words.write_text("".join(f'"{word}"\n' for word in WORDS.split()))
        known = readers(folder)
        log = folder / "MUJOCO_LOG.TXT"  # which MuJoCo writes where it warns

        def one(data: bytes) -> None:
            suffix, read = known[data[0] % len(known)] if data else known[0]
            path = folder / f"input{suffix}"
            path.write_bytes(data[1:])
            try:
                read(path)
            except parakin.ParakinError as error:
                text = str(error)
                assert text.isprintable(), ascii(text)
                assert len(text) < 4000, text
            assert not log.exists(), log.read_text()

        kept = f"-artifact_prefix={Path.cwd()}/"  # what made it stop stays, outside the folder
        arguments = [a if a.startswith("-") else str(Path(a).resolve()) for a in sys.argv[1:]]
        os.chdir(folder)
        inputs = [a for a in arguments if not a.startswith("-")] or [str(corpus)]
        flags = [a for a in arguments if a.startswith("-")]
        options = [sys.argv[0], kept, *flags, f"-dict={words}", *inputs]
        atheris.Setup(options, one)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
