"""The paper: recursion along the circuits (eqs. 1, 8 and 9) and closure of the loops; and assembly.

Equation numbers stand beside the lines; the conditions of connectivity (eq. 10), which follow a
plan's blocks, are in `kernel`. Knows a joint graph and a set of coordinates; knows neither
what is driven nor how it is going to be solved. (Wrenches and virtual powers will be `mechanics`,
the next room.)
"""
