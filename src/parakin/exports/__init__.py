"""Mechanisms and solvers for other programs: MuJoCo's MJCF, URDF with its loops, and C99.

Knows solvers and how files are written. What other programs' files mean when they come in is in
`files`, beside every other reader.
"""
