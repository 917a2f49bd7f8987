# SPDX-License-Identifier: Apache-2.0
"""Every command of `gse` with its forms, a description and an example: for --help, completion and the shell.

A usage is a list of forms, separated by `, `. In a form, words in lower case are typed as they are, words in upper case stand for a
name or a value, `|` separates alternatives, brackets enclose what may be left out, and `...` repeats the word before it.
"""

from . import commands

CONSOLE = {
    "hk": ("hk [-f] [SUBSYSTEM], " + commands.VERBS["hk"][1], "show housekeeping as it arrives (-f: until Ctrl-C), or manage its reports"),
    "events": ("events [-f] [SUBSYSTEM]", "show events and state transitions as they arrive (-f: until Ctrl-C)"),
    "monitor": ("monitor, " + commands.VERBS["monitor"][1], "show the flight in the terminal, or manage limits of parameters that are monitored on board"),
    "shell": ("shell", "commands at a prompt, over one connection, with history and completion; `help` and `exit` there"),
    "permissions": ("permissions", "permitted requests by mode and state, from the dictionary"),
    "hand": (
        "hand rest|hold|let_go, hand aim RADIANS RADIANS SECONDS, hand grip STIFFNESS DAMPING, hand circle AMPLITUDE HERTZ RAMP HOLD DOWN, "
        "hand move X Z SECONDS, hand press NEWTONS SPEED, hand follow X SECONDS, hand pull DISTANCE SECONDS, hand release|home SECONDS",
        "move the simulated hand in a flight with TIME=real; lengths in m, forces in N, times in s (docs/scenarios.md)",
    ),
    "fault": (
        "fault unplug|plug BUS|INSTRUMENT [DEVICE], fault cut|mend BUS [DEVICE], fault loss|corruption|duplication BUS PROBABILITY, "
        "fault delay BUS DEVICE MICROSECONDS, fault babble|arbitration BUS DEVICE on|off, fault sync|overflow BUS DEVICE FRAMES, "
        "fault stuck BUS on|off, fault bus-off|reset BUS DEVICE, fault restart BUS DEVICE auto|order|now, "
        "fault error BUS DEVICE CODE on|off, fault torque-offset|temperature JOINT VALUE, fault silent|garbage INSTRUMENT on|off, "
        "fault kill|hang|resume PROCESS",
        "cause a fault in a flight with TIME=real (docs/scenarios.md)",
    ),
    "pause": ("pause", "pause simulated time, in a flight with TIME=real"),
    "resume": ("resume", "let simulated time continue"),
    "step": ("step SECONDS", "let this simulated time pass"),
    "speed": ("speed FACTOR", "pace of simulated time: 0.1 to 100 times the wall clock; 0: as fast as possible"),
    "record": ("record [RUN]", "print the scenario that repeats a flight with the lines that its live port received"),
    "replay": ("replay [RUN] [--http-port PORT]", "show a run on the web page of the station, with a time line, until Ctrl-C"),
    "decode": (
        "decode FILE|-, decode HEX ...",
        "show recorded packets or frames in words: packets in hexadecimal, packets.log, a log of candump -L, a capture (pcap, pcapng)",
    ),
    "pcap": ("pcap [RUN]", "write the packets of a run to packets.pcap, for Wireshark with build/generated/<mission>.lua"),
    "mcap": ("mcap [RUN]", "write a run to run.mcap, for PlotJuggler and Lichtblick"),
    "script": ("script FILE [--cosimulation SOCKET] [--run RUN]", "perform the operator's lines of a scenario"),
    "key": ("key make FILE", "make a key for authenticated telecommands, with its session counters FILE.sent and FILE.received"),
    "gateway": (
        "gateway [--listen PORT]",
        "accept packets from programs on this machine, such as Yamcs, protect them with the key and forward them",
    ),
    "completion": ("completion bash|zsh", "print the completion for a shell"),
}

EXAMPLES = {
    "ping": "gse ping all",
    "cmd": "gse cmd MANIPULATOR.MOVE_TO POSITION=0.9,-1.3 DURATION=2",
    "state": "gse state MANIPULATOR OPERATIONAL",
    "config": "gse config MANIPULATOR TELEPRESENCE",
    "reload": "gse reload MANIPULATOR",
    "link": "gse link open HAND_POSITION",
    "mode": "gse mode NOMINAL",
    "log": "gse log sqlite",
    "set": "gse set MANIPULATOR.TORQUE_LIMIT 30,30",
    "get": "gse get MANIPULATOR.CUR_VALUES.POSITION",
    "hk": "gse hk enable MANIPULATOR 4712",
    "event": "gse event disable MANIPULATOR POOL_WARNING",
    "status": "gse status",
    "networks": "gse networks",
    "process": "gse process start JOYSTICK",
    "stop": "gse stop",
    "shutdown": "gse shutdown",
    "raw": "gse raw 1810c00000062f11010001fdef",
    "tc": "gse tc SUPERVISOR 11,17",
    "at": "gse at +60 state MANIPULATOR SAFE_OPERATIONAL",
    "schedule": "gse schedule list",
    "monitor": "gse monitor limit MANIPULATOR 1 LINK_AGE 0 5000 0 LINK_STALE",
    "action": "gse action add MANIPULATOR TORQUE_LIMIT state MANIPULATOR SAFE_OPERATIONAL",
    "store": "gse store create HOUSE 65536",
    "procedure": "gse procedure run WAVE UINT8:3",
    "file": "gse file list /",
    "events": "gse events -f MANIPULATOR",
    "shell": "gse shell",
    "permissions": "gse permissions",
    "hand": "gse hand aim 0.1 0 0.5",
    "fault": "gse fault unplug robot JOINT1",
    "pause": "gse pause",
    "resume": "gse resume",
    "step": "gse step 0.1",
    "speed": "gse speed 0.5",
    "record": "gse record > again.scn",
    "replay": "gse replay runs/latest",
    "decode": "gse decode runs/latest/packets.log",
    "pcap": "gse pcap runs/latest",
    "mcap": "gse mcap runs/latest",
    "script": "gse script sim/scenarios/telepresence.scn",
    "key": "gse key make ground.key",
    "gateway": "gse gateway --listen 10025",
    "completion": "eval \"$(gse completion bash)\"",
}


def table():
    """Command -> (usage, description)."""
    return {**{name: (usage, about) for name, (_, usage, about) in commands.VERBS.items()}, **CONSOLE}


def forms(verb):
    """Forms of a command, each a list of words without the brackets; "..." stands for the repetition of the word before it."""
    found = []
    for form in table()[verb][0].split(", "):
        words = form.split()
        found.append([word if "[." in word or word == "[...]" else word.strip("[]") for word in words])
    return [[word.replace("[...]", "...") for word in form] for form in found]


def help_of(verb):
    """Complete help of one command."""
    usage, about = table()[verb]
    lines = [*(f"usage: gse {form}" for form in usage.split(", ")), "", f"{about}.", "", f"example: {EXAMPLES[verb]}"]
    return "\n".join([*lines, "", "gse --help lists all commands and the options of every command."])


def overview():
    """All commands, for `gse --help`."""
    lines = ["commands:"]
    for usage, about in table().values():
        lines += [f"  {usage}", f"        {about}"]
    return "\n".join(lines)
