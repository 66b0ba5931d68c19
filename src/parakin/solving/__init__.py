"""From a mechanism to a solver, and from a motion to a labelled result.

`compiler` makes a `solver`, which answers a pose (`inputs` in, a `tick` out) or a motion. One pose
is found by iteration (`walking`, clear of `locks`), without a guess on the way `from_home`. A
motion is followed (`tracking`, a `stretch` at a time) by one rule of `continuity`, on `charts` kept
in an `atlas`; `status` says what became of each sample, `results` labels them. `modes` finds the
other assemblies. What a result means is `analysis`; how it looks, `views`.
"""
