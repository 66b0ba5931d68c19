"""The kinematic scheme: symbols of ISO 3952, labels that avoid overlaps, frames and dimensions.

Works in points on a sheet. Knows a drawing of the mechanism at home, but no result.
"""
