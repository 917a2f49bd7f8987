# SPDX-License-Identifier: Apache-2.0
"""Run the command `gse` as `python3 -m gse` in the root of the repository."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from hirosco_gse import interrupt

interrupt.hold()

from hirosco_gse.cli import main

sys.exit(main())
