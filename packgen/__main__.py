"""``python -m packgen``."""

import sys

from packgen.cli import main

sys.exit(main())
