"""Recursion along the circuits (eqs. 1, 8 and 9 of the paper), loop closure, and assembly.

Equation numbers are given beside the code; the conditions of connectivity (eq. 10), which follow
the blocks of a plan, are in `kernel`. Knows a joint graph and a set of coordinates; does not know
what is driven, nor how it will be solved. Wrenches, friction and virtual powers belong in a package
of their own, `mechanics`, next to this one.
"""
