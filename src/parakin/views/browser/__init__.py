"""Pages in the browser: motions played, and a mechanism driven by hand on its branch.

Each page is a session of its own. `drive` follows what is asked for and stops where it must; the
rest shows it. Reads no files other than those named at start-up.
"""
