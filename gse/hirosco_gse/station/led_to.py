# SPDX-License-Identifier: Apache-2.0
"""The reports that each telecommand led to, for the list of commands.

They are its verification reports and, until its verification ends or has not begun in time, of the subsystem that performs it: the reports
of its service, except periodic ones, and the events.
A report to one user belongs to the first open telecommand of that user that it can answer."""

from ..failures import FINAL_SUBTYPES
from ..sentences import told
from ..telemetry import describe
from ..values import shortened

ALL_USERS = 0  # Destination of a report: all ground users.
PERIODIC = {(3, 25), (3, 26), (129, 5)}  # Sent to all users: not the answer to a telecommand.
EVENTS = {(5, 1), (5, 2), (5, 3), (5, 4)}
LISTED_MAX = 40  # Reports of a command that are listed; others are only counted.
WORDS_MAX = 200  # Characters about a report.
UNHEARD_S = 60.0  # Mission time after which a telecommand without any verification report gets no more reports.


class Reports:
    """The reports that the telecommands of one command led to."""

    def __init__(self):
        self.count, self.rows = 0, []  # A row is [mission time in s, name of the message, words].

    def add(self, row):
        self.count += 1
        if len(self.rows) < LISTED_MAX:
            self.rows.append(row)

    def message(self):
        """The part of a message about the command; empty without a report."""
        return {"led_to": {"count": self.count, "rows": list(self.rows)}} if self.count else {}


class _Sent:
    """A telecommand whose verification has not ended."""

    def __init__(self, request, user, answer, reports):
        self.apid, self.service, self.user, self.answer, self.reports = request.apid, request.service, user, answer, reports
        self.since, self.is_heard = None, False  # Mission time of the first report after it; whether a report has verified it.

    def is_lost(self, seconds):
        self.since = seconds if self.since is None else self.since
        return not self.is_heard and seconds - self.since > UNHEARD_S


class LedTo:
    """Assigns reports to the telecommands that led to them."""

    def __init__(self, dictionary):
        self._dictionary, self._open = dictionary, {}  # First 4 octets of a telecommand -> _Sent

    def sent(self, request, request_id, user, reports):
        """A telecommand was sent: `request` has apid, service and subtype. What it leads to is added to `reports`."""
        entry = self._dictionary.catalogue.find("TC", request.service, request.subtype) or {}
        self._open[bytes(request_id)] = _Sent(request, user, entry.get("answer"), reports)

    def end(self):
        """The connection has ended: no report is assigned to telecommands that were sent before."""
        self._open.clear()

    def take(self, seconds, packet, decoded):
        """A report has arrived."""
        self._open = {key: sent for key, sent in self._open.items() if not sent.is_lost(seconds)}
        found = self._verified(packet, decoded) if packet.service == 1 else self._led(packet)
        for reports in {id(sent.reports): sent.reports for sent in found}.values():
            reports.add([round(seconds, 4), packet.title, shortened(self._words(packet, decoded), WORDS_MAX)])

    def _verified(self, packet, decoded):
        request_id = bytes(packet.data[:4])
        sent = self._open.get(request_id)
        if sent:
            sent.is_heard = True
        if packet.subtype in FINAL_SUBTYPES and not (packet.subtype == 4 and decoded.get("instruction")):
            self._open.pop(request_id, None)
        return [sent] if sent else []

    def _led(self, packet):
        of_subsystem = [sent for sent in self._open.values() if sent.apid == packet.apid]
        if packet.message in EVENTS:
            return of_subsystem
        if packet.user == ALL_USERS and packet.message in PERIODIC:
            return []
        of_service = [sent for sent in of_subsystem if sent.service == packet.service and packet.user in (ALL_USERS, sent.user)]
        return ([sent for sent in of_service if sent.answer == packet.subtype] or [sent for sent in of_service if not sent.answer])[:1]

    def _words(self, packet, decoded):
        subsystem = self._dictionary.subsystem_of_apid(packet.apid)
        if decoded["kind"] == "event" and "error" not in decoded and subsystem:
            said = told(subsystem.event(decoded["event"]), decoded["values"])["text"]
            return f"{subsystem.name} {decoded['severity']} {decoded['event']}: {said}"
        return describe(packet, decoded, self._dictionary)
