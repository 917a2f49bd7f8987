# SPDX-License-Identifier: Apache-2.0
"""Requests of a packet log that a station sent by itself."""

import pytest
from hirosco_gse import commands, packets
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.station.own_requests import is_own

CLI, WEB, WEB_2 = 1, 3, 4
OWN = ["status", "hk once SUPERVISOR 1", "tc MANIPULATOR 3,33 n=[4711]", "hk enable MANIPULATOR 4720", "hk disable MANIPULATOR 4720"]
OF_OPERATORS = ["state MANIPULATOR OPERATIONAL", "hk enable MANIPULATOR 4711", "hk enable SUPERVISOR 4720", "hk interval MANIPULATOR 4720 50", "hk create MANIPULATOR 77 100 DES_POSITION", "ping MANIPULATOR", "cmd MANIPULATOR.TARE"]


@pytest.fixture(scope="module")
def dictionary(dictionary_path):
    return Dictionary.load(dictionary_path)


def sent(text, user, dictionary):
    """Telecommands of a command of this user, as a packet log has them."""
    return [packets.parse(packets.build_tc(request.apid, 0, request.service, request.subtype, request.data, user))
            for request in commands.plan(text.split(), dictionary).requests]


@pytest.mark.parametrize("text", OWN)
def test_a_request_of_a_station_is_recognized(text, dictionary):
    for user in (WEB, WEB_2):
        found = sent(text, user, dictionary)
        assert found and all(is_own(packet, dictionary) for packet in found)
    assert not any(is_own(packet, dictionary) for packet in sent(text, CLI, dictionary))


def test_the_list_of_links_is_recognized(dictionary):
    packet = packets.parse(packets.build_tc(dictionary.subsystem("SUPERVISOR").apid, 0, 130, 8, b"\0", WEB))
    assert is_own(packet, dictionary)


@pytest.mark.parametrize("text", OF_OPERATORS)
def test_a_command_of_an_operator_is_no_request_of_a_station(text, dictionary):
    found = sent(text, WEB, dictionary)
    assert found and not any(is_own(packet, dictionary) for packet in found)
