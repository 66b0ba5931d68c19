"""A mechanism as solid pieces on its bodies, and how they are painted without a browser.

Made from joints and bodies at home alone. Knows no time.
"""
