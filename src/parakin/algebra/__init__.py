"""Vectors, rotations, dual numbers and small linear systems, on any scalar.

A scalar is a float, a NumPy array, an expression to be compiled or a dual number, and literal
zeros fold away. Knows no mechanism. The formulas here have no branch on a value, so that one text
serves all scalars.
"""
