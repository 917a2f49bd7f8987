# SPDX-License-Identifier: Apache-2.0
"""python3 -m hirosco_gse is the command `gse`."""

import sys

from .cli import main

sys.exit(main())
