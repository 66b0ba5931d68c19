"""The command line: parse, call, print.

May import every other package; none imports it. Streams results of any length to files and adds up
what is printed about them on the way.
"""
