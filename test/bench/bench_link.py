# SPDX-License-Identifier: Apache-2.0
"""Round trips of real-time links between two processes on two processors, compared with the bare mechanisms (a
sequence lock in shared memory, UDP) and with other middleware (iceoryx2, LCM).

Each transport is a separate program (test/bench/transport, test/bench/peers) that does the same work; a round runs
each of them once. The reported value is the median of the rounds' medians; the reported ratio is the median of the
ratios of each round."""

import os
import pathlib
import statistics
import subprocess
import sys

ROUNDS, TRIPS, LIMIT_S = 9, 3000, 60
PROGRAMS = pathlib.Path("build/bench/transport")
ICEORYX2 = pathlib.Path("build/peers/iceoryx2/target/release/round-trip-iceoryx2")
# LCM needs a multicast route on the loopback interface. The command adds it in a separate network namespace, which
# disappears with the program.
OWN_NETWORK = ["unshare", "--net", "sh", "-c",
               'ip link set lo up multicast on && ip route add 239.255.76.67/32 dev lo && exec "$@"', "sh"]
# A peer that dies leaves names of shared memory and files that describe services. In a separate mount namespace they
# disappear with it. If the checkout is below /tmp, /tmp is not replaced.
OWN_PLACE = ["unshare", "--mount", "sh", "-c",
             'mount -t tmpfs bench /dev/shm && case "$PWD" in /tmp/*) ;; *) mount -t tmpfs bench /tmp ;; esac && exec "$@"',
             "sh"]
# (row, mode, payload [octets], our transport, the transport compared with it)
ROWS = [
    ("link_poll_64", "poll", 64, "link_shm", "seqlock"),
    ("link_poll_1024", "poll", 1024, "link_shm", "seqlock"),
    ("link_poll_64_by_iceoryx2", "poll", 64, "link_shm", "iceoryx2"),
    ("link_poll_1024_by_iceoryx2", "poll", 1024, "link_shm", "iceoryx2"),
    ("link_udp_64", "block", 64, "link_udp", "udp"),
    ("link_udp_64_by_lcm", "block", 64, "link_udp", "lcm"),
]


def is_permitted(place):
    try:
        return subprocess.run([*place, "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0
    except OSError:
        return False


def move_to_own_place():
    """Execute this program again in a separate mount namespace, once. Without the permission, print this and
    continue without it."""
    if "BENCH_OWN_PLACE" in os.environ:
        return
    os.environ["BENCH_OWN_PLACE"] = "1"
    if is_permitted(OWN_PLACE):
        sys.stdout.flush()
        os.execvp(OWN_PLACE[0], [*OWN_PLACE, sys.executable, *sys.argv])
    print("  no mount namespace here: what a peer leaves in /dev/shm and /tmp stays there", flush=True)


def round_trip(command):
    """Median of the round trip [us], or None if the program does not work here."""
    try:
        output = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True,
                                timeout=LIMIT_S).stdout
    except (OSError, subprocess.SubprocessError):
        return None
    words = next((line.split() for line in output.splitlines() if line.startswith("ROUND_TRIP")), None)
    return float(words[1]) / 1000.0 if words else None


def command_of(transport, mode, size, own_network):
    program = ICEORYX2 if transport == "iceoryx2" else PROGRAMS / transport
    command = [str(program), mode, str(size), str(TRIPS)]
    return [*OWN_NETWORK, *command] if transport == "lcm" and own_network else command


def measure(wanted):
    """{(transport, mode, size): [us of each round, None for a round that failed]}."""
    taken = {key: [] for key in wanted}
    own_network = is_permitted(OWN_NETWORK)
    for number in range(ROUNDS):
        for key in wanted:
            taken[key].append(round_trip(command_of(*key, own_network)))
        print(f"  round {number + 1} of {ROUNDS}", flush=True)
    return taken


def report(taken):
    for name, mode, size, ours, other in ROWS:
        pairs = [(a, b) for a, b in zip(taken[(ours, mode, size)], taken[(other, mode, size)]) if a and b]
        if len(pairs) <= ROUNDS // 2:
            print(f"SKIPPED {name} {other} is not installed or does not work on this machine")
            continue
        ratios = sorted(a / b for a, b in pairs)
        value, baseline = statistics.median(a for a, _ in pairs), statistics.median(b for _, b in pairs)
        print(f"BENCH {name} {value:.3f} us {baseline:.3f} {statistics.median(ratios):.4g} {ratios[0]:.4g} "
              f"{ratios[-1]:.4g}")


def main():
    wanted = sorted({(transport, mode, size) for _, mode, size, *pair in ROWS for transport in pair},
                    key=lambda key: (key[1], key[2], key[0]))
    if (os.cpu_count() or 1) < 2:
        for name, *_ in ROWS:
            print(f"SKIPPED {name} needs two processors")
        return
    move_to_own_place()
    report(measure(wanted))


if __name__ == "__main__":
    sys.exit(main())
