# SPDX-License-Identifier: Apache-2.0
"""`gse shell`: commands at a prompt, over one connection, with history and completion. It needs no package.

While the prompt waits, a thread receives telemetry, so that the spacecraft need not wait for this user; events that it receives are
shown before the next prompt.
"""

import contextlib
import os
import pathlib
import threading

from . import completion, live, telemetry, usage
from .colours import coloured
from .command import UsageError, words_of
from .dictionary import DictionaryError
from .session import LinkLost, SessionError

HISTORY = "hirosco_gse_history"
HISTORY_MAX = 1000
POLL_S = 0.05  # Period of receiving telemetry while the prompt waits.
SHOWN_EVENTS = 20  # Maximum number of events that are shown before a prompt.
LEAVE = ("exit", "quit")


def _history():
    directory = os.environ.get("XDG_STATE_HOME") or os.path.expanduser("~/.local/state")
    return pathlib.Path(directory) / HISTORY


class Shell:
    """Reads lines with `read(prompt)` and performs them, until `exit`, `quit` or EOFError."""

    def __init__(self, craft, read=input, show=print):
        self._craft, self._read, self._show = craft, read, show
        self._events, self._warned = 0, set()

    # Completion and history ---------------------------------------------------------------------------------

    def _complete(self, text, state):
        import readline

        line = readline.get_line_buffer()[: readline.get_endidx()]
        words = line.split(" ")
        found = completion.candidates([word for word in words[:-1] if word] + words[-1:], self._craft.dictionary)
        return found[state] if state < len(found) else None

    @contextlib.contextmanager
    def _editing(self):
        """Set up the keys of the prompt: Tab completes a word, the arrow keys show earlier lines. A Python without readline has neither."""
        try:
            import readline
        except ImportError:
            yield
            return
        path = _history()
        with contextlib.suppress(OSError):
            readline.read_history_file(path)
        readline.set_history_length(HISTORY_MAX)
        readline.set_completer_delims(" ")
        readline.set_completer(self._complete)
        readline.parse_and_bind("tab: complete")
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                path.parent.mkdir(parents=True, exist_ok=True)
                readline.write_history_file(path)

    # The prompt ---------------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def _listening(self):
        """Receive telemetry in a thread. A lost link is reported by the next command."""
        is_over = threading.Event()

        def listen():
            with contextlib.suppress(LinkLost):
                while not is_over.is_set():
                    self._craft.listen(POLL_S)

        thread = threading.Thread(target=listen)
        thread.start()
        try:
            yield
        finally:
            is_over.set()
            thread.join()

    def _show_events(self):
        for problem in list(self._craft.session.mismatches.values()):
            if problem not in self._warned:
                self._warned.add(problem)
                self._show(coloured(f"gse: warning: {problem}", "warning"))
        new = self._craft.session.events[self._events :]
        self._events += len(new)
        if len(new) > SHOWN_EVENTS:
            self._show(f"({len(new) - SHOWN_EVENTS} events before these)")
        for packet, decoded in new[-SHOWN_EVENTS:]:
            seconds = (packet.time_ns - self._craft.dictionary.epoch_ns) / 1e9
            self._show(coloured(f"{seconds:12.6f}  {telemetry.describe(packet, decoded, self._craft.dictionary)}", decoded.get("severity")))

    def _perform(self, words):
        if words[0] == "help":
            known = len(words) == 2 and words[1] in usage.table()
            self._show(usage.help_of(words[1]) if known else f"{usage.overview()}\n\nhelp COMMAND: one command; exit: leave")
        elif words[0] in live.VERBS:
            seconds = self._craft.live(*words)
            self._show(f"{' '.join(words)}: at {seconds:.4f} s")
        else:
            for row in self._craft.do(*words) if len(words) > 1 else self._craft.do(words[0]):
                self._show(coloured(row["text"], "ok"))

    def _line(self, text):
        try:
            words = words_of(text)
            if words and not self._craft.is_connected:
                self._craft.connect()
            if words:
                self._perform(words)
        except LinkLost as problem:
            self._show(coloured(f"gse: {problem}", "failed"))
            if words[0] not in live.VERBS:
                self._craft.close()
        except (SessionError, UsageError, DictionaryError, OSError, ValueError) as problem:
            self._show(coloured(f"gse: {problem}", "failed"))

    def run(self):
        """Perform commands until the end of the input, `exit` or `quit`."""
        prompt = f"{self._craft.dictionary.mission}> "
        with self._editing():
            while True:
                try:
                    with self._listening():
                        text = self._read(prompt)
                except KeyboardInterrupt:
                    self._show("")
                    continue
                except EOFError:
                    self._show("")
                    return
                self._show_events()
                if text.strip() in LEAVE:
                    return
                try:
                    self._line(text)
                except KeyboardInterrupt:
                    self._show("gse: the wait was ended; the spacecraft may still perform the command")
                self._show_events()
