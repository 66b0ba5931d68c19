import sys

from parakin.cli import main

sys.exit(main())
