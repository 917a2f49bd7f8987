# SPDX-License-Identifier: Apache-2.0
"""Speed of whole flights against their parts, in the same rounds: the bare plant loop, a bare futex ring.

    image       simulator, all flight components and all logs in one program, per step of 0.5 ms;
                baseline: the bare ODE plant loop (bound 4)
    processes   the same as processes; baseline: the image plus one round of a bare futex ring of five (bound 1.5)

The result is the median over the rounds. Each flight is divided by the baseline measured in the same round."""

import json
import pathlib
import shutil
import statistics
import subprocess
import sys

ROUNDS = 5
STEP_US = 500.0
RUNS = pathlib.Path("runs")


def bench_line(program, name):
    """Value of the BENCH line `name` of a compiled measuring program."""
    output = subprocess.run([f"build/bench/{program}"], stdout=subprocess.PIPE, text=True, check=True).stdout
    return next(float(line.split()[2]) for line in output.splitlines() if line.split()[:2] == ["BENCH", name])


def flight(form, number):
    """(us of wall-clock time per step, real-time factor) of the telepresence mission."""
    folder = RUNS / f"bench-{form}-{number}"
    shutil.rmtree(folder, ignore_errors=True)
    command = ["build/bin/hirosco", "run", "--form", form, "--report", "no", "--out", str(folder)]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    factor = json.loads((folder / "run.json").read_text(encoding="utf-8"))["real_time_factor"]
    shutil.rmtree(folder)
    return STEP_US / factor, factor


def main():
    """Fly in rounds and print the BENCH lines."""
    plant, ring, image, processes = [], [], [], []
    for number in range(ROUNDS):
        plant.append(bench_line("bench_plant", "plant_step_us"))
        image.append(flight("image", number))
        ring.append(bench_line("bench_futex_ring", "futex_ring_of_five"))
        processes.append(flight("processes", number))
        print(f"  round {number + 1} of {ROUNDS}", flush=True)
    median = statistics.median
    image_us, processes_us = median([us for us, _ in image]), median([us for us, _ in processes])
    print(f"BENCH image_step {image_us:.3f} us {median(plant):.3f}")
    print(f"BENCH processes_step {processes_us:.3f} us {image_us + median(ring):.3f}")
    print(f"BENCH image_real_time_factor {median([factor for _, factor in image]):.1f} x -")
    print(f"BENCH processes_real_time_factor {median([factor for _, factor in processes]):.1f} x -")


if __name__ == "__main__":
    sys.exit(main())
