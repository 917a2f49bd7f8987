# SPDX-License-Identifier: Apache-2.0
"""Refusals and messages repeat the text of a user only up to a bound."""

import random
import re
import shlex

import pytest
from hirosco_gse import commands, usage, values
from hirosco_gse.cli import main
from hirosco_gse.command import Command, UsageError, words_of
from hirosco_gse.messages import MessageProblem
from hirosco_gse.session import Request
from hirosco_gse.station import __main__ as station_main
from hirosco_gse.station.forms import Forms

LONG = 10_000 * "x"
REFUSAL_MAX = 4000  # The text of the user, and the names that can be given instead.
SAMPLES = {
    "SUBSYSTEM": "MANIPULATOR", "SUBSYSTEM.FUNCTION": "MANIPULATOR.TARE", "SUBSYSTEM.PARAMETER[.FIELD]": "MANIPULATOR.TORQUE_LIMIT", "EVENT": "TORQUE_LIMIT",
    "PARAMETER": "LINK_AGE", "SERVICE,SUBTYPE": "11,4", "COMMAND": "ping SUPERVISOR", "PATH": "/a/b",
}


def lines():
    """Each form of each command, with one word of a user after the other replaced by LONG, alone and as NAME=VALUE."""
    for verb in commands.VERBS:
        for form in usage.forms(verb):
            words = [SAMPLES.get(word, "1") if re.search("[A-Z]", word) else word.split("|")[0] for word in form if word != "..."]
            for index, word in enumerate(form[: len(words)]):
                if index and re.search("[A-Z]|[|]", word):
                    for long in (LONG, f"n={LONG}", f"{LONG}=1", f"UINT8:{LONG}", f"{words[index]}.{LONG}", f"/{LONG}", f'n=["{LONG}"]', f'n=[{{"{LONG}":1}}]'):
                        yield [*words[:index], long, *words[index + 1 :]]


def test_a_refusal_repeats_only_a_part_of_a_long_word(dictionary):
    refused = 0
    for words in lines():
        try:
            planned = commands.plan(words, dictionary)
        except UsageError as problem:
            refused += 1
            assert len(str(problem)) < REFUSAL_MAX, [word[:40] for word in words]
        else:
            assert max(len(one.text) for one in (planned, *planned.requests)) < 2 * values.TEXT_MAX, [word[:40] for word in words]
    assert refused > 500


def test_the_length_of_a_long_word_is_given():
    assert values.quoted("x" * 200) == f"'{200 * 'x'}'" and values.quoted("x" * 201) == f"'{200 * 'x'}...' (201 characters)"
    assert Command(LONG, None).text == Request(1, 17, 1, text=LONG).text == f"{values.TEXT_MAX * 'x'}... (10000 characters)"


def test_the_words_of_a_line_are_those_of_a_shell():
    """The station splits lines without shlex, which looks at each character of a long line, while the station waits."""
    draw = random.Random(1)
    for _ in range(20_000):
        line = "".join(draw.choices(" \tab'\"\\#\n;\u00e9\u00a0", k=draw.randrange(12)))
        try:
            expected = shlex.split(line)
        except ValueError as problem:
            with pytest.raises(ValueError, match=str(problem)):
                words_of(line)
        else:
            assert words_of(line) == expected, repr(line)


@pytest.mark.parametrize("line", ['"' + 100_000 * "a", '"' + 100_000 * "\\a", "'" + 100_000 * "a", 99_999 * "\\"])
def test_a_long_line_without_its_end_is_refused_in_linear_time(line):
    """A regular expression that tries each division of the characters would not end, and the station would stand still."""
    with pytest.raises(ValueError, match="No closing quotation|No escaped character"):
        words_of(line)


@pytest.mark.parametrize("words", [
    [LONG], ["--port", LONG, "ping"], ["--timeout", LONG, "ping"], [f"--{LONG}", "ping"], ["--dictionary", LONG, "ping"], ["--run", LONG, "record"],
    ["--run", LONG, "pcap"], ["decode", LONG], ["script", LONG], ["key", "make", LONG], ["replay", LONG], ["completion", LONG], ["hand", LONG], ["mcap", LONG],
])
def test_options_and_files_are_repeated_only_in_part(dictionary_path, capsys, words):
    assert main(["--dictionary", str(dictionary_path), *words]) in (1, 2, 3)
    assert 0 < len(capsys.readouterr().err) < REFUSAL_MAX


@pytest.mark.parametrize("words", [["--http-port", LONG], ["--framed-by", LONG], [f"--{LONG}"], ["--replay", LONG]])
def test_the_station_repeats_a_part_of_its_options(capsys, words):
    with pytest.raises(SystemExit) as end:
        station_main.main(words)
    said = end.value.code if isinstance(end.value.code, str) else capsys.readouterr().err
    assert 0 < len(said) < REFUSAL_MAX


def test_forms_repeat_a_part_of_their_values(dictionary):
    forms = Forms(dictionary)
    for identity, values_ in ((LONG, {}), ("tc 11,4", {"Subsystem": "SUPERVISOR", "sub_schedule_id": "1", "n": [LONG]}),
                              ("hk enable MANIPULATOR", {"Structure": f"{'9' * 4000}"}), ("fault unplug", {"bus or instrument": f"a {LONG}"})):
        with pytest.raises(UsageError) as problem:
            forms.text(identity, values_)
        assert len(str(problem.value)) < REFUSAL_MAX


@pytest.mark.parametrize("time", ["1e99999999", "-1E+99999999", "1e99999"])
def test_a_time_with_a_long_exponent_is_refused_before_it_is_computed(dictionary, time):
    """The exact number would have more digits than the memory has room for."""
    activity = {"group_id": 1, "release_time": time, "request": "ping SUPERVISOR"}
    dictionary.catalogue.plan = lambda text: b""
    with pytest.raises(MessageProblem, match=f"release_time: '{re.escape(time)}' is not"):
        dictionary.catalogue.encode("TC", 11, 4, {"sub_schedule_id": 1, "n": [activity]})
