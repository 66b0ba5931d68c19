"""How a mechanism is solved for what is driven: joints to cut, rows, and their order.

A plan is data, made once from the closed mechanism at home and never changed. Numbers are looked at
here, so that nothing has to be decided while a pose is solved.
"""
