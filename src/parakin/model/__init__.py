"""A mechanism as the user describes it, and in numbers: parameters, joints, graph, trees.

Only data, checked when it is made and never changed. Knows joints, frames, limits and the
spanning trees of the joint graph; knows no file, no time and no solution.
"""
