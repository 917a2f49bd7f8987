# SPDX-License-Identifier: Apache-2.0
"""The reports that belong to each telecommand."""

import struct

import pytest
from hirosco_gse import commands, packets, telemetry
from hirosco_gse.station.led_to import ALL_USERS, LISTED_MAX, UNHEARD_S, LedTo, Reports
from tm_packets import build_tm
from visiting import JOYSTICK, MANIPULATOR, TELEPRESENCE, status, visit

WEB, OTHER = 3, 4
TRANSITION = struct.pack(">BBBHB", 3, 4, 0, TELEPRESENCE, 0)  # PRE_OPERATIONAL to SAFE_OPERATIONAL, by a request.


class Flight:
    """Telecommands of a user, and the reports that follow."""

    def __init__(self, dictionary):
        self.dictionary, self.led_to, self._sequence = dictionary, LedTo(dictionary), 0

    def send(self, text, user=WEB):
        """The packet of a command, and what it leads to."""
        (request,) = commands.plan(text.split(), self.dictionary).requests
        self._sequence += 1
        packet = packets.parse(packets.build_tc(request.apid, self._sequence, request.service, request.subtype, request.data, user))
        self.led_to.sent(packet, packet.request_id, user, reports := Reports())
        return packet, reports

    def report(self, service, subtype, data=b"", apid=MANIPULATOR, user=ALL_USERS, seconds=2.0):
        packet = packets.parse(build_tm(apid, 0, service, subtype, data, user))
        self.led_to.take(seconds, packet, telemetry.decode(packet, self.dictionary))

    def verify(self, packet, *subtypes):
        for subtype in subtypes:
            self.report(1, subtype, packet.request_id, packet.apid, packet.user)


@pytest.fixture
def flight(dictionary):
    return Flight(dictionary)


def titles(reports):
    return [title for _, title, _ in reports.message().get("led_to", {"rows": []})["rows"]]


def test_a_command_has_its_verification_its_answer_and_the_events_until_its_end(flight):
    event = flight.dictionary.subsystem("MANIPULATOR").event("TORQUE_LIMIT")
    noted = struct.pack(">H", event.id) + bytes(40)
    flight.report(5, 3, noted)
    ping, reports = flight.send("ping MANIPULATOR")
    flight.verify(ping, 1, 3)
    flight.report(5, 3, noted)
    flight.report(5, 3, noted, JOYSTICK)
    flight.report(17, 2, user=WEB)
    flight.report(17, 2, user=OTHER)
    flight.verify(ping, 7)
    flight.report(17, 2, user=WEB)
    flight.report(5, 3, noted)
    assert titles(reports) == ["TM[1,1]", "TM[1,3]", "TM[5,3]", "TM[17,2]", "TM[1,7]"]


def test_a_transition_belongs_to_its_request_and_a_periodic_status_to_none(flight):
    wanted, reports = flight.send("state MANIPULATOR SAFE_OPERATIONAL")
    flight.report(129, 2, TRANSITION)
    flight.report(129, 5, status(4, TELEPRESENCE))
    flight.verify(wanted, 7)
    assert titles(reports) == ["TM[129,2]", "TM[1,7]"]
    assert reports.rows[0][2].startswith("MANIPULATOR: ")


def test_of_equal_requests_the_first_gets_the_answer(flight):
    first, of_first = flight.send("ping MANIPULATOR")
    second, of_second = flight.send("ping MANIPULATOR")
    flight.report(17, 2, user=WEB)
    flight.verify(first, 7)
    flight.report(17, 2, user=WEB)
    flight.verify(second, 7)
    assert titles(of_first) == titles(of_second) == ["TM[17,2]", "TM[1,7]"]


def test_an_answer_belongs_to_the_request_that_the_catalogue_names(flight):
    _, of_other = flight.send("hk enable MANIPULATOR 4711")
    _, of_query = flight.send("tc MANIPULATOR 3,33 n=[4711]")
    flight.report(3, 35, bytes(2), user=WEB)
    flight.report(3, 25, struct.pack(">H", 4711))
    assert (titles(of_other), titles(of_query)) == ([], ["TM[3,35]"])


def test_reports_beyond_the_listed_ones_are_counted_and_none_follows_a_lost_link(flight):
    wanted, reports = flight.send("state MANIPULATOR SAFE_OPERATIONAL")
    for _ in range(LISTED_MAX + 2):
        flight.report(129, 2, TRANSITION)
    flight.led_to.end()
    flight.verify(wanted, 7)
    found = reports.message()["led_to"]
    assert found["count"] == LISTED_MAX + 2 and len(found["rows"]) == LISTED_MAX


def test_a_telecommand_that_is_never_verified_gets_no_reports_for_ever(flight):
    """One whose verification has begun may take longer."""
    _, of_lost = flight.send("state MANIPULATOR SAFE_OPERATIONAL")
    begun, of_begun = flight.send("state MANIPULATOR SAFE_OPERATIONAL")
    flight.verify(begun, 1)
    for seconds in (2.0 + UNHEARD_S, 3.0 + UNHEARD_S):
        flight.report(129, 2, TRANSITION, seconds=seconds)
    assert (len(titles(of_begun)), len(titles(of_lost))) == (2, 1)  # The older telecommand gets the report until it is given up.


def test_a_page_gets_the_reports_of_a_command(place):
    async def story(page, _):
        await page.ask(do="command", text="ping MANIPULATOR")
        return await page.until(lambda message: message["kind"] == "command" and message["over"])

    found = visit(place, story)["led_to"]
    assert found["count"] == 4 and [title for _, title, _ in found["rows"]] == ["TM[1,1]", "TM[1,3]", "TM[17,2]", "TM[1,7]"]
    assert found["rows"][2][2] == "MANIPULATOR: alive"


def test_a_page_that_is_opened_later_gets_the_states_so_far(place):
    """The time line of the page begins with the flight; a state that is reported again is no change."""

    async def story(_, station):
        hub = station.hub
        for hub.seconds, state in ((4.0, "PRE_OPERATIONAL"), (5.0, "PRE_OPERATIONAL"), (7.5, "SAFE_OPERATIONAL")):
            hub._publish_state("MANIPULATOR", {"state": state, "phase": 0, "configuration": None}, hub.seconds)
        return hub.snapshot()

    messages = visit(place, story)
    kinds = [message["kind"] for message in messages]
    lanes = messages[kinds.index("lanes")]["lanes"]["MANIPULATOR"]
    assert lanes[-2:] == [[4.0, "PRE_OPERATIONAL"], [7.5, "SAFE_OPERATIONAL"]]
    assert kinds.index("lanes") < kinds.index("state")  # Otherwise the page would begin a lane with the present state.
