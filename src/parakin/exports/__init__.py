"""Mechanisms and solvers written for other programs: MuJoCo's MJCF, URDF with its loops, C99.

MJCF and URDF are written from a mechanism's graph, C from a solver. Such files are read in `files`,
like all others.
"""
