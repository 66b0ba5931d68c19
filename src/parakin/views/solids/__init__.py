"""A mechanism as solid pieces on its bodies, and how they are painted without a browser.

Made only from the joints and bodies in the home pose. Knows no time.
"""
