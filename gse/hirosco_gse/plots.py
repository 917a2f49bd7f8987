# SPDX-License-Identifier: Apache-2.0
"""Plots of a run, each a function (run) -> matplotlib figure, or None if the logs contain no data for it."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch

from . import run as runs
from . import scene
from .figures import FORCE_SCALE, POSITION_SCALE
from .run import CYCLE_US

POINTS = 3000
BLUE, ORANGE, GREEN, RED, VIOLET, GREY = "#2f6db3", "#e08a1e", "#3a8f5c", "#c23b3b", "#7d5ba6", "#8a93a0"
PALE = "#bcd3ea"
STATE_COLOURS = {
    "OFFLINE": "#e3e6ea",
    "SOFTWARE_INIT": "#cfe0f3",
    "HARDWARE_INIT": "#a9c8ea",
    "PRE_OPERATIONAL": "#6d9fd6",
    "SAFE_OPERATIONAL": "#f0b84a",
    "OPERATIONAL": "#4fa36c",
    "ERROR_OPERATIONAL": "#cf4444",
    "POST_OPERATIONAL": "#b39ccb",
    "HARDWARE_DEINIT": "#cbbcdb",
    "SOFTWARE_DEINIT": "#e0d7ea",
}
SEVERITY_COLOURS = {"INFORMATIVE": GREY, "LOW": BLUE, "MEDIUM": ORANGE, "HIGH": RED}
PHASES = {
    "circle": ("free space", "#eef4fb"),
    "press": ("contour", "#f8f1e4"),
    "follow": ("contour", "#f8f1e4"),
    "pull": ("spring", "#ebf5ee"),
}

plt.rcParams.update(
    {
        "figure.facecolor": "white",
        "axes.grid": True,
        "grid.color": "#e4e7eb",
        "grid.linewidth": 0.7,
        "axes.edgecolor": "#b5bcc6",
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.titlesize": 10,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "axes.labelsize": 9,
        "xtick.labelsize": 8,
        "ytick.labelsize": 8,
        "legend.fontsize": 8,
        "legend.frameon": False,
        "lines.linewidth": 1.1,
    }
)


def _seconds(count):
    return np.arange(count) * CYCLE_US / 1e6


def _thin(time, values):
    """Reduce to at most POINTS points; each bucket keeps its smallest and largest value, so that peaks remain visible."""
    if len(values) <= POINTS:
        return time, values
    width = len(values) // (POINTS // 2)
    buckets = len(values) // width
    cut = values[: buckets * width].reshape(buckets, width)
    with np.errstate(invalid="ignore"):
        low, high = np.fmin.reduce(cut, axis=1), np.fmax.reduce(cut, axis=1)
    stamp = time[: buckets * width].reshape(buckets, width)[:, 0]
    return np.repeat(stamp, 2), np.stack([low, high], axis=1).ravel()


def _line(axes, time, values, **style):
    axes.plot(*_thin(time, values), **style)


def _mean(values, width):
    """Each value replaced by the mean of its block; NaN remains NaN."""
    whole = len(values) // width * width
    blocks = np.repeat(values[:whole].reshape(-1, width).mean(axis=1), width)
    return np.concatenate([blocks, values[whole:]])


def _gaps(cycles, name, scale):
    """Words of a PDO as float, NaN where there was none."""
    return np.where(cycles.seen, cycles[name] * scale, np.nan)


def _phases(run, axes_list):
    """Background bands for the verbs of the hand, named on the first axes."""
    bands = []
    for verb, first, end in run.segments():
        name = PHASES.get(verb)
        goes_on = bands and bands[-1][2] == first
        if goes_on and (verb == "hold" or name and bands[-1][0] == name[0]):
            bands[-1][2] = end
        elif name:
            bands.append([name[0], first, end, name[1]])
    for label, first, end, colour in bands:
        for axes in axes_list:
            axes.axvspan(first * CYCLE_US / 1e6, end * CYCLE_US / 1e6, color=colour, lw=0, zorder=0)
        axes = axes_list[0]
        axes.margins(y=0.14)
        middle = (first + end) * CYCLE_US / 2e6
        axes.text(middle, 0.985, label, transform=axes.get_xaxis_transform(), ha="center", va="top", fontsize=7.5, color=GREY)
    for fault in run.truth["FAULT"]:
        for axes in axes_list:
            axes.axvline(fault["time_us"] / 1e6, color=RED if fault["active"] else GREEN, lw=0.9, ls=":", zorder=1)


def _finish(figure, axes_list, run, explained):
    """Bands, legends and labels. A legend lies above its plot, at the right, where it covers no curve."""
    _phases(run, axes_list)
    for axes in explained:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.985), ncol=4, borderaxespad=0)
    for axes in axes_list[:-1]:
        axes.tick_params(labelbottom=False)
    axes_list[-1].set_xlabel("simulated time [s]")
    for axes in axes_list:
        axes.set_xlim(0, max(run.count * CYCLE_US / 1e6, 1))
    figure.align_ylabels(axes_list)
    figure.tight_layout()
    return figure


def _stack(rows, height=2.0, **options):
    figure, axes = plt.subplots(rows, 1, figsize=(11, height * rows + 0.6), sharex=True, squeeze=False, **options)
    return figure, list(axes[:, 0])


def states(run):
    """States of all subsystems over time; events and the operator's steps are marked."""
    history = run.states()
    if not history:
        return None
    end = max(run.count * CYCLE_US / 1e6, max(time for changes in history.values() for time, _ in changes))
    names = sorted(history, key=lambda name: run.dictionary.subsystem(name).apid if name in run.dictionary.subsystems else 0)
    figure, axes = plt.subplots(figsize=(11, 1.5 + 0.62 * len(names) + 1.1))
    for row, name in enumerate(names):
        changes = history[name]
        for (start, state), (stop, _) in zip(changes, [*changes[1:], (end, None)]):
            axes.broken_barh([(start, stop - start)], (row - 0.32, 0.64), color=STATE_COLOURS.get(state, GREY), lw=0)
    _mark_events(run, axes, names)
    _mark_steps(run, axes, len(names))
    axes.set_yticks([*range(len(names)), len(names)], [*names, "operator"])
    axes.set_ylim(-0.7, len(names) + 0.6)
    axes.set_xlim(0, end)
    axes.set_xlabel("simulated time [s]")
    axes.grid(axis="y", visible=False)
    used = {state for changes in history.values() for _, state in changes}
    patches = [Patch(color=colour, label=state) for state, colour in STATE_COLOURS.items() if state in used]
    marks = [
        axes.plot([], [], "v", color=colour, ms=6, label=f"{severity} event")[0]
        for severity, colour in SEVERITY_COLOURS.items()
    ]
    figure.legend(handles=[*patches, *marks], loc="lower center", ncol=5, fontsize=7.5)
    figure.suptitle("States, events and the operator's steps", x=0.01, ha="left", fontsize=10, fontweight="bold")
    figure.tight_layout(rect=(0, 0.13, 1, 1))
    return figure


def _mark_events(run, axes, names):
    for time_ns, packet, decoded in sorted(run.reports_of("event"), key=lambda report: report[1].subtype):
        name = run.dictionary.name_of_apid(packet.apid)
        if name not in names:
            continue
        row = names.index(name)
        colour = SEVERITY_COLOURS[decoded["severity"]]
        axes.plot(time_ns / 1e9, row + 0.37, "v", color=colour, mec="white", mew=0.5, ms=7, zorder=5)
        if decoded["severity"] in ("MEDIUM", "HIGH"):
            axes.text(time_ns / 1e9, row + 0.47, decoded["event"], fontsize=6, color=colour, ha="center", va="bottom")


def _mark_steps(run, axes, row):
    for entry in run.operator:
        good = not str(entry.get("outcome", "")).startswith("FAILED")
        axes.plot([entry["time"]] * 2, [row - 0.22, row + 0.22], color=BLUE if good else RED, lw=1.0 if good else 2.2)
        if entry["end"] - entry["time"] > 0.3:
            axes.plot([entry["time"], entry["end"]], [row, row], color=BLUE, lw=2.5, alpha=0.35)


def positions(run):
    """Hand, joystick and joints."""
    if not run.stick_tpdo.seen.any() and not any(tpdo.seen.any() for tpdo in run.joint_tpdo):
        return None
    figure, axes = _stack(4)
    time = _seconds(run.count)
    intent = run.at_cycles("OPERATOR", "intent_rad")
    home = [0.0, 0.0]
    for index in range(2):
        stick = np.degrees(_gaps(run.stick_tpdo, str(index), runs.POSITION_RAD))
        if intent is not None:
            _line(axes[index], time, np.degrees(intent[:, index]), color=ORANGE, label="hand's intent")
        _line(axes[index], time, stick, color=BLUE, label="joystick")
        axes[index].set_ylabel(f"axis {index + 1} [deg]")
        joint = np.degrees(_gaps(run.joint_tpdo[index], "position", runs.POSITION_RAD))
        seen = joint[~np.isnan(joint)]
        home[index] = seen[0] if len(seen) else 0.0
        _line(axes[2 + index], time, home[index] + POSITION_SCALE * stick, color=ORANGE, label="2 x joystick from home")
        _line(axes[2 + index], time, joint, color=BLUE, label="joint (motor side)")
        axes[2 + index].set_ylabel(f"joint {index + 1} [deg]")
    axes[0].set_title("Hand and joystick")
    axes[2].set_title("Joints")
    return _finish(figure, axes, run, axes[:3:2])


def torques(run):
    """Torque felt by the hand against the torque at the joints."""
    if not run.stick_rpdo.seen.any():
        return None
    figure, axes = _stack(4)
    time = _seconds(run.count)
    external = run.at_cycles("CONTACT", "external_torque_nm")
    for index in range(2):
        on = run.stick_rpdo[f"control{index}"] & 0xF == runs.ENABLE_OPERATION
        felt = np.where(on, _gaps(run.stick_rpdo, str(index), runs.STICK_TORQUE_NM), np.nan)
        _line(axes[index], time, felt, color=PALE, lw=0.8, label="felt, each cycle")
        _line(axes[index], time, _mean(felt, 40), color=BLUE, lw=1.2, label="felt, mean of 20 ms")
        if external is not None:
            label = f"{FORCE_SCALE:g} x external joint torque (truth)"
            _line(axes[index], time, FORCE_SCALE * external[:, index], color=ORANGE, label=label, lw=1.2, ls="--")
        axes[index].set_ylabel(f"axis {index + 1} [Nm]")
        raw = _gaps(run.joint_tpdo[index], "torque", runs.JOINT_TORQUE_NM)
        _line(axes[2 + index], time, raw, color=GREEN, label="joint torque sensor", lw=0.9)
        axes[2 + index].set_ylabel(f"joint {index + 1} [Nm]")
    axes[0].set_title("Torque felt by the hand, and what acts on the arm")
    axes[2].set_title("Torque sensors of the joints (with gravity)")
    return _finish(figure, axes, run, axes[:3:2])


def contact(run):
    """Contact and spring force on the finger."""
    force = run.at_cycles("CONTACT", "contact_force_n")
    if force is None:
        return None
    spring = run.at_cycles("CONTACT", "spring_force_n")
    figure, axes = _stack(1, height=2.8)
    time = _seconds(run.count)
    _line(axes[0], time, np.linalg.norm(force, axis=1), color=RED, label="contour")
    _line(axes[0], time, np.linalg.norm(spring, axis=1), color=GREEN, label="spring")
    axes[0].axhline(25, color=GREY, lw=0.8, ls="--")
    axes[0].text(0.3, 25.4, "bound on the contour, 25 N", fontsize=7, color=GREY)
    axes[0].set_ylabel("force on the finger [N]")
    axes[0].set_title("Contact")
    return _finish(figure, axes, run, axes[:1])


def frame_us(length, is_fd):
    """Length of a frame on the bus with usual stuffing [us]: 1 Mbit/s, FD data at 5 Mbit/s."""
    classic = (47 + 8.0 * length) * 1.08
    fd = 30 * 1.08 + (31 + 8.0 * length) * 1.08 / 5
    return np.where(is_fd, fd, classic)


def bus_load(run):
    """Share of time in which the buses are busy, in steps of 0.1 s."""
    if not len(run.robot) and not len(run.joystick):
        return None
    figure, axes = _stack(1, height=2.6)
    edges = np.arange(0, run.count * CYCLE_US + 100_000, 100_000)
    for bus, name, colour in ((run.robot, "robot", BLUE), (run.joystick, "joystick", ORANGE)):
        if len(bus):
            load, _ = np.histogram(bus.time_us, edges, weights=frame_us(bus.length, bus.is_fd))
            axes[0].step(edges[:-1] / 1e6, load / 1000.0, where="post", color=colour, label=name)
    axes[0].set_ylim(0, 100)
    axes[0].set_ylabel("bus load [%]")
    axes[0].set_title("Load of the buses (frame lengths with usual stuffing)")
    return _finish(figure, axes, run, axes[:1])


def link_ages(run):
    """Age of the link samples that the members used, from housekeeping."""
    found = {}
    for _, packet, decoded in run.reports_of("housekeeping"):
        if "LINK_AGE" in decoded["values"]:
            points = found.setdefault(run.dictionary.name_of_apid(packet.apid), [])
            points.append(((packet.time_ns - run.dictionary.epoch_ns) / 1e9, decoded["values"]["LINK_AGE"][0]))
    if not found:
        return None
    figure, axes = _stack(1, height=2.6)
    for (name, points), colour in zip(sorted(found.items()), (BLUE, ORANGE, GREEN, VIOLET)):
        time, age = np.array(points, float).T
        axes[0].plot(time, np.minimum(age, 1e5) / 1000.0, "o", ms=2.6, color=colour, label=f"read by {name}")
    axes[0].axhline(2.0, color=GREY, lw=0.8, ls="--")
    axes[0].text(0.3, 2.05, "stale", fontsize=7, color=GREY)
    top = max(2.6, min(6.0, max(age for points in found.values() for _, age in points) / 1000.0 * 1.1))
    axes[0].set_ylim(0, top)
    axes[0].set_ylabel("age [ms]")
    axes[0].set_title("Age of the real-time link samples (housekeeping)")
    return _finish(figure, axes, run, axes[:1])


def key_moments(run):
    """(title, cycle) of each moment in the picture of the scene."""
    segments = run.segments()
    moments = []

    def middle(verb, title, after=None, share=0.5):
        seen = after is None
        for name, first, end in segments:
            if seen and name == verb:
                moments.append((title, int(first + share * (end - 1 - first))))
                return
            seen = seen or name == after

    joints = run.at_cycles("JOINTS", "position_rad")
    if joints is None:
        return []
    moments.append(("at home", 0))
    middle("circle", "free space: circle", share=0.55)
    middle("follow", "following the contour")
    middle("hold", "holding on the contour", after="follow")
    middle("hold", "holding the spring", after="pull")
    for fault in run.truth["FAULT"]:
        if fault["kind"] == "unplug" and fault["active"] and len(moments) < 6:
            cycle = min(fault["time_us"] // CYCLE_US + 200, run.count - 1)
            moments.append((f"unplugged: {fault['target']}", int(cycle)))
    if len(moments) == 1:
        moments.append(("at the end", len(joints) - 1))
    return [(title, cycle) for title, cycle in moments if not np.isnan(joints[cycle]).any()]


def pictures(run):
    """The robot in its scene at the key moments."""
    moments = key_moments(run)
    if not moments:
        return None
    columns = min(3, len(moments))
    rows = -(-len(moments) // columns)
    figure, grid = plt.subplots(rows, columns, figsize=(3.9 * columns, 2.95 * rows), squeeze=False)
    joints, tip = run.at_cycles("JOINTS", "position_rad"), run.at_cycles("CONTACT", "tip_m")
    brake = run.at_cycles("JOINTS", "brake_engaged")
    contact_n, spring_n = run.at_cycles("CONTACT", "contact_force_n"), run.at_cycles("CONTACT", "spring_force_n")
    hooked = run.at_cycles("CONTACT", "spring_hooked")
    figure.tight_layout()
    for axes, (title, cycle) in zip(grid.ravel(), moments):
        scene.frame(axes, f"{title}, {cycle * CYCLE_US / 1e6:.1f} s")
        figure.canvas.draw()
        force = contact_n[cycle] + spring_n[cycle] if contact_n is not None else np.zeros(3)
        trace = tip[max(0, cycle - 6000) : cycle + 1 : 10, [0, 2]] if tip is not None else None
        is_hooked = hooked is not None and hooked[cycle] > 0
        scene.draw(axes, joints[cycle], trace, force[[0, 2]], is_hooked, bool(brake[cycle].any()))
        if np.hypot(force[0], force[2]) > 0.5:
            axes.text(0.485, 0.275, f"{np.hypot(force[0], force[2]):.1f} N", ha="right", fontsize=8, color=scene.FORCE)
    for axes in grid.ravel()[len(moments) :]:
        axes.set_visible(False)
    figure.tight_layout()
    return figure


PLOTS = (
    ("scene", "The robot in its scene", pictures),
    ("states", "States, events and the operator's steps", states),
    ("positions", "Hand, joystick and joints", positions),
    ("torques", "What the hand feels, and what acts on the arm", torques),
    ("contact", "Contact force", contact),
    ("links", "Age of the link samples", link_ages),
    ("bus_load", "Load of the buses", bus_load),
)
