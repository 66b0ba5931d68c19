"""Figures, films, reports, kinematic schemes, and pages in the browser.

`solids` gives the bodies of a mechanism their shapes, `scheme` draws it in the symbols of ISO 3952,
`browser` serves it. Reads mechanisms, solvers and results; computes nothing that belongs in a
result.
"""
