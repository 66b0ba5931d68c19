"""A mechanism as solids on its bodies, and pictures of these by matplotlib.

Made only from the joints and bodies in the home pose. Knows no time.
"""
