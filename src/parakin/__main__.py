"""The command line, run as `python -m parakin`."""

import sys

try:
    from parakin.cli.main import main

    code = main()
except KeyboardInterrupt:  # before it is heard
    code = 130
sys.exit(code)
