# SPDX-License-Identifier: Apache-2.0
"""Ground segment: packets, dictionary, links, operator, figures and report."""

import pathlib
import re

_HEADER = pathlib.Path(__file__).resolve().parents[2] / "base" / "version.h"
__version__ = re.search(r'HIROSCO_VERSION "([^"]+)"', _HEADER.read_text(encoding="utf-8"))[1]
