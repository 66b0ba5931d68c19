import sys

from parakin.cli.main import main

sys.exit(main())
