"""The user's description of a mechanism, and its numerical form: parameters, joints, graph, trees.

Data only, checked when it is made and never changed afterwards. Knows joints, frames, limits and
the spanning trees of the joint graph; knows no file, no time and no solution.
"""
