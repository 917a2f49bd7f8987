# SPDX-License-Identifier: Apache-2.0
"""Services 1, 3, 5, 17 and 20 in flight."""

# Failure codes of ST[01].
SUBTYPE = 0x0106
PERMISSION = 0x0110
UNKNOWN_ID = 0x0201


def test_alive_report_answers_a_connection_test(station):
    for subsystem in ("SUPERVISOR", "MANIPULATOR", "JOYSTICK"):
        assert station.ask(subsystem, 17, 1)["kind"] == "alive"


def test_unknown_service_and_subtype_are_reported(station):
    outcome = station.settle(station.send_data(16, 99, 1, b""))
    assert outcome.failure.code == PERMISSION, "it was not refused by the permission"
    outcome = station.settle(station.send_data(16, 3, 99, b""))
    assert (outcome.failure.code, outcome.failure.detail) == (SUBTYPE, 3 << 8 | 99)


def test_a_connection_test_on_board_names_the_application(station):
    for subsystem, apid in (("SUPERVISOR", 16), ("SUPERVISOR", 1), ("MANIPULATOR", 16), ("MANIPULATOR", 1)):
        assert station.ask(subsystem, 17, 3, apid=apid)["apid"] == apid
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 17, 3, apid=99)
    station.refuse(UNKNOWN_ID, "MANIPULATOR", 17, 3, apid=17)
