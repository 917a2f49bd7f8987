# SPDX-License-Identifier: Apache-2.0
"""A client of a flying spacecraft, for scripts and tests.

    from hirosco_gse.spacecraft import Spacecraft

    with Spacecraft() as craft:                                         # the flight in runs/latest
        craft.do("state all PRE_OPERATIONAL")                           # any command of `gse`
        craft.cmd("MANIPULATOR.MOVE_TO", position=[0.9, -1.3], duration=2)
        craft.wait_state("MANIPULATOR", "OPERATIONAL")
        print(craft.get("MANIPULATOR.TORQUE_LIMIT"))                    # [38.0, 38.0]
        craft.wait_event("MANIPULATOR", "TARE_DONE")
        craft.wait_value("MANIPULATOR.CUR_VALUES.POSITION", lambda joints: joints[0] > 0.8)
        craft.hand("aim", 0.1, 0, 0.5)                                  # the simulated world, with TIME=real

Names are those of the mission dictionary and are not case-sensitive; values are numbers, words of enumerations, or lists of them.
A parameter or argument of one element is a scalar, one of several a list, a structure a dict.

Every call returns when its result is known, and raises otherwise:

    UsageError, DictionaryError    no such name, or a value that does not fit; nothing was sent
    Rejected                       the spacecraft refused the request or failed to perform it, with the reason in words
    TimedOut                       an expected report did not come within timeout_s of wall-clock time
    LinkLost                       no connection, or the spacecraft has closed it
    live.LiveRefused               the simulator refused a line of the live world

A Spacecraft has one connection and belongs to one thread; several may command the same flight. Telemetry is received while a call waits,
so events and states between two calls are known at the end of the second call. A program that must not block uses the same calls as
`await craft.cmd(...)`, several at once: async_spacecraft.AsyncSpacecraft. A scenario in stepped time runs the same procedures with
link.StepDriver within the grants of the scheduler.
"""

import math

from . import commands, link, live, sdls, telemetry
from .command import words_of
from .dictionary import Dictionary
from .run_directory import LOOPBACK, Place, compare_classes
from .session import GROUND_USER, LinkLost, Request, Session, TimedOut

TIMEOUT_S = 20.0


def merged(parts):
    """Fields of an answer that came in several packets: their groups one after the other."""
    whole = dict(parts[0])
    for part in parts[1:]:
        for name, value in part.items():
            if isinstance(value, list) and name.startswith("n"):  # Names of repetitions begin with n.
                whole[name] = whole[name] + value
    return whole


def _plain(value):
    """A value as this module returns it."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    return value[0] if len(value) == 1 else list(value)


def _text(value):
    """A value in the form that the operator's commands accept."""
    if isinstance(value, (list, tuple)):
        return ",".join(map(_text, value))
    return str(value).lower() if isinstance(value, bool) else str(value)


def _words(words):
    return words_of(words[0]) if len(words) == 1 else [_text(word) for word in words]


class Spacecraft:
    """One ground user of a flight (see above)."""

    def __init__(self, run=None, *, host=LOOPBACK, port=None, key=None, dictionary=None, user=GROUND_USER, timeout_s=TIMEOUT_S, first_sequence=None):
        """run: directory of the flight, by default runs/latest; it names port, key file and dictionary where they are not given.
        user: its id in the packets; first_sequence: first sequence count of each APID, None: at random. Raises DictionaryError, SecurityError."""
        self.place = Place.of(run, host, port, key, dictionary)
        self.dictionary = Dictionary.load(self.place.dictionary)
        self.timeout_s = timeout_s
        self._sender = sdls.Sender(self.place.key) if self.place.key else None
        self.session = Session(self.dictionary, first_sequence, user, self._sender or bytes)
        compare_classes(self.place, self.session)
        self._stream = self._driver = self._world = None

    # Connection ---------------------------------------------------------------------------------------------

    def connect(self, timeout_s=0.0):
        """Open the connection, with attempts for timeout_s; returns self. An earlier connection is closed first. Raises LinkLost."""
        self.close()
        self._stream = self._open(timeout_s)
        self._driver = link.RealDriver(self._stream, self.session, self.dictionary.epoch_ns)
        return self

    @property
    def is_connected(self):
        """Whether there is a connection; the spacecraft may have closed it since the last call."""
        return self._stream is not None

    def _open(self, timeout_s=0.0):
        self.place.check()
        if self._sender:
            self._sender.begin_anew()
        return link.connect(self.place.host, self.place.port, timeout_s)

    def join(self, cosimulation, report, visits, timeout_s):
        """From now on take part in the scheduler of a flight in stepped time. The next `run` is the last one."""
        clock = link.StepClock(cosimulation, self._stream.getsockname()[1], timeout_s=timeout_s)
        self._driver = link.StepDriver(self._stream, self.session, clock, self._open, report, visits)
        return clock

    def close(self):
        """Close the connection."""
        if self._world:
            self._world.close()
        if self._stream:
            self._stream.close()
        self._stream = self._driver = self._world = None

    def __enter__(self):
        return self if self._stream else self.connect()

    def __exit__(self, *unused):
        self.close()

    def run(self, procedure):
        """Run a procedure of this session (session.py); returns its value."""
        if self._driver is None:
            raise LinkLost("not connected; call connect() or use `with`")
        return self._driver.run(procedure)

    def _ns(self, timeout_s):
        return int((self.timeout_s if timeout_s is None else timeout_s) * 1e9)

    # Commands -----------------------------------------------------------------------------------------------

    def plan(self, *words):
        """The command (command.Command) of these words of `gse`; nothing is sent. Raises UsageError."""
        return commands.plan(_words(words), self.dictionary)

    def do(self, *words, timeout_s=None):
        """Perform a command of `gse`, given as one line or as words. Returns the lines of its answer, each a dict with
        "text"."""
        return self._perform(self.plan(*words), timeout_s)

    # Each call below is one procedure that `run` performs. AsyncSpacecraft therefore has the same calls; there `run`
    # must be awaited.

    def _perform(self, command, timeout_s, result=lambda rows: rows):
        def performing():
            return result((yield from command.procedure(self.session, self._ns(timeout_s))))

        return self.run(performing())

    def _call(self, function, arguments):
        return self.plan("cmd", function, *(f"{name}={_text(value)}" for name, value in arguments.items()))

    def cmd(self, function, *, timeout_s=None, **arguments):
        """Perform SUBSYSTEM.FUNCTION to its completion."""
        return self._perform(self._call(function, arguments), timeout_s, lambda rows: None)

    def send(self, function, **arguments):
        """Send SUBSYSTEM.FUNCTION without waiting. Returns its session.Verification, for which `finish` waits."""
        return self.send_request(self._call(function, arguments).requests[0])

    def send_request(self, request):
        """Send a session.Request without waiting. Returns its session.Verification."""
        def sending():
            verification = self.session.send(request)
            yield from self.session.wait_until(0)  # The driver sends the queued octets.
            return verification

        return self.run(sending())

    def finish(self, verification, timeout_s=None):
        """Wait for the completion of a request, and return its verification. Raises Rejected."""
        return self.run(self.session.finish(verification, self._ns(timeout_s)))

    def tc(self, subsystem, service, subtype, *, timeout_s=None, **fields):
        """Perform any request of the standard, with its fields by name. Returns the fields of its answer; {} if it has
        no answer."""
        entry = self.dictionary.catalogue.find("TC", service, subtype)
        data = self.dictionary.catalogue.encode("TC", service, subtype, fields)
        request = Request(self.dictionary.subsystem(subsystem).apid, service, subtype, data, f"TC[{service},{subtype}] to {subsystem}")
        message = (service, entry["answer"])
        what = f"TM[{service},{entry['answer']}] in answer to {request.text}"

        def answering():
            verification = yield from self.session.finish(self.session.send(request), self._ns(timeout_s))
            if not entry["answer"]:
                return {}

            def answers():  # An answer longer than a packet comes in parts, after the completion of its request.
                return [decoded for packet, decoded in verification.replies if packet.message == message]

            return merged((yield from self.session.wait_for(answers, self._ns(timeout_s), what)))

        return self.run(answering())

    # Parameters ---------------------------------------------------------------------------------------------

    def get(self, parameter, timeout_s=None):
        """Present value of SUBSYSTEM.PARAMETER[.FIELD], as of this call."""
        return self._perform(self.plan("get", parameter), timeout_s, lambda rows: _plain(next(iter(rows[-1]["values"].values()))))

    def set(self, parameter, value, timeout_s=None):
        """Set SUBSYSTEM.PARAMETER[.FIELD]."""
        return self._perform(self.plan("set", parameter, value), timeout_s, lambda rows: None)

    def wait_value(self, parameter, is_wanted=lambda value: True, timeout_s=None):
        """Wait until is_wanted(value) is true for the last value of SUBSYSTEM.PARAMETER[.FIELD] in housekeeping. Returns this value."""
        subsystem_name, _, name = parameter.upper().partition(".")
        subsystem = self.dictionary.subsystem(subsystem_name)
        head, _, field = name.partition(".")
        found = subsystem.parameter(head)
        if found.fields:
            found.field(field)  # Raises DictionaryError if there is no such field.

        def reported():
            last = self._last_value(subsystem, name)
            return [last] if last is not None and is_wanted(last) else None

        def waiting():
            try:
                return (yield from self.session.wait_for(reported, self._ns(timeout_s), f"the wanted value of {subsystem.name}.{name}"))[0]
            except TimedOut as problem:
                last = self._last_value(subsystem, name)
                raise TimedOut(f"{problem}; the last value was {'not reported' if last is None else last}") from problem

        return self.run(waiting())

    # Reports ------------------------------------------------------------------------------------------------

    def _last_value(self, subsystem, name):
        """Value of PARAMETER[.FIELD] in the last housekeeping report that contains it; None if there is none."""
        for packet, configuration in reversed(self.session.housekeeping.values()):
            if packet.apid == subsystem.apid:
                decoded = telemetry.decode(packet, self.dictionary, {packet.apid: configuration})
                leaves = telemetry.leaves(decoded.get("values", {}))
                if name in leaves:
                    return _plain(leaves[name])
        return None

    def wait_for(self, condition, what, timeout_s=None):
        """Wait until condition() is true, and return its value; it is checked whenever telemetry has arrived. TimedOut names `what`."""
        return self.run(self.session.wait_for(condition, self._ns(timeout_s), what))

    def listen(self, seconds):
        """Receive telemetry for this time; math.inf: until Ctrl-C."""

        def waiting():
            end = self.session.now_ns - self.session.slipped_ns + seconds * 1e9
            while self.session.now_ns - self.session.slipped_ns < end:
                yield None if math.isinf(end) else end + self.session.slipped_ns

        return self.run(waiting())

    def state(self, subsystem):
        """Last reported state of a subsystem, None before the first report."""
        return self.session.states.get(self.dictionary.subsystem(subsystem).apid)

    def wait_state(self, subsystem, state, timeout_s=None):
        """Wait until a subsystem has reported a state."""
        return self.run(self.session.wait_state(self.dictionary.subsystem(subsystem).apid, state.upper(), self._ns(timeout_s)))

    def wait_event(self, subsystem, event, timeout_s=None):
        """Wait for the first event of this name since the connection was made that no earlier call has returned.
        Returns its values."""
        source = self.dictionary.subsystem(subsystem)

        def waiting():
            _, decoded = yield from self.session.wait_event(source.apid, source.event(event).name, self._ns(timeout_s))
            return {name: _plain(value) for name, value in decoded["values"].items()}

        return self.run(waiting())

    # The simulated world of a flight in real time ----------------------------------------------------------

    def live(self, *words):
        """Send a line to the live port (docs/live.md). Returns the simulated time [s] at which it acts. Raises
        LiveRefused, LinkLost."""
        self._world = self._world or live.LiveWorld(self.place.run)
        try:
            return self._world.ask(" ".join(map(str, words)))[0]
        except LinkLost:
            self._world.close()
            self._world = None
            raise

    def hand(self, *words):
        """Move the simulated hand: a verb of `hand` in docs/scenarios.md and its words."""
        return self.live("hand", *words)

    def fault(self, *words):
        """Cause a fault: a verb of `fault` in docs/scenarios.md and its words."""
        return self.live("fault", *words)

    def pause(self):
        """Pause simulated time."""
        return self.live("pause")

    def resume(self):
        """Let simulated time continue."""
        return self.live("resume")

    def step(self, seconds):
        """Let this simulated time pass; returns when simulated time stands still again."""
        began = self.live("step", f"{seconds:.4f}")
        self._world.stand_still()
        return began

    def speed(self, factor):
        """Set the pace of simulated time: 0.1 to 100 times the wall clock; 0: as fast as possible."""
        return self.live("speed", factor)
