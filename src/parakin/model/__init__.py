"""A mechanism as the user describes it, and in numbers: parameters, joints, graph, trees.

`mechanism` is the description, checked by `validation`, with `limbs` that repeat and `expressions`
for values. `evaluation` turns it into a `graph` of `joints`, with frames from `placement` and
`limits`, and its spanning trees. Only data, checked when it is made and never changed. Knows no
file, no time and no solution.
"""
