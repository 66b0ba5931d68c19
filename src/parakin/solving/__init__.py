"""From a mechanism to a solver, and from a motion to a labelled result.

`compiler` makes a `solver` by one of `recipes`, and it solves a pose (`inputs` in, a `tick` out,
made by `answers`) or a motion. One pose is found by iteration (`walking`, clear of `locks`), or
`from_home` without a guess. A motion is followed (`tracking`, a `stretch` at a time) by one rule of
`continuity`, on `charts` kept in an `atlas`. `status` says what became of each sample and `stops`
what stopped it, `crossings` since when; `results` labels them, `bodies` adds the motion of bodies.
`modes` finds the other assembly modes among `assemblies` from random starts, brought near them by
`descent`, and tells by their `usability` which could be built. What a result means is in
`analysis`, how it looks in `views`.
"""
