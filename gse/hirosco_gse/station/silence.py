# SPDX-License-Identifier: Apache-2.0
"""Whether telemetry arrives on a connection that is open: a flight whose processes stand still does not close it."""

import time

# Longest time without telemetry. Members report their status each second of simulated time, and the station requests that of links as often.
LIMIT_S = 3.0
STEP_S = 0.2  # Maximum time that one call of look() counts.


class Silence:
    """Time without telemetry while it is expected. If the station itself was busy or asleep, telemetry may have arrived that it has
    not read yet. Therefore at most STEP_S of that time counts."""

    def __init__(self, clock=time.monotonic):
        self._clock, self._at, self._seconds = clock, clock(), 0.0

    def heard(self):
        """Telemetry has arrived."""
        self._seconds = 0.0

    def look(self, is_expected, speed):
        """Returns whether telemetry is missing. Call it at least each STEP_S. speed: pace of simulated time, 0: as fast as possible."""
        now = self._clock()
        self._seconds = self._seconds + min(now - self._at, STEP_S) if is_expected else 0.0
        self._at = now
        return self._seconds * min(1.0, speed or 1.0) >= LIMIT_S
