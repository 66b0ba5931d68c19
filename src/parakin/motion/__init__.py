"""What drives a mechanism over time: laws, splines and samples, and the steps to follow them in.

Knows seconds, and position, velocity, acceleration and jerk of named coordinates. Does not know
the mechanism that they drive.
"""
