# SPDX-License-Identifier: Apache-2.0
"""The housekeeping that a station enables while a page is open: a structure that it creates for each member, and the structures that a page
shows in tables."""

import contextlib
import shlex
import time

from .. import commands
from ..command import UsageError
from ..dictionary import STATES, DictionaryError
from ..session import SessionError

ID = 9003  # housekeeping structure of the station
PERIOD_US = 50_000  # Period of the housekeeping for the pages.
DISPLAY_STATES = STATES[3:7]  # PRE_OPERATIONAL to ERROR_OPERATIONAL: those with a configuration.
REPORT_TIMEOUT_S = 1.5  # Time without a report after which the housekeeping is requested again.


class Display:
    """Structures that are enabled for the pages of a hub."""

    def __init__(self, hub):
        self._hub = hub
        self.structures = {}  # subsystem -> message
        self._asking = set()  # Subsystems whose structures are being asked for.
        self.enabled = set()  # (subsystem, structure) that this station has enabled for its pages.
        self._seen, self._status_seen, self._asked, self._other_reports = {}, {}, {}, set()

    # Reports ------------------------------------------------------------------------------------------------

    def saw_report(self, apid, structure):
        """A report of a structure has arrived."""
        if structure == ID:
            self._seen[apid] = time.monotonic()

    def saw_status(self, apid):
        """A status report of the subsystem has arrived."""
        self._status_seen[apid] = time.monotonic()

    def saw_other(self, apid):
        """A report with the id of the display structure has arrived, but another station has defined this structure
        with other parameters; the report cannot be decoded."""
        self._other_reports.add(apid)

    # Structures that the station enables --------------------------------------------------------------------

    def keep(self):
        """Create or enable the display housekeeping of each member that does not send it."""
        now, session = time.monotonic(), self._hub.session
        for subsystem in self._hub.dictionary.members:
            apid = subsystem.apid
            is_on = session.configurations.get(apid) and session.states.get(apid) in DISPLAY_STATES
            last = max(self._seen.get(apid, 0), self._asked.get(apid, 0))
            is_alive = now - self._status_seen.get(apid, 0) < REPORT_TIMEOUT_S
            if is_on and is_alive and now - last > REPORT_TIMEOUT_S:
                self._asked[apid] = now
                if words := self._words(subsystem):
                    self._hub.begin_own(self._create(subsystem, words))

    def _words(self, subsystem):
        """Words of `hk create` for a faster copy of the first structure of the present configuration; empty if that structure is fast enough."""
        present = self._hub.session.configurations[subsystem.apid]
        configuration = next((item for item in subsystem.configurations.values() if item.id == present), None)
        structure = next(iter(configuration.structures.values()), None) if configuration else None
        if structure is None or not configuration.sampling_us:
            return []
        if structure.interval * configuration.sampling_us <= PERIOD_US and not structure.repeated:
            return []
        names = [item.name for item in structure.once + tuple(p for _, items in structure.repeated for p in items)]
        cycles = max(1, PERIOD_US // configuration.sampling_us)
        return ["hk", "create", subsystem.name, str(ID), str(cycles), *names]

    def _create(self, subsystem, words):
        """Procedure: create and enable the display structure. A refusal is ignored: another station may have created it."""
        own = f"{subsystem.name} {ID}"
        before = [f"hk disable {own}", f"hk delete {own}"] if subsystem.apid in self._other_reports else []
        self._other_reports.discard(subsystem.apid)
        self.enabled.add((subsystem.name, ID))
        yield from self._hub.quietly([*before, shlex.join(words), f"hk enable {own}"])

    def end(self):
        """Disable the structures that were enabled for pages which are closed now. Returns the calls."""
        asked = [self._hub.begin_own(self._hub.quietly([f"hk disable {name} {number}"])) for name, number in sorted(self.enabled)]
        self.enabled.clear()
        return asked

    def after(self, words, is_for_pages):
        """Function that is called after a command about a housekeeping structure; None for other commands."""
        if len(words) < 3 or words[0] != "hk":
            return None
        verb, subsystem = words[1], self._hub.dictionary.subsystem(words[2])

        def done(call):
            if call.words is None and verb == "enable" and is_for_pages:
                self.enabled.add((subsystem.name, int(words[3], 0)))
            elif call.words is None and verb in ("disable", "delete"):
                self.enabled.discard((subsystem.name, int(words[3], 0)))
            self._hub.begin_own_later(self._ask(subsystem))

        return done

    # States of the structures -------------------------------------------------------------------------------

    def ask(self, name):
        """Publish which housekeeping structures of a subsystem are enabled. Raises UsageError."""
        if not self._hub.is_linked:
            raise UsageError("no link to the spacecraft")
        try:
            subsystem = self._hub.dictionary.subsystem(name)
        except DictionaryError as problem:
            raise UsageError(str(problem)) from problem
        if name not in self._asking:  # The answer is published to all pages.
            self._asking.add(name)
            self._hub.begin_own(self._ask_once(name, subsystem))

    def _ask_once(self, name, subsystem):
        try:
            yield from self._ask(subsystem)
        finally:
            self._asking.discard(name)

    def _ask(self, subsystem):
        """Procedure: request the state of the structures of the present configuration, and of others whose reports have arrived."""
        hub = self._hub
        present = hub.session.configurations.get(subsystem.apid)
        of_present = next((item.structures for item in subsystem.configurations.values() if item.id == present), {})
        wanted = sorted({*of_present, *(number for name, number in hub.housekeeping if name == subsystem.name)})
        rows = []
        for number in wanted:  # One request each: a structure that does not exist would refuse the others.
            with contextlib.suppress(SessionError):
                words = ["tc", subsystem.name, "3,33", f"n=[{number}]"]
                answer = yield from commands.plan(words, hub.dictionary).procedure(hub.session, hub.timeout_ns)
                rows += [row for reply in answer for row in reply.get("rows", ())]
        named = [{"id": row["structure"], "enabled": bool(row["enabled"]), "interval": row["interval"]} for row in rows]
        self.structures[subsystem.name] = {"kind": "structures", "subsystem": subsystem.name, "rows": named}
        hub.publish(self.structures[subsystem.name])
