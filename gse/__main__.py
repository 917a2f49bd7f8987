# SPDX-License-Identifier: Apache-2.0
"""python3 -m gse, from the root of the repository, is the command `gse`."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from hirosco_gse.cli import main

sys.exit(main())
