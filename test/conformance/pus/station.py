# SPDX-License-Identifier: Apache-2.0
"""A ground station of a flying mission, for tests of its services: requests by the catalogue, reports
decoded, all recorded.

    answer = station.ask("SUPERVISOR", 11, 18)                  must complete; the fields of its answer TM[11,19]
    station.do("SUPERVISOR", 11, 1)                             must complete
    station.refuse(PAST, "SUPERVISOR", 11, 4, sub_schedule_id=1, n=[...])  must be refused with the failure code PAST

The mission flies in stepped time as fast as it can; no test depends on its speed. Every request that
completed and every report that a test asked for is recorded with the test: docs/pus-coverage.md is made from
these records."""

import collections
import os
import time

import flying
from hirosco_gse.session import LinkLost, Request, TimedOut
from hirosco_gse.spacecraft import Spacecraft, merged

TIMEOUT_S = 120.0  # Ends a wait that would otherwise never end; no test depends on it.
USER = 2
LAST = 40  # Number of reports in the message of a failed wait.
ENDLESS_S = 1_000_000  # Simulated time; the tests end the flight.


class LinkClosed(AssertionError):
    """The spacecraft has closed the connection or has ended."""


class Outcome:
    """Result of a request: its failures by stage and code, and the reports addressed to this station."""

    def __init__(self, verification):
        self.stages = verification.stages
        self.failure = verification.failure
        self.failures = verification.failures
        self.replies = verification.replies

    @property
    def is_completed(self):
        """TM[1,7] has arrived."""
        return 7 in self.stages


class Notes:
    """Messages that have worked, with the tests that have used them."""

    def __init__(self):
        self.requests, self.reports = collections.defaultdict(set), collections.defaultdict(set)
        self.hostile = collections.Counter()

    @staticmethod
    def test():
        """Name of the present test."""
        return os.environ.get("PYTEST_CURRENT_TEST", "").split(" ")[0].split("::")[-1].split("[")[0]


class Station(Spacecraft):
    """One ground user of a flight."""

    def __init__(self, flight, notes, mission="rokviss"):
        dictionary = flying.ROOT / "build" / "generated" / f"{mission}.json"
        super().__init__(flight.directory, port=flight.port(), dictionary=dictionary, user=USER, timeout_s=TIMEOUT_S, first_sequence=0)
        self.flight, self.notes = flight, notes
        self.catalogue = self.dictionary.catalogue
        self.session.listeners.append(self._note)
        self.reports = []  # (packet, decoded) since the last clear()
        self.undecoded = []
        self._connect_to_a_flight()

    def _connect_to_a_flight(self):
        """Raises LinkClosed if there is no link for TIMEOUT_S, or the flight has ended."""
        end = time.monotonic() + TIMEOUT_S
        while not self.is_connected:
            try:
                self.connect(1.0)
            except LinkLost as problem:
                if self.flight.process.poll() is not None or time.monotonic() > end:
                    raise LinkClosed(str(problem)) from problem

    def _note(self, packet, decoded):
        self.reports.append((packet, decoded))
        if "error" in decoded:
            self.undecoded.append((packet.title, decoded["error"], packet.raw.hex()))

    # ---- waiting ----

    def wait(self, condition, what):
        """Wait until the condition holds. Returns its value."""
        try:
            return self.wait_for(condition, what)
        except TimedOut as problem:
            last = [f"{packet.time_ns - self.dictionary.epoch_ns:d} ns {packet.title} {packet.raw.hex()}" for packet, _ in self.reports[-LAST:]]
            raise AssertionError("\n".join([f"{problem}; the last of {len(self.reports)} reports:", *last])) from problem
        except LinkLost as problem:
            raise LinkClosed(f"{problem}\n{self.flight.transcript()}") from problem

    def now(self):
        """Mission time [s] of the last report."""
        return (self.reports[-1][0].time_ns - self.dictionary.epoch_ns) / 1e9 if self.reports else 0.0

    def wait_until(self, seconds):
        """Wait until a report of this mission time or later has arrived."""
        self.wait(lambda: self.now() >= seconds, f"mission time {seconds}")

    def report(self, service, subtype, apid=None, since=0, where=None):
        """Wait for the first report of a message whose fields match, from this index of `reports` on. Returns
        it."""

        def found():
            for packet, decoded in self.reports[since:]:
                if packet.message == (service, subtype) and apid in (None, packet.apid) and (where is None or where(decoded)):
                    return packet, decoded
            return None

        packet, decoded = self.wait(found, f"TM[{service},{subtype}]")
        assert "error" not in decoded, decoded
        self.notes.reports[(service, subtype)].add(self.notes.test())
        return packet, decoded

    # ---- requests ----

    def send(self, subsystem, service, subtype, **fields):
        """Send a request of the catalogue. Returns its verification."""
        apid = self.dictionary.subsystem(subsystem).apid
        data = self.catalogue.encode("TC", service, subtype, fields)
        return self.send_data(apid, service, subtype, data)

    def send_data(self, apid, service, subtype, data):
        """Queue a request with any application data; the next wait of the station sends it. Returns its verification."""
        request = Request(apid, service, subtype, bytes(data), f"TC[{service},{subtype}] to {apid}")
        return self.session.send(request)

    def settle(self, verification):
        """Wait for the end of a request's verification and for the reports that were sent before it. Returns
        the outcome."""
        self.wait(lambda: verification.is_finished, f"end of {verification.request.text}")
        if verification.failure is not None and verification.failure.instruction:
            self.fence(verification.request.apid)  # Further instructions may have failed.
        return Outcome(verification)

    def fence(self, apid):
        """Wait until all reports of an application about the requests sent so far have arrived."""
        ping = self.send_data(apid, 17, 1, b"")
        self.wait(lambda: ping.is_finished, f"end of {ping.request.text}")

    def do(self, subsystem, service, subtype, **fields):
        """Send a request that must complete. Returns its outcome."""
        verification = self.send(subsystem, service, subtype, **fields)
        outcome = self.settle(verification)
        assert outcome.is_completed, f"{verification.request.text}: {outcome.failure.words(self.dictionary)}"
        self.notes.requests[(service, subtype)].add(self.notes.test())
        return outcome

    def ask(self, subsystem, service, subtype, **fields):
        """Send a request that must complete and be answered. Returns the fields of its answer; groups in
        several packets are joined."""
        outcome = self.do(subsystem, service, subtype, **fields)
        answer = self.catalogue.find("TC", service, subtype)["answer"]

        def answers():  # An answer longer than a packet comes in parts, after the completion of its request.
            return [decoded for packet, decoded in outcome.replies if packet.message == (service, answer)]

        parts = self.wait(answers, f"TM[{service},{answer}] in answer to TC[{service},{subtype}]")
        assert not any("error" in part for part in parts), parts
        self.notes.reports[(service, answer)].add(self.notes.test())
        return merged(parts)

    def refuse(self, code, subsystem, service, subtype, **fields):
        """Send a request that must be refused with this code, as a whole or in an instruction. Returns its
        outcome."""
        verification = self.send(subsystem, service, subtype, **fields)
        outcome = self.settle(verification)
        assert outcome.failures, f"{verification.request.text} was performed, 0x{code:04X} expected"
        codes = [failure.code for failure in outcome.failures]
        assert code in codes, f"{verification.request.text}: {[hex(found) for found in codes]}, 0x{code:04X} expected"
        return outcome

    def command(self, *words):
        """Run a command of an operator to its end. Returns the lines of its answer."""
        return "".join(f"{row['text']}\n" for row in super(Station, self).do(*words))


def launch(directory, *options, **how):
    """Start a flight without a scenario; its station ends it."""
    return flying.start(directory, "--scenario", "none", "--duration", ENDLESS_S, "--form", "image", *options, **how)
