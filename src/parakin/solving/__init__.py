"""From a mechanism to a solver, and from a motion to a labelled result.

Compiles, follows motions on charts by one rule of continuity, and says of every sample what
became of it. Knows kernels and time. What a result means for a machine is `analysis`, how it looks
`views`.
"""
