# SPDX-License-Identifier: Apache-2.0
"""How a measuring script ends if a program that it runs is missing or fails: with a message, without a stack trace."""

import shlex
import subprocess
import sys
import traceback


def run(main):
    """Run the main function of a script. A missing or failed program, and a false assertion, end the script with exit code 1."""
    try:
        main()
    except subprocess.CalledProcessError as failure:
        command = failure.cmd if isinstance(failure.cmd, str) else shlex.join(map(str, failure.cmd))
        sys.exit(f"{command} ended with exit code {failure.returncode}, expected 0")
    except FileNotFoundError as failure:
        sys.exit(f"{failure.filename} does not exist: `make bench` builds the programs that a measurement runs")
    except OSError as failure:
        sys.exit(str(failure))
    except AssertionError as failure:
        place = traceback.extract_tb(failure.__traceback__)[-1]
        sys.exit(f"{place.filename}:{place.lineno}: {failure if str(failure) else place.line}")
