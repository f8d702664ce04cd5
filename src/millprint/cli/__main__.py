"""`python -m millprint.cli`: the command `millprint` where it is not on the path."""

import sys

from millprint.cli.commands import main

sys.exit(main())
