# SPDX-License-Identifier: Apache-2.0
"""Colours of texts on a terminal. Only texts with a meaning are coloured; files, pipes and a user with NO_COLOR (no-color.org) get no colours."""

import os
import sys

SEVERITIES = {"INFORMATIVE": None, "LOW": "36", "MEDIUM": "33", "HIGH": "1;31"}
CODES = {"failed": "31", "warning": "33", "ok": None, **SEVERITIES}


def is_coloured(stream=None):
    """Whether texts on a stream, by default standard output, are coloured."""
    stream = stream or sys.stdout
    return bool(stream and stream.isatty()) and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def coloured(text, meaning, stream=None):
    """The text in the colour of its meaning: a severity of events, "failed", "warning"; unchanged without a colour."""
    code = CODES.get(meaning)
    return f"\x1b[{code}m{text}\x1b[0m" if code and is_coloured(stream) else text
