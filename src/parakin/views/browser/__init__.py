"""Pages in the browser: motions played, and a mechanism driven by hand on its branch.

Each page has its own session. `drive` follows the user's input and stops where it must; the rest
shows it. `guard` lets in no other site's page. Reads only the catalogue and the files named at
start-up.
"""
