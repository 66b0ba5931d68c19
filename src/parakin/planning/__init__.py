"""How to solve a mechanism for given driven coordinates: joints to cut, rows, order, closed forms.

`ordering` decides, `plan` is what it decides, made once from the closed mechanism at home and never
changed. All numerical decisions are made here, so that none is left for when a pose is solved.
"""
