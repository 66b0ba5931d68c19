"""What a mechanism or a result means: mobility, singularities, and what moves, in words.

`mobility` counts the freedoms of a mechanism, `freedom` finds what goes free at a pose,
`singularities` what a motion comes near or crosses, and `twists` puts it in words; `diagnosis`
finds what is wrong in a mechanism before it is solved. Looks at solvers
and results and changes neither. Prints and draws nothing. Workspace, sizing and optimisation belong
in a package of their own, `design`, above this one.
"""
