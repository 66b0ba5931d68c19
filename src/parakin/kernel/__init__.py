"""One pose: a plan traced into position, rates and checks, and run as machine code or on NumPy.

`pose` says what is worked out, on any scalar, rates and accelerations by `connectivity` (eq. 10),
and `rows` in which row of the outputs it is found. Only `backends` knows heyoka. Knows no time:
what a pose follows from is not its affair.
"""
