"""What the user says, and the same in numbers: mechanism, parameters with units, joint graph.

Data only, checked when it is made and never changed afterwards. Knows joints, frames and limits;
knows no file, no time and no solution.
"""
