"""Mechanisms and solvers for other programs: MuJoCo's MJCF, URDF with its loops, and C99.

Knows solvers and how files are written. Reading such files is in `files`, with the other readers.
"""
