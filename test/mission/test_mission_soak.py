# SPDX-License-Identifier: Apache-2.0
"""Hours of simulated time with random traffic (soak.py): no resource grows, no clock drifts and no
report is missing. Further tests show that the checks of soak.py detect each of these."""

import os

import pytest

import soak

HOURS = float(os.environ.get("SOAK_HOURS", "2"))
SEED = int(os.environ.get("SOAK_SEED", "1"))
RESOURCES_OF_A_PROCESS = {"VmRSS": 10_000, "VmData": 5_000, "RssAnon": 4_000, "descriptors": 39, "sockets": 12}


def test_nothing_grows_drifts_or_stalls_in_ten_minutes_of_random_traffic(directory):
    flight, _, judge, problems = soak.fly(directory, SEED, 1 / 6, sample_s=0.1)
    assert not problems, problems
    assert judge.lines > 1000 and flight.facts["reproducible"]


@pytest.mark.long
@pytest.mark.timeout(24 * soak.HOUR_S)
@pytest.mark.parametrize("form", ["image", "processes"])
def test_nothing_grows_drifts_or_stalls_in_hours_of_random_traffic(directory, form):
    """SOAK_HOURS and SOAK_SEED set the duration and the seed."""
    _, _, _, problems = soak.fly(directory, SEED, HOURS if form == "image" else min(HOURS, 1.0), form)
    assert not problems, problems


def test_a_seed_gives_one_scenario():
    assert soak.scenario(7, 0.5) == soak.scenario(7, 0.5) != soak.scenario(8, 0.5)


def _samples(**grows):
    """Forty samples in which the named resources of the image grow with time."""
    return [
        {
            "simulated_s": i,
            "processes": {"image": {word: value + grows.get(word, 0) * i for word, value in RESOURCES_OF_A_PROCESS.items()}},
            "names": 8 + grows.get("names", 0) * i,
        }
        for i in range(40)
    ]


@pytest.mark.parametrize("word", ["VmRSS", "VmData", "RssAnon", "descriptors", "sockets", "names"])
def test_growth_is_detected(word):
    assert not list(soak.judge_samples(_samples()))
    assert len(list(soak.judge_samples(_samples(**{word: 100})))) == 1


def test_a_missing_process_is_detected():
    assert list(soak.judge_samples(_samples(), "processes"))
    assert list(soak.judge_samples(_samples()[:4]))


def _tm(time_ns, count, message, data, destination=0):
    return time_ns, "TM", bytes((8, 1)) + (0xC000 | count).to_bytes(2, "big") + bytes((0, 0, 0x20, *message, 0, 0)) + destination.to_bytes(
        2, "big"
    ) + bytes(8) + data + bytes(2)


def _status_report(second, count, late_ns=0):
    """A status report TM[129,5]: OPERATIONAL."""
    return _tm(second * soak.NS_PER_S + late_ns, count, (129, 5), bytes((5, 0)))


# TC[17,1] of user 1 to APID 1 with sequence count 7, and its TM[1,7].
REQUEST = (500_000, "TC", bytes((0x18, 1, 0xC0, 7, 0, 6, 0x2F, 17, 1, 0, 1, 0, 0)))
COMPLETION = _tm(1_000_000, 1, (1, 7), REQUEST[2][:4], 1)


def _judged(*records):
    judge = soak.Judge()
    for record in records:
        judge.take(*record)
    return judge.end()


def test_correct_packets_violate_no_rule():
    assert not _judged(_status_report(0, 0), REQUEST, COMPLETION, *(_status_report(second, second + 1) for second in range(1, 20)))


@pytest.mark.parametrize(
    "records",
    [
        [REQUEST],
        [REQUEST, COMPLETION, _tm(2_000_000, 2, (1, 8), REQUEST[2][:4] + bytes(8), 1)],
        [COMPLETION],
        [_status_report(1, 1), _status_report(2, 3)],
        [_status_report(1, 1), _status_report(4, 2)],
        [_status_report(second, second, second * 50_000_000) for second in range(20)],
    ],
    ids=["not completed", "completed twice", "without a request", "a sequence count is missing", "a report is missing", "drift"],
)
def test_wrong_packets_are_detected(records):
    assert len(_judged(*records)) >= 1
