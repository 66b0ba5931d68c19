"""Mechanisms and solvers written for other programs: MuJoCo's MJCF, URDF with its loops, C99.

Knows solvers and how files are written. Such files are read in `files`, like all others.
"""
