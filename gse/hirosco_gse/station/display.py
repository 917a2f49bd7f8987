# SPDX-License-Identifier: Apache-2.0
"""The housekeeping that a station enables while a page is open: the display structure of each member, and the structures that a page shows
in tables. The last station that uses such a structure disables it. If a station was killed, another one takes its structures over."""

import contextlib
import time

from .. import commands
from ..command import UsageError
from ..dictionary import STATES, DictionaryError
from ..session import SessionError
from .display_uses import Uses

DISPLAY_STATES = STATES[3:7]  # PRE_OPERATIONAL to ERROR_OPERATIONAL: those with a configuration.
REPORT_TIMEOUT_S = 1.5  # Time without a report after which the housekeeping is requested again.
LOOK_S = 1.0  # Time after which the lists of the structures that other stations use are read again.


class Display:
    """Structures that are enabled for the pages of a hub. run: directory of the flight, None: no flight."""

    def __init__(self, hub, run=None):
        self._hub = hub
        self._uses = Uses(run) if run else None
        self._others, self._looked = set(), 0.0  # (subsystem, structure) that other stations use, and when that was determined.
        self.structures = {}  # subsystem -> message
        self._asking = set()  # Subsystems whose structures are being asked for.
        self.enabled = set()  # (subsystem, structure) that this station uses: enabled by it, by another one, or by one that was killed.
        self._seen, self._status_seen, self._asked = {}, {}, {}  # by (APID, structure), APID, (APID, structure)

    # Reports ------------------------------------------------------------------------------------------------

    def saw_report(self, apid, structure):
        """A report of a structure has arrived."""
        self._seen[apid, structure] = time.monotonic()

    def saw_status(self, apid):
        """A status report of the subsystem has arrived."""
        self._status_seen[apid] = time.monotonic()

    # Structures that the station enables --------------------------------------------------------------------

    def _use(self, use, is_used=True):
        """Note that this station uses (subsystem, structure), or no longer."""
        if (use in self.enabled) != is_used:
            (self.enabled.add if is_used else self.enabled.discard)(use)
            self._uses.note(use, is_used)

    def _look(self):
        """Every LOOK_S, determine which structures other stations use, and take over those that a killed station has left enabled."""
        now = time.monotonic()
        if now - self._looked >= LOOK_S:
            self._looked = now
            self._others, left = self._uses.of_others()
            for use in sorted(left):
                self._use(use)

    def keep(self):
        """Enable the display structure of each member that is in operation but does not report this structure."""
        self._look()
        now, session = time.monotonic(), self._hub.session
        for subsystem in self._hub.dictionary.members:
            structure = self._structure(subsystem)
            if structure is None or session.states.get(subsystem.apid) not in DISPLAY_STATES:
                continue
            key = subsystem.apid, structure.id
            if (subsystem.name, structure.id) in self._others:
                self._use((subsystem.name, structure.id))
            last = max(self._seen.get(key, 0), self._asked.get(key, 0))
            is_alive = now - self._status_seen.get(subsystem.apid, 0) < REPORT_TIMEOUT_S
            if is_alive and now - last > REPORT_TIMEOUT_S:
                self._asked[key] = now
                self._use((subsystem.name, structure.id))
                self._hub.begin_own(self._hub.quietly([f"hk enable {subsystem.name} {structure.id}"]))

    def _structure(self, subsystem):
        """Display structure of the present configuration of a subsystem; None if a station need not enable one."""
        present = self._hub.session.configurations.get(subsystem.apid)
        configuration = next((item for item in subsystem.configurations.values() if item.id == present), None)
        return configuration.display if configuration else None

    def end(self):
        """Disable the structures that were enabled for pages which are closed now, and that no other station uses. Returns the calls."""
        self._look()
        if not self.enabled:
            return []
        uses, self.enabled = self.enabled, set()
        self._uses.clear()  # Before the lists of others are read: of two stations that end at the same time, at least one then disables.
        living, left = self._uses.of_others()
        return [self._hub.begin_own(self._hub.quietly([f"hk disable {name} {number}"])) for name, number in sorted((uses | left) - living)]

    def close(self):
        """The flight has ended, or the station ends."""
        if self._uses:
            self._uses.clear()

    def after(self, words, is_for_pages):
        """Function that is called after a command about a housekeeping structure; None for other commands."""
        if len(words) < 3 or words[0] != "hk":
            return None
        verb, subsystem = words[1], self._hub.dictionary.subsystem(words[2])

        def done(call):
            if call.failure is None and verb == "enable" and is_for_pages:
                self._use((subsystem.name, int(words[3], 0)))
            elif call.failure is None and verb in ("disable", "delete"):
                self._use((subsystem.name, int(words[3], 0)), False)
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
