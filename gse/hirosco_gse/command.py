# SPDX-License-Identifier: Apache-2.0
"""A command of an operator. It is planned from words and performed by a procedure, which sends requests and waits."""

import re
from dataclasses import dataclass

from . import telemetry
from .session import SessionError
from .values import TEXT_MAX, ValueProblem, quoted, shortened

REPLY_NS = 5_000_000_000  # longest wait for a report after the end of the verification of its request, mission time

# Each character matches one alternative only. The search for a missing closing quotation mark therefore takes linear time.
_PIECE = re.compile(r"""([ \t\r\n]+)|'([^']*)'|"([^"\\]*(?:\\.[^"\\]*)*)"|\\(.)|([^ \t\r\n'"\\]+)""", re.DOTALL)
_ESCAPE = re.compile(r"\\.", re.DOTALL)


class UsageError(ValueProblem):
    """Words that are not a command."""


def words_of(line):
    """The same words as shlex.split(line), which is not used because it takes a second for a line of 256 KiB. Here the time grows in
    proportion to the length of the line. Raises ValueError: a quotation or an escape without its end."""
    words, pieces, at = [], [], 0
    for found in _PIECE.finditer(line):
        if found.start() != at:
            break
        at = found.end()
        blank, single, double, escaped, plain = found.groups()
        if blank is None:
            inside = double if double is None else re.sub(r'\\(["\\])', r"\1", double)
            pieces.append(next(part for part in (single, inside, escaped, plain) if part is not None))
        elif pieces:
            words.append("".join(pieces))
            pieces = []
    if at != len(line):
        is_escape = line[at] != "'" and _ESCAPE.sub("", line[at:]).endswith("\\")
        rest = quoted(line[at:])
        raise ValueError(f"No escaped character in {rest}: expected one after the last \\" if is_escape
                         else f"No closing quotation mark in {rest}: close the quotation, or put a \\ before its mark")
    return [*words, "".join(pieces)] if pieces else words


@dataclass(frozen=True)
class Command:
    """A planned command. procedure(session, timeout_ns) is a generator. `requests` are the requests that it sends first. `later` are requests
    that it sends if the answers to the first ones are as expected; they have the content that is known when the command is planned."""

    text: str
    procedure: object
    requests: tuple = ()
    later: tuple = ()

    def __post_init__(self):
        object.__setattr__(self, "text", shortened(self.text, TEXT_MAX))


def replies_of(verification, message):
    """The reports of this message among the replies to a request: (packet, decoded content) of each."""
    return [(packet, decoded) for packet, decoded in verification.replies if packet.message == message]


def line(session, packet, decoded):
    """One line of the answer to a command: the text of a report, and its decoded content."""
    return {"text": telemetry.describe(packet, decoded, session.dictionary), **decoded}


def simple(*requests):
    """Command that performs requests one after the other."""

    def procedure(session, timeout_ns):
        answer = []
        for request in requests:
            verification = yield from session.execute(request, timeout_ns)
            answer.append({"text": f"{request.text}: completed"})
            answer += [line(session, *reply) for reply in verification.replies]
        return answer

    return Command("; ".join(request.text for request in requests), procedure, requests)


def answers(session, request, message, timeout_ns):
    """Procedure: perform a request and return its reports of the given message."""
    verification = yield from session.execute(request, timeout_ns)
    what = f"{request.text}: TM[{message[0]},{message[1]}]"
    return (yield from session.wait_for(lambda: replies_of(verification, message), REPLY_NS, what))


def rows_of(session, request, message, timeout_ns):
    """Procedure: perform a request and return the rows of its report."""
    report = (yield from answers(session, request, message, timeout_ns))[-1][1]
    if "error" in report:
        raise SessionError(report["error"])
    return report["rows"]


def asking(request, message):
    """Command that performs a request and returns its reports of the given message."""

    def procedure(session, timeout_ns):
        replies = yield from answers(session, request, message, timeout_ns)
        return [line(session, *reply) for reply in replies]

    return Command(request.text, procedure, (request,))


def need(words, count, usage):
    if len(words) != count:
        raise UsageError(f"usage: {usage}")
    return words
