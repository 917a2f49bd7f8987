# SPDX-License-Identifier: Apache-2.0
"""Commands of browsers while they are under way, and the ground session in which they run."""

import math

from ..session import Session
from .led_to import Reports
from .lights import lights_of

SILENT_NS = 10_000_000_000  # A request without any report for this simulated time has no answer yet.


class Call:
    """A command of a browser: its procedure while it is under way, its telecommands and its result."""

    def __init__(self, number, text, procedure, seconds, line="", at_end=None):
        """line: words of the command line; at_end(call): called when the command has ended."""
        self.number, self.text, self.procedure, self.seconds, self.line, self.at_end = number, text, procedure, seconds, line, at_end
        self.verifications, self.reports, self.is_over = [], Reports(), False
        self.failure = self.code = None  # Text and code of the failure of the command.
        self.is_unknown = False  # The command has ended, and the spacecraft has not reported whether it was performed.
        self.is_silent = False  # No report has arrived for SILENT_NS.
        self.answer, self.rows = [], []

    def note_silence(self, now_ns):
        """Set is_silent: the spacecraft has not reported on a telecommand of this command for SILENT_NS."""
        self.is_silent = any(not each.stages and not each.is_finished and now_ns - each.sent_ns > SILENT_NS for each in self.verifications)

    def message(self):
        failure = {"words": self.failure, "code": self.code, "unknown": self.is_unknown} if self.failure else {}
        return {
            "kind": "command",
            "number": self.number,
            "text": self.text,
            "line": self.line,
            "time": self.seconds,
            "lights": lights_of(self.verifications),
            "over": self.is_over,
            "silent": self.is_silent,
            "answer": self.answer,
            **self.reports.message(),
            **failure,
        }


class WebSession(Session):
    """Session that reports to the hub which telecommands a command has sent, and the octets of each packet. It uses the time of the
    telemetry, so that a long command, a pause or a slow simulation causes no time-out. Only the spacecraft decides whether a request
    has failed; after a loss of the link this is unknown."""

    on_sent = staticmethod(lambda verification: None)
    on_packet = staticmethod(lambda raw: None)
    is_time_known = False

    def advance(self, packet_ns):
        """Telemetry of this time has arrived."""
        if not self.is_time_known and packet_ns > self.now_ns:
            self.slipped_ns += packet_ns - self.now_ns  # No request has waited during this time.
            for verification in self._open.values():
                verification.sent_ns = packet_ns
        self.is_time_known = True
        self.now_ns = max(self.now_ns, packet_ns)

    def finish(self, verification, timeout_ns):
        return (yield from super().finish(verification, math.inf))

    def send_raw(self, raw, request):
        verification = super().send_raw(raw, request)
        self.on_sent(verification)
        return verification

    def _put(self, raw):
        super()._put(raw)
        self.on_packet(raw)
