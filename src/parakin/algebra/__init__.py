"""Vectors, rotations, dual numbers and small linear systems, on any scalar.

A scalar is a float, a NumPy array, an expression to be compiled or a dual number; literal zeros
fold away. Knows no mechanism. Formulas here never branch on a value, so the same code works for
every type of scalar.
"""
