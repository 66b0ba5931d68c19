"""The command line: parse, call, print.

Knows all other rooms and is known by none. Works out nothing itself: each command calls the
functions that a user of the library would.
"""
