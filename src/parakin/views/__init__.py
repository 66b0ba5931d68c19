"""What is seen: figures, films, reports, kinematic schemes, and a page in the browser.

`solids` makes a mechanism's pieces, `scheme` draws it in the symbols of ISO 3952, `browser` serves
it. Looks at mechanisms, solvers and results; computes nothing that belongs in a result.
"""
