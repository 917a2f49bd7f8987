# SPDX-License-Identifier: Apache-2.0
"""Malformed requests, made from those of the catalogue: truncated at every length, longer by one octet, or with
changed counts and lengths inside. Every addressee must reject at acceptance each request that the ground's
reader finds malformed."""

import random

from hirosco_gse.messages import MessageProblem
from hirosco_gse.packets import Packet
from message_values import Values

SEEDS = 3
MUTATIONS = 24  # Changes of single octets, for each message.
TOGETHER = 32  # Number of requests in progress.
DATA, PERMISSION, SERVICE, SUBTYPE, QUEUE_FULL = 0x0108, 0x0110, 0x0105, 0x0106, 0x0109
OUT_OF_RANGE, UNKNOWN_ID = 0x0203, 0x0201
# The length of the data of these requests depends on definitions on board: a malformed one is refused at
# acceptance or at its start.
DELIMITED_ON_BOARD = {(8, 1), (20, 3)}


def _is_well_formed(catalogue, entry, octets):
    try:
        catalogue.decode(Packet("TC", 1, 0, entry["service"], entry["subtype"], 1, octets, b""))
        return True
    except (MessageProblem, ValueError):
        return False


def _malformed(catalogue, entry):
    """Application data that the ground's reader refuses."""
    found = set()
    for seed in range(SEEDS):
        whole = catalogue.encode("TC", entry["service"], entry["subtype"], Values(catalogue, seed).group(entry, entry["fields"]))
        found |= {whole[:size] for size in range(len(whole))} | {whole + b"\0"}
        rng = random.Random(seed)
        for _ in range(MUTATIONS if whole else 0):
            place = rng.randrange(len(whole))
            found.add(whole[:place] + bytes([rng.choice((0, 1, 2, 127, 255, rng.randrange(256)))]) + whole[place + 1 :])
    return sorted(octets for octets in found if not _is_well_formed(catalogue, entry, octets))


def _judge(station, entry, octets, verification):
    """None if the request was refused as malformed; False if the application does not offer or permit the
    message; otherwise a description."""
    outcome = station.settle(verification)
    codes = {failure.code for failure in outcome.failures}
    if codes & {SERVICE, SUBTYPE, PERMISSION}:
        return False
    message = entry["service"], entry["subtype"]
    is_begun = bool({3, 7, 8} & set(outcome.stages))
    if DATA in codes or (codes & {OUT_OF_RANGE, UNKNOWN_ID} and not is_begun) or (message in DELIMITED_ON_BOARD and 7 not in outcome.stages):
        station.notes.hostile[message] += 1
        return None
    return f"TC[{message[0]},{message[1]}] {octets.hex()}: stages {outcome.stages}, codes {sorted(map(hex, codes))}"


def _send(station, batch):
    """Results of requests that are sent together; requests that find a full inbox are sent again one by
    one."""
    sent = [(apid, entry, octets, station.send_data(apid, entry["service"], entry["subtype"], octets)) for apid, entry, octets in batch]
    for apid, entry, octets, verification in sent:
        station.settle(verification)
        while verification.failure is not None and verification.failure.code == QUEUE_FULL:
            verification = station.send_data(apid, entry["service"], entry["subtype"], octets)
            station.settle(verification)
        yield _judge(station, entry, octets, verification)


def test_nothing_malformed_is_accepted(station):
    hostile = [
        (station.dictionary.subsystem(name).apid, entry, octets)
        for name in ("SUPERVISOR", "MANIPULATOR")
        for entry in station.catalogue.all("TC")
        for octets in _malformed(station.catalogue, entry)
    ]
    found = []
    for start in range(0, len(hostile), TOGETHER):
        found += _send(station, hostile[start : start + TOGETHER])
    wrong = [words for words in found if words]
    print(f"{found.count(None)} malformed requests refused, {len(wrong)} not, {found.count(False)} not offered or not permitted there")
    assert not wrong, "\n".join(wrong[:40])


def test_everything_received_decodes(station):
    assert not station.undecoded, station.undecoded[:10]
    assert not station.session.malformed
