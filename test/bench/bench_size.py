# SPDX-License-Identifier: Apache-2.0
"""Text (code and constants) of the framework and of the packet services on x86-64, compiled with -Os and without tables
for unwinding: of each library by its objects, and of all linked together as a program holds them, where equal texts are
there once. Baseline of the whole: what it may be."""

import pathlib
import shutil
import subprocess
import sys

FLAGS = "-std=c99 -D_POSIX_C_SOURCE=200809L -I. -Ibuild -Os -ffp-contract=off -fno-asynchronous-unwind-tables".split()
OUT = pathlib.Path("build/size")
ALLOWED = 90000


def compiled(source):
    """Object of one source file."""
    target = OUT / f"{str(source).replace('/', '_')}.o"
    subprocess.run(["gcc", *FLAGS, "-c", str(source), "-o", str(target)], check=True)
    return target


def text_of(target):
    """Octets of text of an object or a program."""
    lines = subprocess.run(["size", str(target)], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    return int(lines[1].split()[0])


def linked(objects):
    """All of them in one; what they need of others is left out."""
    target = OUT / "framework_and_pus"
    subprocess.run(["ld", "--entry=0", "--unresolved-symbols=ignore-all", "-o", str(target), *map(str, objects)], check=True)
    return target


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    folders = [folder for folder in sorted(pathlib.Path("fsw/framework").iterdir()) if folder.is_dir()]
    everything = []
    for folder in [*folders, pathlib.Path("pus")]:
        objects = [compiled(source) for source in sorted(folder.glob("*.c"))]
        everything += objects
        print(f"BENCH text_{folder.name} {sum(map(text_of, objects))} octets -")
    print(f"BENCH text_framework_and_pus {text_of(linked(everything))} octets {ALLOWED}")


if __name__ == "__main__":
    sys.exit(main())
