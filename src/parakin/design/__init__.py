"""What a mechanism can do: how far it goes from a pose, and what stops it.

Knows solvers, and looks at them from outside: it follows rays from a pose (`rays`) to where a
limit (`ends`) is met, by root finding; and it asks grids of points (`probing`) for the boundary of
what keeps all limits (`region`). Must not know files, pictures or the command line.
"""
