"""The paper's recursion along the circuits (eqs. 1 and 7 to 9), loop closure, and assembly.

`recursion` goes from body to body, `loops` has the ends of each loop, `closure` the rows that
vanish when it is closed; `readings` reads off the other coordinates, `cones` how far joints are
bent. `configuration` is a mechanism
at one moment, `free_motions` what its loops allow there, `assembly` closes it. The conditions of
connectivity (eq. 10), which follow the blocks of a plan, are in `kernel`. Knows a joint graph and
its coordinates, but not what is driven, nor how it will be solved. Wrenches, friction and virtual
powers belong in a package of their own, `mechanics`, between this one and `planning`.
"""
