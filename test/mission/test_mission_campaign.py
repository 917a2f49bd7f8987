# SPDX-License-Identifier: Apache-2.0
"""Faults drawn from seeds, one or two in a flight: what holds of every flight (campaign.py) holds."""

import shutil

import pytest

import campaign

BATCHES = 8
SHORT = 3  # flights in a batch
LONG = {1: 250, 2: 125}


def _judge(folder, seeds, count, form="image"):
    bad = []
    for seed in seeds:
        flight, found = campaign.fly(folder, seed, count, form)
        bad += [f"test/mission/campaign.py {seed} --faults {count} --form {form}: {what}" for what in found]
        if not found:
            shutil.rmtree(flight.folder)
    assert not bad, "\n".join(bad)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("batch", range(2))
def test_flights_with_faults_keep_the_invariants(folder, batch, count):
    _judge(folder, range(batch * SHORT, (batch + 1) * SHORT), count)


@pytest.mark.parametrize("count", [1, 2])
def test_processes_give_the_octets_of_the_image_with_faults(folder, count):
    """The same seed in both forms, and once more."""
    for seed in range(2):
        flights = [campaign.fly(folder / str(number), seed, count, form) for number, form in enumerate(("image", "processes", "image"))]
        assert not [found for _, found in flights if found]
        first = flights[0][0].octets("packets.log")
        assert all(flight.octets("packets.log") == first for flight, _ in flights[1:]), f"seed {seed}, {count} faults"


@pytest.mark.long
@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("batch", range(BATCHES))
def test_the_whole_campaign(folder, batch, count):
    _judge(folder, range(1000 + batch * LONG[count], 1000 + (batch + 1) * LONG[count]), count)
