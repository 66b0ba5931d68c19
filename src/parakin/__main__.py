"""The command line, run as `python -m parakin`."""

import sys

from parakin.cli.main import main

sys.exit(main())
