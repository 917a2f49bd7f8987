# SPDX-License-Identifier: Apache-2.0
"""Faults drawn from seeds, one or two in a flight: every flight keeps the invariants of campaign_rules.py."""

import os

import pytest

import campaign
import campaign_faults as faults

BATCHES = 8
LONG = {1: 250, 2: 125}  # Number of faults in a flight -> flights in a batch of the whole campaign (LONG=1).
SHORT = 1  # Flights with two faults without LONG=1.
SLOW = ("connection_cut",)  # Kinds of faults for which a flight waits in wall-clock time.


@pytest.fixture(scope="module")
def ground(session_directory):
    """Data that all flights of the campaign share."""
    return campaign.Ground(session_directory / f"campaign-{os.getpid()}")


def _drawn(seeds, count):
    """The flights of seeds; flights on two nodes only if namespaces can be made."""
    drawn = (faults.draw(seed, count) for seed in seeds)
    return [flight for flight in drawn if flight.form != "nodes" or os.geteuid() == 0]


def _judge(ground, directory, flights, in_both=None):
    bad = []
    for drawn in flights:
        found = campaign.judge(ground, directory / f"{drawn.seed}-{drawn.count}", drawn, in_both)
        bad += [f"{campaign.command(drawn)}: {what}" for what in found]
    assert not bad, "\n".join(bad)


def test_each_kind_of_fault_keeps_the_invariants(ground, directory):
    """Fly the first seed of each kind."""
    drawn = _drawn(range(200), 1)
    kinds = {flight.kinds[0]: flight for flight in reversed(drawn) if flight.kinds[0] not in SLOW}
    assert len(kinds) >= len(faults.KINDS) - len(SLOW) - (os.geteuid() != 0)
    _judge(ground, directory, kinds.values(), in_both=False)


def test_two_faults_keep_the_invariants(ground, directory):
    _judge(ground, directory, _drawn(range(SHORT), 2), in_both=False)


def test_processes_give_the_octets_of_the_image_with_faults(ground, directory):
    """The same seed is flown in both forms."""
    _judge(ground, directory, [faults.draw(seed, 2) for seed in (8,)], in_both=True)


def test_every_kind_of_fault_is_drawn():
    """The whole campaign has every kind, alone and with a second fault."""
    for count, batch in LONG.items():
        seeds = range(1000, 1000 + BATCHES * batch)
        assert {kind for seed in seeds for kind in faults.draw(seed, count).kinds} == {kind.__name__[1:] for kind in faults.KINDS}


@pytest.mark.long
@pytest.mark.parametrize("count", LONG)
@pytest.mark.parametrize("batch", range(BATCHES))
def test_the_whole_campaign_keeps_the_invariants(ground, directory, batch, count):
    _judge(ground, directory, _drawn(range(1000 + batch * LONG[count], 1000 + (batch + 1) * LONG[count]), count))
