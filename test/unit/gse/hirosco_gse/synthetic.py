# SPDX-License-Identifier: Apache-2.0
"""Raw logs of a synthetic flight, with known results, to test figures and report.

Timetable [s]: engage 1; circle 1.5-12 (ramp 1, constant 8.5, down 1); press 13-14, follow 14-16, hold 16-25;
pull 26-28, hold 28-37; limit of 12 Nm set 37.2, exceeded 37.5; engaged again 37.9; joystick unplugged
38.5."""

import json
import struct

import numpy as np
from hirosco_gse import packets, truth
from tm_packets import build_tm

DT = 0.0005
COUNT = 80_000
COUNT_RAD = 2 * np.pi / 65536
HOME = np.radians([60.0, -90.0])
# Relative errors; the first is an rms value.
TRACKING_ERROR = 0.004
REFLECTION_ERROR = 0.003
REFLECTION_ERROR_CONTOUR = 0.006
FORWARD, BACK = 0, 1  # Cycles from the stick to the torque of the joint, and from the joint torque to the stick.
ENGAGE, AGAIN, LIMIT_SET, OVER, UNPLUG = 2000, 75_800, 74_400, 75_000, 77_000  # Cycles of the timetable.
LIMIT_REACTION = 1  # Cycles.
UNPLUG_REACTION_US = 3000
SEGMENTS = [
    ("rest", 0.0, 1.5),
    ("circle", 1.5, 12.0),
    ("move", 12.0, 13.0),
    ("press", 13.0, 14.0),
    ("follow", 14.0, 16.0),
    ("hold", 16.0, 25.0),
    ("move", 25.0, 26.0),
    ("pull", 26.0, 28.0),
    ("hold", 28.0, 37.0),
    ("rest", 37.0, 40.0),
]


def _ramp(time, start, end):
    x = np.clip((time - start) / (end - start), 0, 1)
    return x * x * (3 - 2 * x)


class Flight:
    """All signals over the cycles; tests may change them before they are written."""

    def __init__(self, seed=1):
        noise = np.random.default_rng(seed)
        self.time = np.arange(COUNT) * DT
        self._hand()
        self._arm(noise)
        self._scene()
        self._words(noise)
        self._faults()

    def _hand(self):
        t = self.time
        amplitude = 0.095 * (_ramp(t, 1.5, 2.5) - _ramp(t, 11.0, 12.0))
        phase = 2 * np.pi * 0.5 * (t - 1.5)
        self.intent = np.stack([amplitude * np.sin(phase), amplitude * np.cos(phase)], axis=1)
        self.intent[:, 0] += 0.05 * (_ramp(t, 13.0, 14.0) - _ramp(t, 25.0, 26.0)) + 0.02 * _ramp(t, 14.0, 16.0)
        self.intent[:, 1] += 0.08 * _ramp(t, 26.0, 28.0)
        self.stick = np.round(self.intent / COUNT_RAD) * COUNT_RAD

    def _arm(self, noise):
        steady = (self.time > 2.5) & (self.time < 11.0)
        extra = np.sqrt(2) * TRACKING_ERROR * np.sin(2 * np.pi * 7.0 * self.time)
        self.joint = HOME + 2 * self.intent
        self.joint[:, 0] += extra * steady * 2 * 0.095 / np.sqrt(2)
        self.noise_nm = noise.normal(0, 0.02, (COUNT, 2))

    def _scene(self):
        t = self.time
        self.in_contact = (t >= 13.2) & (t < 25.3)
        self.hooked = (t >= 26.2) & (t < 39.0)
        push = 15.0 * _ramp(t, 13.2, 13.8) * self.in_contact
        pull = 35.0 * _ramp(t, 26.2, 28.0) * self.hooked
        self.contact_force = np.stack([0 * t, 0 * t, push], axis=1)
        self.spring_force = np.stack([0 * t, 0 * t, -pull], axis=1)
        self.external = np.stack([0.30 * push - 0.31 * pull, 0.20 * push - 0.22 * pull], axis=1)
        first, both = self.joint[:, 0], self.joint.sum(axis=1)
        x = 0.22 * np.cos(first) + 0.25 * np.cos(both)
        z = 0.22 * np.sin(first) + 0.25 * np.sin(both)
        self.tip = np.stack([x, 0 * t, z], axis=1)

    def _words(self, noise):
        del noise
        gravity = np.array([5.0, 1.0])
        self.torque_word = np.round((gravity - self.external + self.noise_nm) / 0.01).astype(int)
        step = np.diff(self.stick, axis=0, prepend=self.stick[:1]) / COUNT_RAD
        # After an encoder count of the stick, the torque of the joint steps and decays (time constant 16 cycles).
        fading = np.exp(-np.arange(200) / 16)
        answer = np.stack([np.convolve(step[:, axis], fading)[:COUNT] for axis in range(2)], axis=1)
        command = gravity + 0.1 * np.sin(self.time)[:, None] + 1.6 * np.roll(answer, FORWARD, axis=0)
        self.command_word = np.round(command / 0.01).astype(int)
        error = np.where(self.time > 25.5, REFLECTION_ERROR, REFLECTION_ERROR_CONTOUR)[:, None]
        heard = np.roll(self.noise_nm, BACK, axis=0)
        self.felt_word = np.round((0.03 * self.external * (1 + error) - 0.1 * heard) / 1e-4).astype(int)
        self.joint_word = np.round(self.joint * 1e6).astype(int)
        self.stick_word = np.round(self.stick * 1e6).astype(int)
        self.status = np.full(COUNT, 0x1623)
        self.control = np.full(COUNT, 0x07)
        for start, end in ((ENGAGE, OVER + LIMIT_REACTION), (AGAIN, UNPLUG + 5)):
            self.status[start + 1 : end + 1] = 0x1627
            self.control[start:end] = 0x0F
        self.torque_word[OVER:AGAIN, 0] = 500
        self.torque_word[OVER : OVER + 200, 0] = 1250
        self.torque_word[AGAIN:, 0] = 500
        self.torque_word[37 * 2000 : OVER, 0] = 500
        self.torque_word[37 * 2000 :, 1] = 100
        self.stick_seen = np.ones(COUNT, bool)
        self.stick_seen[UNPLUG:] = False

    def _faults(self):
        limit_us = (OVER + LIMIT_REACTION + 1) * 500
        cut_us = UNPLUG * 500
        self.drives = []
        for node in (0x11, 0x12):
            for time_us, word, brake in (
                (0, 0x1640, 1),
                (ENGAGE * 500 + 500, 0x1627, 0),
                (limit_us, 0x1623, 1),
                (AGAIN * 500 + 500, 0x1627, 0),
                (cut_us + UNPLUG_REACTION_US, 0x1640, 1),
            ):
                self.drives.append(("robot", node, 0, time_us, word, 1, brake))
        for axis in (0, 1):
            for time_us, word, plugged in ((0, 0x1640, 1), (ENGAGE * 500, 0x1627, 1), (cut_us + 2500, 0x1640, 0)):
                self.drives.append(("joystick", 0x21, axis, time_us, word, plugged, 0))
        self.drives.sort(key=lambda entry: entry[3])
        self.faults = [(cut_us, "unplug", "joystick 0x21", 1)]


def _frame(time_us, bus, identifier, data, is_fd):
    text = data.hex().upper()
    stamp = f"({time_us // 1_000_000:010d}.{time_us % 1_000_000:06d})"
    return f"{stamp} {bus} {identifier:03X}#{'#1' if is_fd else ''}{text}\n"


def robot_log(flight):
    """can-robot.log."""
    lines = []
    for k in range(COUNT):
        t = k * 500
        # Slot k carries RPDO(k-1), which was computed from samples of cycle k-1 and is applied at SYNC k.
        at = max(k - 1, 0)
        for joint, node in enumerate((0x11, 0x12)):
            data = struct.pack("<Hhi", flight.control[at], flight.command_word[at, joint], 0)
            lines.append(_frame(t + 50 + 50 * joint, "robot", 0x300 + node, data, True))
        lines.append(_frame(t + 160, "robot", 0x80, b"", False))
        for joint, node in enumerate((0x11, 0x12)):
            words = flight.status[k], flight.joint_word[k, joint], flight.torque_word[k, joint]
            lines.append(_frame(t + 220 + 50 * joint, "robot", 0x180 + node, struct.pack("<Hih", *words), True))
    return "".join(lines)


def joystick_log(flight):
    """can-joystick.log."""
    lines = []
    for k in range(COUNT):
        t = k * 500
        at = max(k - 1, 0)
        data = struct.pack("<hhHH", *flight.felt_word[at], flight.control[at], flight.control[at])
        lines.append(_frame(t + 50, "joystick", 0x221, data, True))
        lines.append(_frame(t + 110, "joystick", 0x80, b"", False))
        if flight.stick_seen[k]:
            lines.append(_frame(t + 170, "joystick", 0x1A1, struct.pack("<ii", *flight.stick_word[k]), True))
            status = struct.pack("<HHI", flight.status[k], flight.status[k], 0)
            lines.append(_frame(t + 220, "joystick", 0x2A1, status, True))
    return "".join(lines)


def _text(word):
    return struct.pack(">I", len(word) + 1) + word.encode() + b"\0"


def truth_log(flight):
    """truth.lcm."""
    events, number = [], 0
    verbs = []
    for verb, _, end in SEGMENTS:
        verbs += [verb] * (round(end / DT) - len(verbs))

    def add(time_us, channel, body):
        nonlocal number
        data = struct.pack(">Q", truth.types()[channel.decode()].fingerprint) + struct.pack(">q", time_us * 1000) + body
        events.append(struct.pack(">IQQII", 0xEDA1DA01, number, time_us, len(channel), len(data)) + channel + data)
        number += 1

    slow = [(e[3], "DRIVE", e) for e in flight.drives] + [(f[0], "FAULT", f) for f in flight.faults]
    slow.sort(key=lambda item: item[0])
    for k in range(COUNT):
        t = k * 500
        while slow and slow[0][0] <= t:
            stamp, kind, entry = slow.pop(0)
            if kind == "DRIVE":
                bus, node, axis, _, word, plugged, brake = entry
                add(stamp, b"DRIVE", _text(bus) + struct.pack(">iiiBB", node, axis, word, plugged, brake))
            else:
                add(stamp, b"FAULT", _text(entry[1]) + _text(entry[2]) + bytes([entry[3]]))
        brake = 0 if flight.status[k] & 0x6F == 0x27 else 1
        joints = (*flight.joint[k], 0, 0, *flight.joint[k], 0, 0, 0, 0, 0, 0, *flight.external[k])
        add(t, b"JOINTS", struct.pack(">i14d2B", 2, *joints, brake, brake))
        felt = 0.03 * flight.external[k]
        add(t, b"STICK", struct.pack(">i8d", 2, *flight.intent[k], 0.0, 0.0, *felt, 0.0, 0.0))
        place = flight.tip[k]
        add(t, b"CONTACT", struct.pack(">i9d?", 1, *place, 0, 0, 0, *flight.contact_force[k], bool(flight.in_contact[k])))
        add(t, b"SPRING", struct.pack(">i6d?", 1, *place, *flight.spring_force[k], bool(flight.hooked[k])))
        add(t, b"OPERATOR", struct.pack(">7d", *flight.intent[k], *[0.0] * 4, 1.0) + _text(verbs[k]))
    return b"".join(events)


def packet_lines(flight, dictionary):
    """packets.log: transitions, an event, a limit set by TC[20,3], link status, housekeeping with ages."""
    del flight
    manipulator, joystick = dictionary.subsystem("MANIPULATOR"), dictionary.subsystem("JOYSTICK")
    rows = []

    def tm(time_s, apid, service, subtype, data, user=0):
        time_ns = round(time_s * 1e9)
        raw = build_tm(apid, len(rows), service, subtype, data, user, dictionary.epoch_ns + time_ns)
        rows.append((time_ns, "TM", raw))

    def move(time_s, apid, previous, state, cause=0):
        tm(time_s, apid, 129, 2, struct.pack(">BBBHBHI", previous, state, 0, 2, cause, 0, 0))

    for apid in (16, 17):
        for time_s, previous, state in ((0.1, 0, 1), (0.12, 1, 2), (0.2, 2, 3), (0.6, 3, 4), (1.0, 4, 5)):
            move(time_s + 0.001 * apid, apid, previous, state)
        tm(0.4 + 0.001 * apid, apid, 130, 10, struct.pack(">HBBB", 1, 2, 3, 0) + bytes(8))
    limit = manipulator.parameter("TORQUE_LIMIT")
    data = struct.pack(">BIdd", 1, limit.parameter_id, 12.0, 12.0)
    rows.append((round(37.2e9), "TC", packets.build_tc(16, 0, 20, 3, data)))
    event = manipulator.event("TORQUE_LIMIT")
    tm(37.5005, 16, 5, 3, struct.pack(">H", event.id) + bytes(sum(item.size for item in event.parameters)))
    move(37.501, 16, 5, 4)
    data = struct.pack(">BIdd", 1, limit.parameter_id, 38.0, 38.0)
    rows.append((round(37.8e9), "TC", packets.build_tc(16, 1, 20, 3, data)))
    move(37.9, 16, 4, 5)
    ends = struct.pack(">HBHHHH", 1, 3, 16, 1, 17, 2) + bytes(21)
    tm(38.0, 1, 130, 9, struct.pack(">H", 1) + ends + struct.pack(">IIIII", 74000, 74000, 0, 0, 74000), 1)
    lost = joystick.event("DEVICE_LOST")
    tm(38.5025, 17, 5, 4, struct.pack(">HB", lost.id, 0x21))
    move(38.5025, 17, 5, 6, 1)
    move(38.5030, 16, 5, 6, 2)
    structure = joystick.configuration("TELEPRESENCE").structures[4711]
    for number in range(70):
        values = b""
        for parameter in structure.once:
            values += bytes(parameter.size - 4) + struct.pack(">I", 500 + 10 * (number % 3)) if parameter.name == "LINK_AGE" else bytes(parameter.size)
        for repetitions, sampled in structure.repeated:
            values += bytes(repetitions * sum(parameter.size for parameter in sampled))
        tm(1.5 + 0.5 * number, 17, 3, 25, struct.pack(">H", structure.id) + values)
    rows.sort(key=lambda row: row[0])
    return "".join(f"{t // 10**9}.{t % 10**9:09d} {direction} {raw.hex()}\n" for t, direction, raw in rows)


def write(directory, dictionary, flight=None):
    """All logs of a flight."""
    flight = flight or Flight()
    (directory / "can-robot.log").write_text(robot_log(flight))
    (directory / "can-joystick.log").write_text(joystick_log(flight))
    (directory / "truth.lcm").write_bytes(truth_log(flight))
    (directory / "packets.log").write_text(packet_lines(flight, dictionary))
    steps = [(0.0, 0.01, "ping", ["all"]), (0.1, 0.2, "state", ["MANIPULATOR", "PRE_OPERATIONAL"]), (1.0, 1.02, "state", ["MANIPULATOR", "OPERATIONAL"])]
    entries = [{"time": a, "end": b, "line": 1, "verb": v, "words": w, "outcome": "ok", "text": ""} for a, b, v, w in steps]
    (directory / "operator.log").write_text("".join(json.dumps(entry) + "\n" for entry in entries))
    facts = {"mission": "rokviss", "scenario": "telepresence", "seed": 1, "form": "processes", "exit_code": 0, "real_time_factor": 12.5}
    (directory / "run.json").write_text(json.dumps(facts))
