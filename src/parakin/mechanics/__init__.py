"""Mechanics: the wrenches that bodies need, and what they ask of joints, by virtual powers.

Beside the recursion, on any scalar like it: `wrenches` says what moves and loads each body,
`powers` gathers that along the tree, from its ends to the base, `resistance` says what acts in
joints. It knows circuits and closure rows, but no plan: which rows are solved, in which order, is
not its business.
"""
