# SPDX-License-Identifier: Apache-2.0
"""The real-time links for the pages: state, rate, age and losses, which are requested while a page is open."""

import contextlib
import time

from .. import commands
from ..dictionary import SUPERVISOR_APID
from ..session import SessionError

POLL_S = 1.0  # Time between two requests; simulated time must have advanced by half of it.
IDLE_S = 10.0  # Time between two requests while no link is open.
ROLES = {"producer": ("sent",), "consumer": ("received", "lost", "late")}  # Counters that each end of a link has.
COUNTERS = ("sent", "received", "lost", "late")


class Network:
    """Links of the flight of a hub."""

    def __init__(self, hub):
        self._hub = hub
        self.open = set()  # Names of the open links.
        self.message = None
        self._rows = {}  # name -> row
        # Wall-clock time and mission time of the last request, and whether its answer has not arrived yet.
        self._asked_at, self._asked_s, self._is_asking = 0.0, None, False

    def keep(self):
        """Send the requests when they are due, but not while simulated time stands still."""
        now, seconds = time.monotonic(), self._hub.seconds
        pause = POLL_S if any(row["state"] != "closed" for row in self._rows.values()) else IDLE_S
        has_passed = self._asked_s is None or seconds is None or abs(seconds - self._asked_s) >= POLL_S / 2
        if self._hub.dictionary.links and not self._is_asking and has_passed and now - self._asked_at >= pause:
            self._asked_at, self._asked_s = now, seconds
            self._hub.begin_own(self.ask())

    def transition(self, decoded):
        """Publish at once that a link has changed its state."""
        for link in self._hub.dictionary.links:
            if link.number == decoded["link"]:
                self._rows[link.name] = {**self._rows.get(link.name, {"name": link.name}), "state": decoded["state"], "cause": decoded["cause"]}
                self._publish()
        self._hub.begin_own_later(self.ask())

    def ask(self):
        """Procedure: request the states of the links from the supervisor, and the counters from each member."""
        session, dictionary = self._hub.session, self._hub.dictionary
        if not dictionary.links:
            return
        self._is_asking = True
        try:
            with contextlib.suppress(SessionError):
                found = yield from self._ask_ends(session)
                rows = {row["name"]: row for row in found}
                self._rows = {link.name: self._row(link.name, rows.get(link.name)) for link in dictionary.links}
                self._publish()
        finally:
            self._is_asking = False

    def _ask_ends(self, session):
        """Procedure: rows of the supervisor with the counters of the members; each member is asked once."""
        rows = yield from commands.link_rows_of(session, SUPERVISOR_APID, self._hub.timeout_ns)
        ends = {}
        for apid in dict.fromkeys(self._apid(row[role]) for row in rows if row["state"] != "closed" for role in ROLES):
            with contextlib.suppress(SessionError):  # A member that has failed has no counters; the states are those of the supervisor.
                for end in (yield from commands.link_rows_of(session, apid, self._hub.timeout_ns)):
                    ends[apid, end["link"]] = end
        for row in rows:
            for role, counters in ROLES.items():
                end = ends.get((self._apid(row[role]), row["link"]), {})
                row.update({key: end.get(key) for key in counters})
        return rows

    def _apid(self, name):
        return self._hub.dictionary.subsystem(name).apid

    def _row(self, name, found):
        """A row for the page, with the rate [1/s] and the mission time [s] of the last arrival."""
        before, seconds = self._rows.get(name, {}), self._hub.seconds
        if found is None:
            return {"name": name, "state": "closed"}
        row = {"name": name, "state": found["state"], "at": seconds, "period_us": found["properties"]["period_us"],
               **{key: found[key] for key in COUNTERS if found[key] is not None}}
        if before.get("state") == row["state"] and "cause" in before:
            row["cause"] = before["cause"]
        passed = seconds - before["at"] if before.get("at") is not None and seconds is not None else 0
        grown = row.get("received", 0) - before.get("received", 0)
        is_same = "received" in before and grown >= 0
        row["rate"] = round(grown / passed, 1) if is_same and passed > 0 else before.get("rate")
        row["heard"] = seconds if not is_same or grown > 0 else before.get("heard")
        return row

    def _publish(self):
        self.open = {name for name, row in self._rows.items() if row["state"] == "open"}
        self.message = {"kind": "links", "rows": list(self._rows.values())}
        self._hub.publish(self.message)
        self._hub.publish_targets()
