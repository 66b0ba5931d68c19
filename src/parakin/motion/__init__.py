"""What drives a mechanism over time: laws, splines and samples, and the steps to follow them in.

A `motion` is made from `laws` or, through `splines`, from data (`sampled`), with `checks` on what
is given; `course` divides it into steps. Knows seconds, and position, velocity, acceleration and
jerk of named coordinates. Does not know the mechanism that they drive.
"""
