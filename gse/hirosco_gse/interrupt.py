# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while a program imports its modules: it waits until the program can handle it. Otherwise Python would print a stack trace."""

import signal


def hold():
    """Let Ctrl-C wait from now on. The first statement of a program."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def release():
    """Deliver Ctrl-C again; one that has waited raises KeyboardInterrupt here."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
