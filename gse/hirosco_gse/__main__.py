# SPDX-License-Identifier: Apache-2.0
"""Run the command `gse` as `python3 -m hirosco_gse`."""

from . import interrupt

interrupt.hold()

import sys

from .cli import main

sys.exit(main())
