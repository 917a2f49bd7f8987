# SPDX-License-Identifier: Apache-2.0
"""Two on-board computers and TIPC. Network namespaces and UDP are tested on this kernel if it permits them.
TIPC is tested in one boot of a test environment that has it, together with the C tests of its layer."""

import concurrent.futures
import json
import os
import subprocess
import sys

import pytest

import environments

sys.path.insert(0, str(environments.ROOT / "test" / "mission"))

import flying
import second_reader

PROGRAM = "test/hil/guest/nodes.py"
GROUP_SECONDS = 9000
LONG_TIPC_TESTS = ("unit/fsw/framework/message/test_message_epochs", "unit/fsw/framework/message/test_message_overload")
TIPC_TESTS = ("contract/osal/posix/test_tipc", "contract/osal/posix/test_network", "unit/fsw/framework/message/test_message",
              *(LONG_TIPC_TESTS if os.environ.get("LONG") else ()))
REACTION_US = 5000
REPEATS = 5
CASES = [case for case in environments.cases(PROGRAM) if case != "repetitions_give_the_same_checksum"]
# With LONG=1, the cases fly over TIPC, too: the micro-VM takes half a minute of processor time and more for each.
DRIVES = 4
ENVIRONMENT = "PYTHONPYCACHEPREFIX=$PWD/build/pycache"


def has_namespaces():
    """True if this kernel permits this account to make network namespaces and to join them."""
    command = "ip netns add one && ip -n one link add name one type veth peer name two && ip netns delete one"
    return environments.in_namespaces(command, environments.PROBE_SECONDS, dict(os.environ))[0] == 0


@pytest.fixture(scope="session")
def two_readers(hil_directory):
    """Environment that names the mission with a port of two readers; it is built here, because the micro-VM compiles slowly."""
    return f"SECOND_READER={second_reader.build(hil_directory / 'second-reader')} {ENVIRONMENT}"


@pytest.fixture(scope="session")
def udp(environment, hil_directory, two_readers):
    """Results of the group over UDP, on this kernel if possible."""
    here = environments.RunningKernel(hil_directory, "it has network namespaces") if has_namespaces() else environment
    return here.group("nodes-udp", f"{two_readers} {environments.PYTHON} {PROGRAM} udp", GROUP_SECONDS)


@pytest.fixture(scope="session")
def tipc(request, environment, two_readers):
    """Results of the group over TIPC. The C tests run first; their results are in $OUT/c-tests. Then the cases that this session
    asks for fly."""
    asked = {item.callspec.params["case"] for item in request.session.items if item.name.startswith("test_a_case_passes_over_tipc[")}
    names = " ".join(case for case in CASES if case in asked)
    programs = " ".join(f"build/test/{name}" for name in TIPC_TESTS)
    tests = f'for test in {programs}; do $test >"$OUT/$(basename $test).txt" 2>&1; echo "$test $?" >>"$OUT/c-tests"; done; '
    flights = f"{two_readers} {environments.PYTHON} {PROGRAM} tipc {names}" if names else ""
    return environment.group("nodes-tipc", tests + flights, GROUP_SECONDS)


@pytest.mark.timeout(GROUP_SECONDS)
@pytest.mark.parametrize("case", CASES)
def test_a_case_passes_over_udp(udp, case):
    udp.check(case)


@pytest.mark.long
@pytest.mark.timeout(GROUP_SECONDS)
@pytest.mark.parametrize("case", CASES)
def test_a_case_passes_over_tipc(tipc, case):
    tipc.check(case)


@pytest.mark.long
@pytest.mark.timeout(GROUP_SECONDS)
def test_repetitions_over_tipc_have_one_checksum(environment):
    """The test repeats the flight fewer times than the twenty of the other forms (test/mission/test_mission_lives.py),
    because the micro-VM is slow."""
    command = f"{ENVIRONMENT} LIVES_REPEATS={REPEATS} {environments.PYTHON} {PROGRAM} tipc repetitions_give_the_same_checksum"
    environment.group("repeats-tipc", command, GROUP_SECONDS).check("repetitions_give_the_same_checksum")


@pytest.mark.parametrize("name", TIPC_TESTS)
def test_the_c_tests_pass_over_tipc(tipc, name):
    """The C tests that use TIPC, on a kernel that has it. They also show that the loss of a block by a slow receiver is reported."""
    path = tipc.result.directory / "c-tests"
    outcomes = dict(line.split() for line in path.read_text().splitlines()) if path.exists() else {}
    text = (tipc.result.directory / f"{name.rpartition('/')[2]}.txt")
    output = text.read_text(errors="replace") if text.exists() else tipc.result.end()
    assert outcomes.get(f"build/test/{name}") == "0", output
    assert "a_kernel_without_tipc_is_reported" not in output


def cuts_and_reactions(directory):
    """For each cut, the time [us] at which each drive left operation, from the truth of the drives."""
    from hirosco_gse import run as runs

    run = runs.load(directory)
    histories = {}
    for entry in run.truth["DRIVE"]:
        histories.setdefault((entry["bus"], int(entry["node"]), int(entry["axis"])), []).append(entry)
    for fault in run.truth["FAULT"]:
        if fault["kind"] == "unplug":
            cut = fault["time_us"]
            yield [next(e["time_us"] for e in history if e["time_us"] >= cut and e["statusword"] & 0x6F != 0x27) - cut
                   for history in histories.values()
                   if [e for e in history if e["time_us"] < cut][-1]["statusword"] & 0x6F == 0x27]


@pytest.mark.timeout(GROUP_SECONDS)
@pytest.mark.parametrize("method", ["udp", pytest.param("tipc", marks=pytest.mark.long)])
def test_unplug_between_nodes_stops_all_drives_within_5_ms(request, method):
    group = request.getfixturevalue(method)
    group.check("unplugs_between_nodes_give_the_octets_of_an_image")
    reactions = list(cuts_and_reactions(group.result.directory / f"judged-{method}"))
    assert len(reactions) == 2
    for reaction in reactions:
        assert len(reaction) == DRIVES, "not all drives were in operation"
        assert max(reaction) <= REACTION_US, reaction


# --- links with delay ------------------------------------------------------------------------------------------------

def delayed(hil_directory, case, round_trip_ms=20):
    """Run a case in the micro-VM, which has netem and is slower than real time. The delays of netem are in
    wall-clock time: on a machine that pauses and then flies faster than real time to catch up, the frames would
    arrive too late in simulated time, and the links would be stale."""
    vm = environments.MicroVm(hil_directory, "netem")
    group = vm.group(case, f"{ENVIRONMENT} ROUND_TRIP_MS={round_trip_ms} {environments.PYTHON} test/hil/guest/delayed_links.py {case}", GROUP_SECONDS)
    group.check(case)
    return group


@pytest.mark.long
@pytest.mark.timeout(GROUP_SECONDS)
def test_frames_between_nodes_pass_netem(hil_directory):
    delayed(hil_directory, "frames_between_nodes_pass_netem")


@pytest.mark.long
@pytest.mark.timeout(GROUP_SECONDS)
def test_the_arm_presses_through_netem(hil_directory):
    """The hand holds contact with 15 N, and the arm does not exceed the bound of the relay with this delay."""
    from hirosco_gse import run as runs

    group = delayed(hil_directory, "the_arm_presses_through_netem")
    contact = runs.load(group.result.directory / "judged").truth["CONTACT"]
    held = [entry for entry in zip(*(contact[name] for name in ("time_us", "in_contact", "contact_force_n"))) if 5.0e6 <= entry[0] <= 5.6e6]
    assert held and all(in_contact for _, in_contact, _ in held)
    forces = [sum(component**2 for component in force) ** 0.5 for force in contact["contact_force_n"]]
    assert 10 < max(forces) < 25, max(forces)


@pytest.mark.long
@pytest.mark.timeout(GROUP_SECONDS)
@pytest.mark.parametrize("round_trip_ms", [100, 300])
def test_a_hold_through_netem_is_within_the_bounds_of_its_delay(hil_directory, record_property, round_trip_ms):
    """The bounds are those of the relay with this delay. The play-out buffers of the readers make the delay constant in simulated time."""
    from hirosco_gse import delay_figures
    from hirosco_gse import run as runs
    from hirosco_gse.figures_common import segment

    group = delayed(hil_directory, "the_arm_holds_contact_through_netem", round_trip_ms)
    run = runs.load(group.result.directory / "judged")
    (press, _), (_, end) = segment(run, "press", None), segment(run, "hold", None)
    end -= 1000  # Without the last 0.5 s: the mean of an oscillation needs samples on both sides.
    found = delay_figures.held(run, end - 4000, end) | {"delay_force_peak_n": delay_figures.force_peak(run, press, end)}
    record_property("figures", found)
    for name, value in found.items():
        sign, bound = delay_figures.BOUNDS[round_trip_ms][name]
        assert value <= bound if sign == "<=" else value >= bound, found


def test_a_kernel_without_netem_is_reported_with_the_next_step(tmp_path):
    """The mission has a link between the nodes. Skipped on a kernel with netem, which would fly it."""
    if not has_namespaces():
        pytest.skip("no namespaces on this kernel for this account")
    probe = "ip link add one type veth peer name two && tc qdisc add dev one root netem delay 1ms"
    if environments.in_namespaces(probe, environments.PROBE_SECONDS, dict(os.environ))[0] == 0:
        pytest.skip("this kernel has netem")
    tree = flying.descriptors_copied(tmp_path / "tree")
    path = tree / "descriptors" / "missions" / "rokviss.xml"
    path.write_text(path.read_text(encoding="utf-8").replace('node="2"', 'node="1"', 1), encoding="utf-8")
    run = f"cd {tree} && exec build/bin/hirosco run --nodes 2 --delay 20 --time real --report no --out {tmp_path}/run; "
    code, _, output = environments.in_namespaces(f"({run}); code=$?; ls -A /run/netns; exit $code", environments.SECONDS, dict(os.environ))
    output = output.decode(errors="replace")
    assert code == 1, output
    assert "needs `tc` of iproute2 and netem in the kernel" in output and "modprobe sch_netem" in output and "make vm" in output, output


def test_a_delay_between_nodes_needs_a_link_between_them(tmp_path):
    if not has_namespaces():
        pytest.skip("no namespaces on this kernel for this account")
    run = f"exec build/bin/hirosco run --nodes 2 --delay 20 --time real --report no --out {tmp_path}/run"
    code, _, output = environments.in_namespaces(run, environments.SECONDS, dict(os.environ))
    assert code == 1
    output = output.decode(errors="replace")
    assert 'no link goes from one node to the other; give the <Subsystem> at one end of a link another node=""' in output, output
    assert "missions/rokviss.xml" in output


def test_flights_of_two_containers_do_not_interfere(tmp_path):
    """Containers count processes from 1 each and may share /tmp: two launchers with one process number fly at
    the same time."""
    if not has_namespaces():
        pytest.skip("no namespaces on this kernel for this account")
    meeting = tmp_path / "here"
    both_are_here = f"until test -e {meeting}-one -a -e {meeting}-two; do sleep 0.01; done"

    def fly(name):
        run = f"exec build/bin/hirosco run --scenario commissioning --report no --out {tmp_path}/{name}"
        return environments.in_namespaces(f"touch {meeting}-{name}; {both_are_here}; {run}", environments.SECONDS, dict(os.environ))

    with concurrent.futures.ThreadPoolExecutor() as pool:
        for code, output, problem in pool.map(fly, ("one", "two")):
            assert code == 0, (output + problem).decode(errors="replace")


# --- what the system does not permit -------------------------------------------------------------------------------

def refused(command):
    done = subprocess.run(command, cwd=environments.ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=600)
    assert done.returncode == 1, done
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    return done.stderr


def test_namespaces_that_are_not_permitted_are_reported_with_the_next_step(tmp_path):
    """The launcher runs without privileges, here in a user namespace that maps no account to root."""
    line = ["unshare", "--user", "--map-user=1000", "build/bin/hirosco", "run", "--nodes", "2", "--out", str(tmp_path / "run")]
    said = refused(line)
    assert "sudo make sim-run NODES=2" in said and "make vm SECONDS=" in said
    assert not (tmp_path / "run").exists()


def test_kernel_without_tipc_is_reported_with_the_next_step(tmp_path):
    import socket

    try:
        socket.socket(socket.AF_TIPC, socket.SOCK_RDM).close()
    except OSError:
        said = refused(["build/bin/hirosco", "run", "--transport", "tipc", "--out", str(tmp_path / "run")])
        assert "modprobe tipc" in said and "make vm SECONDS=" in said
        assert not (tmp_path / "run").exists()
    else:  # The flight succeeds: other tests cover the refusal.
        done = subprocess.run(["build/bin/hirosco", "run", "--transport", "tipc", "--scenario", "commissioning", "--report", "no",
                               "--out", str(tmp_path / "run")], cwd=environments.ROOT, stdin=subprocess.DEVNULL, timeout=600)
        assert done.returncode == 0
        assert json.loads((tmp_path / "run" / "run.json").read_text())["transport"] == "tipc"
