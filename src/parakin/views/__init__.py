"""Figures, films, reports, kinematic schemes, and pages in the browser.

`solids` gives the bodies of a mechanism their shapes, `scheme` draws it in the symbols of ISO 3952,
`browser` serves it; `text` is for the terminal. Shows mechanisms and results and changes neither.
What has to be solved to be shown (a pose driven by hand, a motion played or reported) is asked of a
solver; there is no kinematics here.
"""
