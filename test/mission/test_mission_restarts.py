# SPDX-License-Identifier: Apache-2.0
"""Hundreds of restarts: after a stop by command or a kill, a member returns, and no name, descriptor, socket
or memory remains."""

import re
import shutil

import flying
import pytest
import soak

MEMBERS = ("JOYSTICK", "MANIPULATOR")
KILLS_MAX = 200  # A scenario has at most 256 faults.
# Restarts of each form. Those of the image take less time; with 200 the test still gets enough samples, which it takes in wall-clock time.
SHORT, LONG = {"processes": 40, "image": 200}, 1000


def _mission(directory):
    """A copy of the tree whose mission treats each death as the first one."""
    root = directory / "root"
    root.mkdir(parents=True)
    for name in ("build", "gse", "sim", "pus"):
        (root / name).symlink_to(flying.ROOT / name)
    shutil.copytree(flying.ROOT / "descriptors", root / "descriptors")
    path = root / "descriptors" / "missions" / "rokviss.xml"
    text = path.read_text(encoding="utf-8")
    changed = re.sub(r'restarts="2" deviceDeadline', 'restarts="2" restartPeriod="1ms" deviceDeadline', text)
    assert changed != text
    path.write_text(changed, encoding="utf-8")
    return root


def _scenario(path, count):
    """The members take turns; one fifth of the lives are killed, the others stopped; every second time the
    bus and a link are open."""
    lines, at = ["0.0 hand rest"], 0.5
    for number in range(count):
        name, kills = MEMBERS[number % 2], number % 5 == 0 and number // 5 < KILLS_MAX
        if number % 4 < 2:
            lines += [f"{at:.3f} operator state {name} PRE_OPERATIONAL", f"{at:.3f} operator config {name} TELEPRESENCE"]
        if kills:
            lines += [f"{at + 0.15:.3f} fault kill {name}"]
        else:
            lines += [f"{at + 0.1:.3f} operator state {name} OFFLINE"] if number % 4 < 2 else []
            lines += [f"{at + 0.15:.3f} operator process stop {name}", f"{at + 0.15:.3f} operator process start {name}"]
        lines += [f"{at + 0.3:.3f} operator ping {name}"]
        at += 0.35
    return flying.write_scenario(path, *lines, f"{at:.3f} operator status", f"{at:.3f} operator shutdown")


def _fly(directory, count, form, sample_s):
    root = _mission(directory)
    out = directory / "run"
    out.mkdir()
    for name in soak.UNLOGGED:
        (out / name).symlink_to("/dev/null")
    flight = flying.start(out, "--scenario", _scenario(directory / "restarts.scn", count), "--form", form, root=root)
    samples = [sample for sample in soak.watch(flight, sample_s) if sample["simulated_s"] > 0]
    assert "FAILED" not in flight.console, flight.transcript()
    assert flight.console.count(" is alive") == count, flight.transcript()
    assert flight.facts["reproducible"], flight.transcript()
    restarts = [int(found) for found in re.findall(r"restarts (\d+)", flight.console)]
    assert sum(restarts) == min(KILLS_MAX, (count + 4) // 5), restarts
    problems = list(soak.judge_samples(samples, form))
    assert not problems, (problems, samples[len(samples) // 4], samples[-1])
    flying.assert_clean(flight)


@pytest.mark.parametrize("form", ["processes", "image"])
def test_some_restarts_leave_nothing(directory, form):
    _fly(directory, SHORT[form], form, 0.01)


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("form", ["processes", "image"])
def test_a_thousand_restarts_leave_nothing(directory, form):
    _fly(directory, LONG, form, 0.25)
