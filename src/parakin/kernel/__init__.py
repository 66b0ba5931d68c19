"""One pose: a plan traced into position, rates and checks, and run as machine code or on NumPy.

`pose` computes it, on any scalar, with rates and accelerations from `connectivity` (eq. 10);
`outputs` says which row of the result holds what. Only `backends` knows heyoka, and `forking` keeps
forked processes clear of its threads. Knows no time, nor what a pose is part of.
"""
