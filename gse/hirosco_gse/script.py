# SPDX-License-Identifier: Apache-2.0
"""The operator of a scenario: the lines `<time s> operator <verb> ...` of a scenario file.

Each line is performed no earlier than its time, after the lines before it, and waits until its requests are verified.
With `nowait` it does not wait. Besides the commands of commands.py there are

    nowait COMMAND ...                     send and continue; a failure is reported at the end of the script. A command that has to
                                           wait before it sends, such as `at +60`, is refused
    try COMMAND ...                        perform the command; the script continues even if the command is refused, fails or has no
                                           answer within 2 s, or if the link is lost. The log contains the outcome. The outcome of
                                           `try nowait` is not checked
    expect-refusal CODE COMMAND ...        the command must be refused with this failure code: a number, or a name that the
                                           descriptor of the addressee has
    wait-state SUBSYSTEM STATE SECONDS     wait until the subsystem has reported the state
    wait-event SUBSYSTEM EVENT SECONDS     wait until the event is received; an event that no earlier line has awaited counts, too
    expect-event SUBSYSTEM EVENT           the event must have been received, and no earlier line has awaited it
    expect-state SUBSYSTEM STATE           the subsystem's last report must be this state
    end                                    the operator leaves; later lines are not performed
"""

import pathlib
import re
import shlex
from dataclasses import dataclass

from . import commands, figure_bounds, visits
from .commands import Command, UsageError
from .dictionary import STATES, DictionaryError
from .session import LinkLost, Rejected, RequestLost, SessionError
from .values import quoted

ACTORS = ("operator", "hand", "fault", "ground")
CODE = re.compile(r"0[xX][0-9A-Fa-f]+|[0-9]+|[A-Z][A-Z0-9_]*")  # Failure code, or its name.
TRY_NS = 2_000_000_000  # Longest wait for an optional answer.


class ScriptError(ValueError):
    """A line that is not a step, as file:line: reason; or a file that cannot be read, as file: reason."""


class ScriptFailure(Exception):
    """A step with an unexpected result, as file:line: expected result, actual result."""


@dataclass(frozen=True)
class Step:
    """One line of the operator."""

    path: str
    line: int
    time_ns: int
    verb: str
    words: tuple
    command: Command = None

    @property
    def place(self):
        """file:line."""
        return f"{self.path}:{self.line}"

    @property
    def text(self):
        """The line without time and actor."""
        return " ".join((self.verb, *self.words))


def _time_ns(word, place):
    try:
        seconds = float(word)
        if not 0 <= seconds < 1e6:
            raise ValueError
    except ValueError as error:
        raise ScriptError(f"{place}: found {quoted(word)}, expected a time in seconds") from error
    return round(seconds * 1e9)


def _failure_code(step, command, dictionary):
    """Number of the failure code that a step expects."""
    word = step.words[0]
    addressees = [dictionary.subsystem_of_apid(request.apid) for request in command.requests]
    own = {name: code for one in addressees if one for code, (name, _) in one.failures.items()}
    if word in own:
        return own[word]
    try:
        return int(word, 0)
    except ValueError as error:
        known = f", or of: {', '.join(own)}" if own else ""
        raise ScriptError(f"{step.place}: found {quoted(word)}, expected a failure code such as 0x0111{known}") from error


def _check_state(word, place):
    if word not in STATES:
        raise ScriptError(f"{place}: no state {quoted(word)}; there are: {', '.join(STATES)}")


def _checked(step, dictionary):
    """The step with its command planned; the whole script is checked before anything is sent."""
    verb, words = step.verb, step.words

    def need(count, usage):
        if len(words) != count:
            raise ScriptError(f"{step.place}: usage: {usage}")

    command = None
    if verb in ("wait-state", "expect-state"):
        need(3 if verb == "wait-state" else 2, f"{verb} SUBSYSTEM STATE" + " SECONDS" * (verb == "wait-state"))
        dictionary.subsystem(words[0])
        _check_state(words[1], step.place)
    elif verb in ("wait-event", "expect-event"):
        need(3 if verb == "wait-event" else 2, f"{verb} SUBSYSTEM EVENT" + " SECONDS" * (verb == "wait-event"))
        dictionary.subsystem(words[0]).event(words[1])
    elif verb == "expect-refusal":
        if len(words) < 2:
            raise ScriptError(f"{step.place}: usage: expect-refusal CODE COMMAND ...")
        if not CODE.fullmatch(words[0]):
            raise ScriptError(f"{step.place}: found {quoted(words[0])}, expected a failure code such as 0x0111")
        command = commands.plan(words[1:], dictionary)
        _failure_code(step, command, dictionary)
    elif verb == "try":
        if not words:
            raise ScriptError(f"{step.place}: usage: try COMMAND ...")
        command = commands.plan(words[1:] if words[0] == "nowait" else words, dictionary)
    elif verb == "nowait":
        command = commands.plan(words, dictionary)
        if not command.requests:
            raise ScriptError(f"{step.place}: {quoted(' '.join(words))} has to wait for answers, expected it without 'nowait'")
    elif verb == "end":
        need(0, "end")
    else:
        command = commands.plan((verb, *words), dictionary)
    if verb.startswith("wait-"):
        _time_ns(words[2], step.place)
    return Step(step.path, step.line, step.time_ns, verb, words, command)


def _visit(place, time_ns, words, before):
    if before and time_ns < before[-1].time_ns:
        raise ScriptError(f"{place}: time {time_ns / 1e9:g} is before the line of `ground` above, expected at least {before[-1].time_ns / 1e9:g}")
    try:
        return visits.parse(place, time_ns, words)
    except visits.VisitError as error:
        raise ScriptError(str(error)) from error


class Script:
    """The operator's part of a scenario."""

    def __init__(self, steps, visits=()):
        """visits: the lines of the actor `ground` (visits.py)."""
        self.steps, self.visits = steps, visits
        self._open = []

    @classmethod
    def load(cls, path, dictionary):
        """Script of a file, whose file of bounds is checked as well. Raises ScriptError."""
        try:
            text = pathlib.Path(path).read_text(encoding="utf-8")
            figure_bounds.read(pathlib.Path(path).with_suffix(figure_bounds.ENDING))
        except figure_bounds.BoundsError as error:
            raise ScriptError(str(error)) from error
        except OSError as error:
            raise ScriptError(f"{error.filename or path}: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise ScriptError(f"{path}: found octet 0x{error.object[error.start]:02x} at offset {error.start}, expected text in UTF-8") from error
        return cls.parse(text, str(path), dictionary)

    @classmethod
    def parse(cls, text, path, dictionary):
        steps, visits_of_ground, last = [], [], 0
        for number, line in enumerate(text.splitlines(), 1):
            place = f"{path}:{number}"
            try:
                words = shlex.split(line, comments=True)
            except ValueError as error:
                raise ScriptError(f"{place}: {error} in {quoted(line)}: close the quotation, or put a \\ before its mark") from error
            if not words:
                continue
            time_ns = _time_ns(words[0], place)
            if len(words) < 3 or words[1] not in ACTORS:
                found = words[1] if len(words) > 1 else "nothing"
                raise ScriptError(f"{place}: found {quoted(found)}, expected <time> {'|'.join(ACTORS)} <verb> ...")
            if words[1] == "ground":
                visits_of_ground.append(_visit(place, time_ns, words[2:], visits_of_ground))
            if words[1] != "operator":
                continue
            if time_ns < last:
                raise ScriptError(f"{place}: time {words[0]} is before the operator's line above, expected at least {last / 1e9:g}")
            last = time_ns
            step = Step(path, number, time_ns, words[2], tuple(words[3:]))
            try:
                steps.append(_checked(step, dictionary))
            except (UsageError, DictionaryError) as error:
                raise ScriptError(f"{place}: {error}") from error
        return cls(steps, visits_of_ground)

    def procedure(self, session, timeout_ns, report=lambda entry: None):
        """Procedure: all steps; report(entry) is called after each. Raises ScriptFailure. Without any step it lasts until the last line of `ground`,
        because a flight ends when its operator leaves. `gse record` writes such a scenario of a flight that had no operator."""
        if not self.steps and self.visits:
            yield from session.wait_until(self.visits[-1].time_ns)
        is_going_down = False
        for step in self.steps:
            start = session.now_ns
            try:
                yield from session.wait_until(step.time_ns)
                start = session.now_ns
                is_going_down = is_going_down or step.verb == "shutdown"
                outcome = yield from self._run(step, session, timeout_ns)
            except (SessionError, DictionaryError) as problem:
                if is_going_down and isinstance(problem, (LinkLost, RequestLost)):
                    report(_entry(step, start, session, "the ground port went down with the mission"))
                    return
                if isinstance(problem, LinkLost):
                    raise
                report(_entry(step, start, session, f"FAILED: {problem}"))
                raise ScriptFailure(f"{step.place}: {problem}") from problem
            report(_entry(step, start, session, outcome))
            if step.verb == "end":
                break
        self._check_open(session)

    def _check_open(self, session):
        for step, verification in self._open:
            if verification.lost_ns is not None:
                raise ScriptFailure(f"{step.place}: expected success of {verification.request.text}, the link was lost before its end")
            if verification.failure is not None:
                words = verification.failure.words(session.dictionary)
                raise ScriptFailure(f"{step.place}: expected success of {verification.request.text}, came: {words}")

    def _run(self, step, session, timeout_ns):
        """Procedure: one step; returns its outcome in words."""
        if step.verb == "end":
            return "ok"
        if step.verb == "nowait":
            self._open += [(step, session.send(request)) for request in step.command.requests]
            return "sent"
        if step.verb == "try":
            return (yield from self._tried(step, session, min(timeout_ns, TRY_NS)))
        if step.verb == "expect-refusal":
            return (yield from self._refused(step, session, timeout_ns))
        if step.verb in ("wait-state", "expect-state"):
            apid = session.dictionary.subsystem(step.words[0]).apid
            wait = _time_ns(step.words[2], step.place) if step.verb == "wait-state" else 0
            yield from session.wait_state(apid, step.words[1], wait)
            return "ok"
        if step.verb in ("wait-event", "expect-event"):
            wait = _time_ns(step.words[2], step.place) if step.verb == "wait-event" else 0
            return (yield from self._event(step, session, wait))
        answer = yield from step.command.procedure(session, timeout_ns)
        return "\n".join(line["text"] for line in answer) if answer else "ok"

    def _tried(self, step, session, timeout_ns):
        if step.words[0] == "nowait":
            for request in step.command.requests:
                session.send(request)
            return "sent"
        try:
            answer = yield from step.command.procedure(session, timeout_ns)
        except LinkLost:
            raise
        except RequestLost as problem:
            return f"no answer: {problem}"
        except SessionError as problem:
            return f"not carried out: {problem}"
        return "\n".join(line["text"] for line in answer) if answer else "ok"

    def _refused(self, step, session, timeout_ns):
        expected = _failure_code(step, step.command, session.dictionary)
        try:
            yield from step.command.procedure(session, timeout_ns)
        except Rejected as rejected:
            if rejected.failure.code != expected:
                raise SessionError(f"expected refusal 0x{expected:04X}, came: {rejected}") from rejected
            return f"refused as expected: {rejected.failure.words(session.dictionary)}"
        raise SessionError(f"expected refusal 0x{expected:04X} of '{step.command.text}', but it was carried out")

    def _event(self, step, session, wait_ns):
        subsystem = session.dictionary.subsystem(step.words[0])
        event = subsystem.event(step.words[1])
        _, decoded = yield from session.wait_event(subsystem.apid, event.name, wait_ns)
        return f"{decoded['severity']} {event.name}"


def _entry(step, start_ns, session, outcome):
    """Entry of the operator's log about a line of the scenario, with the APID and sequence count of each packet that was queued for it."""
    end_ns, asked = session.now_ns, [list(key) for key in session.asked]
    session.asked.clear()
    lines = outcome.split("\n")  # If there are several, each has a separate line after that of the step.
    result = f" {outcome}" if len(lines) == 1 else "".join(f"\n    {line}" for line in lines)
    text = f"[{end_ns / 1e9:9.4f} s] {step.text}:{result}"
    return {
        "text": text,
        "time": start_ns / 1e9,
        "end": end_ns / 1e9,
        "line": step.line,
        "verb": step.verb,
        "words": list(step.words),
        "outcome": outcome,
        "asked": asked,
    }


def link_entry(session, what):
    """Entry of the operator's log about the connection, without a line of the scenario."""
    now = session.now_ns / 1e9
    return {"text": f"[{now:9.4f} s] {what}", "time": now, "end": now, "line": 0, "verb": "link", "words": [], "outcome": what}
