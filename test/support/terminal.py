# SPDX-License-Identifier: Apache-2.0
"""A program on a pseudo-terminal, into which a test types keys. Each wait is limited, even if the program
writes without end."""

import pexpect

TIMEOUT_S = 600.0


def converse(command, environment, steps, size=(24, 80)):
    """For each (texts, keys): wait until each of the texts is shown, in any order, then type the keys. At last wait for the end of the
    program; (all that it has shown, its exit code). The size is that of the terminal: readline sets COLUMNS and LINES in a process
    and in all that it starts, so they are not passed on."""
    passed = {name: value for name, value in environment.items() if name not in ("COLUMNS", "LINES")}
    child = pexpect.spawn(command[0], command[1:], env=passed, dimensions=size, timeout=TIMEOUT_S, encoding="utf-8",
                          codec_errors="replace", echo=True)
    shown = []
    try:
        for texts, keys in steps:
            awaited = {texts} if isinstance(texts, str) else set(texts)
            while awaited - {""}:
                order = sorted(awaited)
                found = order[child.expect_exact(order)]
                shown += [child.before, found]
                awaited.discard(found)
            child.send(keys)
        child.expect_exact(pexpect.EOF)
        shown.append(child.before)
    finally:
        child.close(force=True)
    return "".join(shown), child.exitstatus
