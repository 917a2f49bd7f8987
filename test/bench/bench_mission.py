# SPDX-License-Identifier: Apache-2.0
"""Compares the speed of whole flights of rokviss with that of their parts in the same rounds: the bare plant loop, a bare futex ring.

    image       simulator, all flight components and all logs in one program, per step of 0.5 ms;
                baseline: the bare ODE plant loop (bound 3.5)
    processes   the same as processes; baseline: the image plus one round of a bare futex ring of five (bound 1.1)
    free_flyer  an arm of seven joints on two buses at 1 kHz, on a free base, as an image

A real-time factor is simulated time by wall-clock time. A processor factor is simulated time by the time of all processors, in user and
kernel mode, that the launcher and all programs of the flight needed, their start and end included: it depends less on other load.

The result is the median over the rounds. Each flight is divided by the baseline measured in the same round."""

import json
import pathlib
import resource
import shutil
import statistics
import subprocess

import failures

ROUNDS = 5
STEP_US = 500.0
RUNS = pathlib.Path("runs")


def bench_line(program, name):
    """Value of the BENCH line `name` of a compiled measuring program."""
    output = subprocess.run([f"build/bench/{program}"], stdout=subprocess.PIPE, text=True, check=True).stdout
    values = [float(line.split()[2]) for line in output.splitlines() if line.split()[:2] == ["BENCH", name]]
    assert values, f"build/bench/{program} has printed no line BENCH {name}"
    return values[0]


def processor_s():
    """Processor time of all child processes so far [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def flight(form, number, mission="rokviss", scenario="telepresence"):
    """(real-time factor, processor factor) of a flight."""
    directory = RUNS / f"bench-{mission}-{form}-{number}"
    shutil.rmtree(directory, ignore_errors=True)
    command = ["build/bin/hirosco", "run", "--mission", mission, "--scenario", scenario, "--form", form, "--report", "no", "--out", str(directory)]
    before_s = processor_s()
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    used_s = processor_s() - before_s
    facts = json.loads((directory / "run.json").read_text(encoding="utf-8"))
    shutil.rmtree(directory)
    return facts["real_time_factor"], facts["simulated_s"] / used_s


def main():
    """Fly in rounds and print the BENCH lines."""
    plant, ring = [], []
    flights = {"image": [], "processes": [], "free_flyer": []}
    for number in range(ROUNDS):
        plant.append(bench_line("bench_plant", "plant_step_us"))
        flights["image"].append(flight("image", number))
        ring.append(bench_line("bench_futex_ring", "futex_ring_of_five"))
        flights["processes"].append(flight("processes", number))
        flights["free_flyer"].append(flight("image", number, "free-flyer", "free-flyer"))
        print(f"  round {number + 1} of {ROUNDS}", flush=True)
    factors = {name: [statistics.median(values) for values in zip(*rounds)] for name, rounds in flights.items()}
    image_us, processes_us = (statistics.median(STEP_US / factor for factor, _ in flights[name]) for name in ("image", "processes"))
    print(f"BENCH image_step {image_us:.3f} us {statistics.median(plant):.3f}")
    print(f"BENCH processes_step {processes_us:.3f} us {image_us + statistics.median(ring):.3f}")
    for name, (real_time, processor) in factors.items():
        print(f"BENCH {name}_real_time_factor {real_time:.1f} x -")
        print(f"BENCH {name}_processor_factor {processor:.1f} x -")


if __name__ == "__main__":
    failures.run(main)
