# SPDX-License-Identifier: Apache-2.0
"""Size of the text (code and constants) and of the RAM, compiled with -Os and without unwind tables.

Rows of text on x86-64:
- each library of the framework and of the packet services: the sum of its objects
- the framework with the services that every subsystem has, linked as in a program: equal constants count once, and other
  libraries only as far as they are referenced
- the addition of each option with what it needs: each other service, each end node except CAN, stream devices on all end
  nodes, control of drives, protected telecommands, limits of resources, and what only supervisor and launcher have:
  reading the whole mission, taking over the channels of a process that died
Row of text for a Cortex-M: all packet services, the sum of their objects. The baseline of a row is its limit.

Rows of RAM: what each subsystem adds to an image on x86-64, all of it static: its component with services and
persistent records, the storage of its own code, its inbox, its runtime, its descriptor. Further rows have what a program
needs once: the mission's descriptor, the reader of descriptors, the proxy's stream. Stacks, constants, the port of the
operating system layer and shared memory of buses and links do not count. Supervisor (services of the whole
spacecraft) and communication (a queue for each connection of the ground) have rows without a bound."""

import pathlib
import re
import shutil
import subprocess
import sys

import failures

FLAGS = "-std=c99 -D_POSIX_C_SOURCE=200809L -I. -Ibuild -Os -ffp-contract=off -fno-asynchronous-unwind-tables".split()
HOST = ["gcc", *FLAGS]
NEWLIB = pathlib.Path("/usr/include/newlib")
CORTEX_M = ["clang", "--target=thumbv7em-none-eabi", "-mcpu=cortex-m4", *FLAGS, "-isystem", str(NEWLIB)]
OUT = pathlib.Path("build/size")
ALLOWED = 90000
ALLOWED_CORTEX_M = 128 * 1024
# The descriptor takes 71 KiB of this RAM, and the table of 32 devices on four buses 58 KiB.
ALLOWED_RAM = 356 * 1024
# It has room for 12 joints, three trajectories of 16 points, and the largest capacities of the optional services.
ALLOWED_RAM_OF = {"arm": 390 * 1024}
SIZES = """
#include "fsw/programs/component_runtime.h"
#include "fsw/subsystems/communication/communication.h"
uint8_t runtime[sizeof(component_runtime_t)];
uint8_t descriptor[sizeof(subsystem_descriptor_t)];
uint8_t queues[sizeof((const communication_t*)0)->queues];
"""
PUS = sorted(path for path in pathlib.Path("pus").glob("*/*.c") if path.parent.name != "tool")
SERVICE = re.compile(r"pus/(?:st\d+|private)/st(\d+)_")
EVERYWHERE = {1, 3, 5, 8, 17, 20, 129, 130} # Services of every subsystem.
# Options that only programs that use them contain: the name of the row and its sources.
OPTIONAL = {
    **{f"endnode_{way}": re.compile(rf"fsw/framework/dataflow/flow_{way}\.c") for way in ("mqueue", "shm", "stream", "tcp", "udp")},
    "stream_devices": re.compile(r"fsw/(devices/|framework/dataflow/flow\.c)"),
    "control": re.compile(r"fsw/framework/control/"),
    "resource_governor": re.compile(r"base/(resource|quota)\.c"),
    "sdls": re.compile(r"fsw/framework/sdls/"),
    "peer_of_subsystems": re.compile(r"pus/(core/packet_report|st05/st05_occurrence|private/st130_peer)\.c"),
    "takeover_of_channels": re.compile(r"fsw/framework/message/(message_positions|message_ring_refill)\.c"),
    "whole_mission": re.compile(r"fsw/framework/descriptor/mission_(checks|lookup|rules|whole)\.c"),
}
# Sources that are in a program only if an option or a device needs them: connection of an optional service to a
# component, its records; framing, records and the link state of flows; parameters in memories of ST[06].
NEEDED = re.compile(r"fsw/framework/(subsystem/\w+_service\.c|journal/|dataflow/(framing|link|record)\.c)|pus/st20/st20_definitions\.c")
# Programs by which sources of the common part are shown to be in all programs. A program with a device has
# the CAN end node and publishes complete tables of parameters; another program may not.
PROGRAMS = ("communication", "joystick", "manipulator")
WITH_DEVICES = re.compile(r"fsw/framework/(dataflow/(endnode|flow_can|reconnect)|subsystem/subsystem_common)\.c")


def compiled(source, compiler=HOST):
    """Compile a source file. Returns the path of the object file."""
    target = OUT / compiler[0] / f"{str(source).replace('/', '_')}.o"
    target.parent.mkdir(exist_ok=True)
    subprocess.run([*compiler, "-c", str(source), "-o", str(target)], check=True)
    return target


def text_of(target):
    """Octets of text of an object or a program."""
    lines = subprocess.run(["size", str(target)], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    return int(lines[1].split()[0])


def linked(objects, archive):
    """Octets of text of the objects linked into one program, with what they need of the archive; needed parts
    of other libraries do not count."""
    target = OUT / "linked"
    subprocess.run(["ld", "--entry=0", "--unresolved-symbols=ignore-all", "-o", str(target), *map(str, objects), str(archive)],
                   check=True)
    return text_of(target)


def service_of(source):
    """Number of the service that a source belongs to, or None."""
    match = SERVICE.match(str(source))
    return int(match[1]) if match else None


def option_of(source):
    """Name of the option to which a source belongs; None if the source is in all programs or is one of NEEDED."""
    service = service_of(source)
    if service is not None and service not in EVERYWHERE:
        return f"st{service:02}"
    return next((name for name, pattern in OPTIONAL.items() if pattern.match(str(source))), None)


def is_everywhere(source):
    if NEEDED.match(str(source)) or option_of(source) is not None:
        return False
    return source.parts[0] in ("base", "fsw") or service_of(source) in EVERYWHERE


def functions(target):
    lines = subprocess.run(["nm", str(target)], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    return {fields[2] for fields in map(str.split, lines) if len(fields) == 3 and fields[1] == "T"}


def check_everywhere(objects):
    """Check that each program of a subsystem contains something of each source of the common part; otherwise
    the row is wrong."""
    programs = {name: functions(f"build/bin/{name}") for name in PROGRAMS if pathlib.Path("build/bin", name).is_file()}
    for source in filter(is_everywhere, objects):
        named = functions(objects[source])
        missing = [name for name, held in programs.items() if named and not named & held]
        if missing and not WITH_DEVICES.match(str(source)):
            sys.exit(f"{source} is not in {', '.join(missing)}: it is an option of bench_size.py, or comes with what needs it")


def report_options(objects):
    """Print the size of the framework with the common services, and the addition of each option."""
    archive = OUT / "all.a"
    subprocess.run(["ar", "rcs", str(archive), *map(str, objects.values())], check=True)
    core = [target for source, target in objects.items() if is_everywhere(source)]
    text = linked(core, archive)
    for option in sorted({option_of(source) for source in objects} - {None}):
        more = [target for source, target in objects.items() if option_of(source) == option]
        print(f"BENCH text_more_for_{option} {linked(core + more, archive) - text} octets -")
    print(f"BENCH text_framework_and_pus {text} octets {ALLOWED}")


def report_cortex_m(sources):
    name = "text_pus_on_cortex_m"
    if not NEWLIB.is_dir() or not shutil.which(CORTEX_M[0]):
        print(f"SKIPPED {name} no clang, or no headers of newlib")
        return
    print(f"BENCH {name} {sum(text_of(compiled(source, CORTEX_M)) for source in sources)} octets {ALLOWED_CORTEX_M}")


def symbols(target):
    """Dictionary: name -> octets of each object in memory of an object file."""
    lines = subprocess.run(["nm", "-S", str(target)], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    fields = [line.split() for line in lines]
    return {each[3]: int(each[1], 16) for each in fields if len(each) == 4 and each[2] in "bBdD"}


def report_ram():
    """Print the memory that each program of a subsystem reserves for the subsystem, including the part of its
    host."""
    source = OUT / "sizes.c"
    source.write_text(SIZES)
    sizes = symbols(compiled(source))
    for program in sorted(pathlib.Path("fsw/programs").glob("*_program.c")):
        name = program.stem.removesuffix("_program")
        octets = symbols(compiled(program))["storage"] + sizes["runtime"] + sizes["descriptor"]
        if name == "communication":
            octets -= sizes["queues"]
            print(f"BENCH ram_communication_queues {sizes['queues']} octets -")
        print(f"BENCH ram_{name} {octets} octets {'-' if name == 'supervisor' else ALLOWED_RAM_OF.get(name, ALLOWED_RAM)}")
    parts = [symbols(compiled(pathlib.Path("fsw/programs", name)))["storage"] for name in ("executive.c", "executive_files.c")]
    once = sum(parts) - sizes["runtime"] - sizes["descriptor"]
    print(f"BENCH ram_once_in_a_program {once} octets -")


# ---- The image of a board ----

BOARD, MISSION = "mps2-an500", "rokviss"  # The image that is measured is for this mission alone.
MAP = pathlib.Path("build", BOARD, "flight/missions", MISSION, "manipulator/manipulator.map")
SECTION = re.compile(r" (\.[\w.$]+)?\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (\S+)$")
SYSTEM = ("osal_common", "osal_freertos", "foreign", "c", "gcc", "m")  # Port, kernel and C library.
ALLOWED_BOARD_TEXT = 128 * 1024
ALLOWED_BOARD_RAM = 96 * 1024


def parts_of_image(path):
    """{library: [text, RAM]} of an image, from the linker's map. Equal texts, which occur once, count where they are first used. A long name of
    a section has a line of its own in the map; address, size and file are on the next line."""
    parts, before, begun = {}, "", False
    for line in path.read_text().splitlines():
        begun = begun or line.startswith("Linker script and memory map")
        if re.match(r" \.\S+$", line):
            before = line.strip()
        match = SECTION.match(line)
        if not begun or not match:
            continue
        name, size = match[1] or before, int(match[3], 16)
        kind = name.split(".")[1] if name else ""
        library = re.search(r"lib([\w-]+)\.a", match[4])
        part = parts.setdefault(library[1] if library else pathlib.Path(match[4]).stem, [0, 0])
        part[0] += size if kind in ("text", "rodata", "vectors", "data") else 0
        part[1] += size if kind in ("bss", "data") else 0
    return {name: part for name, part in parts.items() if part != [0, 0]}


def report_board():
    """Print text and RAM of each library in the image of the manipulator, and of a subsystem without its own control."""
    if not shutil.which("arm-none-eabi-gcc"):
        print("SKIPPED board no arm-none-eabi-gcc")
        return
    subprocess.run(["make", "-s", "rtos", f"BOARD={BOARD}", f"MISSION={MISSION}", "ONLY=manipulator"], stdout=sys.stderr, check=True)
    parts = parts_of_image(MAP)
    for name, (text, ram) in sorted(parts.items()):
        print(f"BENCH board_text_{name} {text} octets -")
        print(f"BENCH board_ram_{name} {ram} octets -")
    rest = [part for name, part in parts.items() if name not in (*SYSTEM, "fsw_subsystems_manipulator")]
    print(f"BENCH board_text_of_a_subsystem {sum(part[0] for part in rest)} octets {ALLOWED_BOARD_TEXT}")
    print(f"BENCH board_ram_of_a_subsystem {sum(part[1] for part in rest)} octets {ALLOWED_BOARD_RAM}")


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    directories = [directory for directory in sorted(pathlib.Path("fsw/framework").iterdir()) if directory.is_dir()]
    objects = {}
    for directory in [pathlib.Path("base"), *directories, pathlib.Path("fsw/devices"), pathlib.Path("pus")]:
        sources = sorted(directory.glob("*.c")) or PUS
        of_directory = {source: compiled(source) for source in sources}
        objects.update(of_directory)
        print(f"BENCH text_{directory.name} {sum(map(text_of, of_directory.values()))} octets -")
    check_everywhere(objects)
    report_options(objects)
    report_ram()
    report_cortex_m(PUS)
    report_board()


if __name__ == "__main__":
    failures.run(main)
