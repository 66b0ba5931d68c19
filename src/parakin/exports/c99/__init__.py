"""A solver as plain C99 for a controller: one pose, no allocation, only libm.

Three texts: the kernel, its header, and a program that tests it. The kernel that NumPy runs and
heyoka compiles is traced once more, with scalars that record each operation as a statement in C.
"""
