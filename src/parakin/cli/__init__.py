"""The command line: parse, call, print.

May import every other package; none imports it. Results of any length are streamed to files, and
what is printed about them is added up on the way. Ctrl-C ends whatever runs (`interrupts`).
"""
