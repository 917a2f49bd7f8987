# SPDX-License-Identifier: Apache-2.0
"""The figures of a telepresence flight, computed from the raw logs: buses, truth and packets.

Each function of a table takes a Run and returns a dict of named figures. If the logs do not contain the data, it raises
Missing: compute() then makes these figures None and returns the reason. A run fails if one of its bounds is for such a figure.
"""

import itertools
import pathlib

import numpy as np

from . import arm_figures, contact_figures, delay_figures, figure_bounds, tool_figures
from . import run as runs
from .figures_common import HOLD_LEAST_US, HOLD_US, SETTLED_US, Missing, filled, force_scale, position_scale, segment, setting, telecommanded
from .run import CYCLE_US, ENABLE_OPERATION, OPERATION_ENABLED, STATE_MASK

CIRCLE_PERIODS = 4  # Maximum number of periods of the circle that are evaluated.
ROWS_LEAST = 1000  # Minimum number of cycles in a fit.
SIGNIFICANT = 6.0  # Smallest significance of a latency [standard deviations].
SMALLEST_TORQUE_NM = 2.0  # A joint with a smaller external torque is not evaluated.
BRAKE_WATCH_US, ENGAGE_WATCH_US, UNPLUG_WATCH_US = 500_000, 10_000, 1_000_000
FORWARD_LAGS, LOOP_LAGS = range(-3, 30), range(12)
BACK_LAGS, DAMPING_LAGS = range(-3, 8), range(50)
FINE_COUNT_RAD = 2e-5  # an encoder of 20 bit has 6e-6, one of 16 bit 9.6e-5

# Bounds of the scenario telepresence.
BOUNDS = {
    "latency_forward_cycles": ("<=", 2),
    "latency_back_cycles": ("<=", 2),
    "tracking_error": ("<", 0.01),
    "reflection_error": ("<", 0.01),
    "reflection_error_contour": ("<", 0.01),
    "hold_motion_rad": ("<", 0.001),
    "contact_share": (">=", 0.99),
    "contact_force_max_n": ("<=", 25),
    "brake_drop_rad": ("<", 0.001),
    "engagement_step_rad": ("<", 0.001),
    "link_lost": ("<=", 0),
    "unplug_reaction_s": ("<=", 0.005),
    "torque_limit_reaction_cycles": ("<=", 2),
    "free_drag_nm": ("<=", 0.015),
    "press_ripple_nm": ("<=", 0.5),
    "passivity_local_j": (">=", -1e-4),
}
# Bounds of the scenario press.
PRESS_BOUNDS = {
    "press_hold_oscillation_rad": ("<=", 2e-4),
    "press_hold_motion_rad": ("<=", 1e-4),
    "hold_force_ripple_nm": ("<=", 5e-3),
    "hold_contact_share": (">=", 0.99),
    "hold_force_peak": ("<=", 1.1),
    "hold_energy_j": (">=", -5e-5),
    "dynamic_transparency": ("<=", 0.07),
    "passivity_local_j": (">=", -1e-4),
}
# Bounds of the scenario press with an encoder of 16 bits. The damping turns one count into a torque spike, so the
# joystick oscillates within one count.
COARSE_BOUNDS = {
    "press_hold_motion_rad": ("<=", 2e-4),
    "hold_force_ripple_nm": ("<=", 0.06),
    "hold_energy_j": (">=", -6e-3),
    "passivity_local_j": (">=", -6e-3),
}


def _hold_window(run, before):
    """Window of the last 10 s of the hold after a verb; it begins at the earliest 2 s after the intended position has stopped
    changing, and has at least 5 s."""
    first, end = segment(run, "hold", before)
    intent = run.at_cycles("OPERATOR", "intent_rad")[first:end]
    moving = np.flatnonzero(np.abs(np.diff(intent, axis=0)).max(axis=1) > 1e-9)
    still = first + (int(moving[-1]) + 1 if len(moving) else 0)
    start = max(still + SETTLED_US // CYCLE_US, end - HOLD_US // CYCLE_US)
    if end - start < HOLD_LEAST_US // CYCLE_US:
        raise Missing(f"the hold after '{before}' is at rest for {max(0, end - start) * CYCLE_US / 1e6:.1f} s, expected at least {HOLD_LEAST_US / 1e6:g} s")
    return start, end


def _spring_window(run):
    return _hold_window(run, "pull")


def _contour_window(run):
    return _hold_window(run, "follow")


def _robot_command(run, joint, start, end):
    """Commanded values of a joint in a window: torque in CST, position in CSP."""
    cst, csp = run.joint_cst[joint], run.joint_csp[joint]
    if cst.seen[start:end].sum() >= csp.seen[start:end].sum():
        return filled(cst, "torque", start, end)
    return filled(csp, "position", start, end)


def _free_space(run):
    """Window from the start of the circle to the end of the last free segment before contact."""
    first, end = segment(run, "circle", None)
    touch = np.flatnonzero(run.at_cycles("CONTACT", "in_contact")[first:] > 0)
    limit = first + int(touch[0]) if len(touch) else run.count
    following = [item for item in run.segments() if item[1] >= end and item[0] in ("move", "rest", "home")]
    return first, min(limit, following[0][2] if following else end)


def _increments(values):
    return np.diff(values.astype(float), prepend=float(values[0]))


def _response(answer, cause, lags, others):
    """Least-squares fit of `answer` to the signal `cause` at each of its lags and to all `others`, each (signal, lags).

    Returns for each lag of the cause its weight (absolute value) and the significance of this weight in standard deviations.
    """
    parts = [(cause, lags), *others]
    first = max(max(steps) for _, steps in parts)
    rows = np.arange(first, len(answer) + min(0, min(lags)))
    if len(rows) < ROWS_LEAST:
        raise Missing(f"found {len(rows)} cycles, expected at least {ROWS_LEAST}")
    matrix = np.stack([signal[rows - lag] for signal, steps in parts for lag in steps], axis=1)
    inverse = np.linalg.pinv(matrix.T @ matrix, hermitian=True)
    found = inverse @ (matrix.T @ answer[rows])
    variance = np.mean((answer[rows] - matrix @ found) ** 2) * np.diag(inverse)
    size = len(lags)
    return np.abs(found[:size]), np.abs(found[:size]) / np.sqrt(np.maximum(variance[:size], 1e-30))


def _clear_lag(answers, lags, name):
    """The lag whose weight, summed over both axes, is clearly the largest: (lag, least significance of an axis)."""
    weights = sum(weights for weights, _ in answers)
    best = int(np.argmax(weights))
    rest = float(np.delete(weights, best).max())
    sure = float(min(significance[best] for _, significance in answers))
    if weights[best] < 2 * rest or sure <= SIGNIFICANT:
        raise Missing(f"no clear answer to {name}: {weights[best]:.3f} at lag {list(lags)[best]}, {rest:.3f} elsewhere")
    return list(lags)[best], sure


def latency_forward(run):
    """Latency from joystick sample to robot command, measured on the buses in free space; the counts of the encoder are the
    excitation.

    The fit contains the increments of the joint's own sensors, to separate the response of the joint's loop.
    """
    start, end = _free_space(run)
    answers = []
    for axis in range(2):
        stick = _increments(filled(run.stick_tpdo, str(axis), start, end))
        joint = [_increments(filled(run.joint_tpdo[axis], name, start, end)) for name in ("position", "torque")]
        command = _increments(_robot_command(run, axis, start, end))
        answers.append(_response(command, stick, FORWARD_LAGS, [(signal, LOOP_LAGS) for signal in joint]))
    lag, sure = _clear_lag(answers, FORWARD_LAGS, "encoder counts")
    return {"latency_forward_cycles": lag, "latency_forward_significance": sure}


def latency_back(run):
    """Latency from joint torque sample to joystick torque command, measured on the buses with the sensor's noise as excitation.

    The fit contains the increments of the joystick's own position, to separate the response of the damping.
    """
    start, end = _spring_window(run)
    answers = []
    for axis in range(2):
        felt = _increments(filled(run.stick_rpdo, str(axis), start, end))
        torque = _increments(filled(run.joint_tpdo[axis], "torque", start, end))
        stick = _increments(filled(run.stick_tpdo, str(axis), start, end))
        answers.append(_response(felt, torque, BACK_LAGS, [(stick, DAMPING_LAGS)]))
    lag, sure = _clear_lag(answers, BACK_LAGS, "torque noise")
    return {"latency_back_cycles": lag, "latency_back_significance": sure}


def joystick_count(run):
    """Resolution of the joystick's encoder: the smallest step of its position."""
    steps = np.abs(np.concatenate([np.diff(run.stick_tpdo[str(axis)][run.stick_tpdo.seen]) for axis in range(2)]))
    if not steps.any():
        raise Missing("the joystick did not move")
    return {"joystick_count_rad": float(steps[steps > 0].min() * runs.POSITION_RAD)}


def _circle_window(run):
    """(first cycle, end cycle, frequency [Hz]) of the last three or four whole periods of constant amplitude."""
    first, end = segment(run, "circle", None)
    intent = run.at_cycles("OPERATOR", "intent_rad")[first:end]
    away = intent - intent[0]
    radius = np.hypot(away[:, 0], away[:, 1])
    steady = np.flatnonzero(radius > 0.995 * radius.max())
    if radius.max() < 0.02 or len(steady) < 100:
        raise Missing("the circle has no part of constant amplitude")
    angle = np.unwrap(np.arctan2(away[steady[0] : steady[-1] + 1, 1], away[steady[0] : steady[-1] + 1, 0]))
    turns = abs(angle[-1] - angle[0]) / (2 * np.pi)
    periods = min(CIRCLE_PERIODS, int(turns + 1e-3))
    if periods < 3:
        raise Missing(f"found {turns:.1f} periods of constant amplitude, expected at least 3")
    length = round(len(angle) / turns * periods)
    last = first + int(steady[-1]) + 1
    return last - length, last, turns * 1e6 / (len(angle) * CYCLE_US)


def _best_lag(reference, signal, start, end):
    """(error, lag) of signal(k + lag) relative to reference(k), after their means are subtracted."""
    cycles = np.arange(start, end)
    wanted = reference[start:end] - reference[start:end].mean()
    best = (np.inf, 0.0)
    for lag in np.arange(-8, 12.25, 0.5):
        shifted = np.interp(cycles + lag, np.arange(len(signal)), signal)
        error = shifted - shifted.mean() - wanted
        best = min(best, (float(np.sqrt(np.mean(error**2) / np.mean(wanted**2))), float(lag)))
    return best


def tracking(run):
    """Free-space tracking error at constant amplitude after removal of the best lag; motor side and true link."""
    start, end, frequency = _circle_window(run)
    low, high = max(0, start - 20), min(run.count, end + 20)
    worst, worst_link = (0.0, 0.0), 0.0
    link = run.at_cycles("JOINTS", "position_rad")
    scale = position_scale(run)
    for joint in range(2):
        stick = filled(run.stick_tpdo, str(joint), low, high) * runs.POSITION_RAD
        motor = filled(run.joint_tpdo[joint], "position", low, high) * runs.POSITION_RAD
        reference = scale * stick
        worst = max(worst, _best_lag(reference, motor, start - low, end - low))
        if link is not None:
            truth = link[low:high, joint]
            worst_link = max(worst_link, _best_lag(reference, truth, start - low, end - low)[0])
    return {
        "tracking_error": worst[0],
        "tracking_lag_cycles": worst[1],
        "tracking_error_link": worst_link,
        "tracking_frequency_hz": round(frequency, 4),
        "tracking_periods": (end - start) * CYCLE_US * frequency / 1e6,
    }


def free_drag(run):
    """Torque that the hand has to apply in free space: rms in the circle of constant amplitude."""
    start, end, _ = _circle_window(run)
    felt = [filled(run.stick_rpdo, str(axis), start, end) * runs.STICK_TORQUE_NM for axis in range(2)]
    return {"free_drag_nm": float(max(np.sqrt(np.mean(torque**2)) for torque in felt))}


def _reflection(run, window):
    """Errors of the reflected torque relative to the truth, the largest of both axes: of its mean in the window, and of its mean
    in any second of the window."""
    start, end = window
    scale = force_scale(run)
    external = run.at_cycles("CONTACT", "external_torque_nm")[start:end] * scale
    worst, block = None, 0.0
    for axis in range(2):
        expected = external[:, axis]
        if abs(expected.mean()) / scale < SMALLEST_TORQUE_NM:
            continue
        felt = filled(run.stick_rpdo, str(axis), start, end) * runs.STICK_TORQUE_NM
        worst = max(worst or 0.0, float(abs(felt.mean() - expected.mean()) / abs(expected.mean())))
        size = 1_000_000 // CYCLE_US
        for at in range(0, len(felt) - size + 1, size):
            part = slice(at, at + size)
            block = max(block, float(abs(felt[part].mean() - expected[part].mean()) / abs(expected[part].mean())))
    if worst is None:
        raise Missing(f"no axis with {SMALLEST_TORQUE_NM} Nm of external joint torque in the hold")
    return worst, block


def reflection(run):
    """Error of the mean reflected torque relative to the truth while the spring is held."""
    worst, block = _reflection(run, _spring_window(run))
    return {"reflection_error": worst, "reflection_error_1s": block}


def reflection_contour(run):
    """Error of the mean reflected torque relative to the truth while the contour is held."""
    worst, block = _reflection(run, _contour_window(run))
    return {"reflection_error_contour": worst, "reflection_error_contour_1s": block}


def hold_motion(run):
    """Joystick motion in the holds, peak to peak."""
    spans = {}
    for name, window in (("spring", _spring_window(run)), ("contour", _contour_window(run))):
        positions = [filled(run.stick_tpdo, str(axis), *window) for axis in range(2)]
        spans[name] = float(max(np.ptp(position) for position in positions) * runs.POSITION_RAD)
    return {
        "hold_motion_rad": max(spans.values()),
        "hold_motion_spring_rad": spans["spring"],
        "hold_motion_contour_rad": spans["contour"],
    }


def contact(run):
    """Share of the time with contact while following and holding; largest contact force from the beginning of the press to the end of the hold."""
    touched = run.at_cycles("CONTACT", "in_contact")
    if touched is None:
        raise Missing("the truth log has no channel CONTACT")
    press, _ = segment(run, "press", None)
    follow, _ = segment(run, "follow", "press")
    _, hold_end = segment(run, "hold", "follow")
    force = np.linalg.norm(run.at_cycles("CONTACT", "contact_force_n")[press:hold_end], axis=1)
    return {
        "contact_share": float(np.nanmean(touched[follow:hold_end] > 0)),
        "contact_force_max_n": float(np.nanmax(force)),
    }


def _drives(run):
    """Dict (bus, node, axis) -> entries of this drive in the truth log, in order."""
    found = {}
    for entry in run.truth["DRIVE"]:
        found.setdefault((entry["bus"], entry["node"], entry["axis"]), []).append(entry)
    return found


def _is_enabled(entry):
    return entry["statusword"] & STATE_MASK == OPERATION_ENABLED


def brake_drop(run):
    """Largest motion of the arm's links in the 0.5 s after a joint drive has left operation-enabled, or until it is enabled again."""
    link = run.at_cycles("JOINTS", "position_rad")
    if link is None:
        raise Missing("the truth log has no channel JOINTS")
    worst, count = 0.0, 0
    for (bus, _, _), entries in _drives(run).items():
        if bus not in {joint.bus for joint in run.joints}:
            continue
        for number, (before, after) in enumerate(itertools.pairwise(entries)):
            if not _is_enabled(before) or _is_enabled(after):
                continue
            again = next((e["time_us"] for e in entries[number + 2 :] if _is_enabled(e)), np.inf)
            end = int(min(after["time_us"] + BRAKE_WATCH_US, again, (run.count - 1) * CYCLE_US)) // CYCLE_US
            start = after["time_us"] // CYCLE_US
            if end <= start:
                continue
            count += 1
            part = link[start : end + 1]
            worst = max(worst, float(np.nanmax(np.abs(part - part[0]))))
    if not count:
        raise Missing("no joint drive left operation-enabled")
    return {"brake_drop_rad": worst, "brake_engagements": count}


def _position_step(run, joint, at):
    """Position mode: difference between the first effective target, within three cycles, and the drive's position before; None in
    torque mode."""
    csp = run.joint_csp[joint]
    commanded = csp.seen[at : at + 3] & (csp["control"][at : at + 3] & 0xF == ENABLE_OPERATION)
    if not commanded.any():
        return None
    first = at + int(np.argmax(commanded))
    return abs(csp["position"][first] - run.joint_tpdo[joint]["position"][at - 1]) * runs.POSITION_RAD


def _torque_step(run, joint, at):
    """Torque mode: difference between the first command and the torque that the brake held, converted to a position. The first
    command is at most three cycles before or after `at`; the torque held is the median of the 20 cycles before."""
    cst = run.joint_cst[joint]
    enabling = np.flatnonzero(cst.seen[at - 3 : at + 3] & (cst["control"][at - 3 : at + 3] & 0xF == ENABLE_OPERATION))
    if not len(enabling):
        return 0.0
    held = np.median(run.joint_tpdo[joint]["torque"][max(0, at - 20) : at])
    stiffness = setting(run, "MANIPULATOR", "CONTROL", "KP")[joint]
    return abs(cst["torque"][at - 3 + int(enabling[0])] - held) * runs.JOINT_TORQUE_NM / stiffness


def engagement_step(run):
    """Step of the joint command when a drive is enabled, and the motion of the motor within 10 ms after it.

    In position mode the command is on the bus; in torque mode the torque step is converted to a position step by
    the stiffness of the joint's control loop. A later motion is not a step, because the arm then follows the hand and its load.
    """
    worst, count = 0.0, 0
    for joint in range(2):
        tpdo = run.joint_tpdo[joint]
        enabled = tpdo.seen & (tpdo["status"] & STATE_MASK == OPERATION_ENABLED)
        for at in np.flatnonzero(enabled[1:] & ~enabled[:-1] & tpdo.seen[:-1]) + 1:
            count += 1
            step = _position_step(run, joint, at)
            watch = slice(at, at + ENGAGE_WATCH_US // CYCLE_US)
            motion = np.abs(tpdo["position"][watch][enabled[watch]] - tpdo["position"][at - 1]).max() * runs.POSITION_RAD
            worst = max(worst, float(motion), float(_torque_step(run, joint, at) if step is None else step))
    if not count:
        raise Missing("no joint drive was enabled")
    return {"engagement_step_rad": worst, "engagements": count}


def link_lost(run):
    """Lost samples of all links, from the last TM[130,9] of each link and the members' counters."""
    status = {}
    for _, packet, decoded in run.reports_of("links"):
        for row in decoded["rows"]:
            status[packet.apid, row["link"]] = max(row["lost"], status.get((packet.apid, row["link"]), 0))
    counted = {}
    for _, packet, decoded in run.reports_of("housekeeping"):
        for members in decoded["values"].values():
            if isinstance(members, dict) and "LINK_LOST" in members:
                counted[packet.apid] = max(counted.get(packet.apid, 0), sum(members["LINK_LOST"]))
    if not status and not counted:
        raise Missing("no report on links (TM[130,9] or counters in housekeeping)")
    return {"link_lost": max(sum(status.values()), sum(counted.values()))}


def _times_left(drives, cut):
    """Time at which each drive that was enabled when a node was unplugged, at the time `cut`, left operation-enabled; None if it did not."""
    left = []
    for entries in drives.values():
        before = [entry for entry in entries if entry["time_us"] <= cut]
        # The entry that the device writes at the cut may have the same time.
        running = [entry for entry in before if entry["time_us"] < cut] or before
        if running and _is_enabled(running[-1]):
            after = (e["time_us"] for e in entries if e["time_us"] >= cut and not _is_enabled(e))
            left.append(next(after, None))
    return left


def unplug(run):
    """Largest time from the unplug of a node until the last drive of the network leaves operation-enabled."""
    drives, worst, count = _drives(run), 0.0, 0
    for fault in run.truth["FAULT"]:
        if fault["kind"] != "unplug" or not fault["active"]:
            continue
        cut = fault["time_us"]
        left = _times_left(drives, cut)
        if not left:
            continue
        count += 1
        if None in left or max(left) - cut > UNPLUG_WATCH_US:
            raise Missing(f"a drive stayed enabled after the unplug at {cut / 1e6:.3f} s")
        worst = max(worst, (max(left) - cut) / 1e6)
    if not count:
        raise Missing("nothing was unplugged while a drive was enabled")
    return {"unplug_reaction_s": worst, "unplugs": count, "unplug_members_reported": _members_reported(run)}


def _members_reported(run):
    """True if every member reported ERROR_OPERATIONAL (TM[129,2]) within 0.1 s after each unplug."""
    cuts = [fault["time_us"] for fault in run.truth["FAULT"] if fault["kind"] == "unplug" and fault["active"]]
    members = {packet.apid for _, packet, _ in run.reports_of("link transition")}
    for cut in cuts:
        reported = {
            packet.apid
            for time_ns, packet, decoded in run.reports_of("transition")
            if decoded["state"] == "ERROR_OPERATIONAL" and cut <= time_ns // 1000 <= cut + 100_000
        }
        if not members or not members <= reported:
            return False
    return bool(cuts)


def _limits(run):
    """Telecommanded torque limits: list of (time_us, [Nm, Nm])."""
    return [(time_us, value) for time_us, _, parameter, value in telecommanded(run) if parameter.name == "TORQUE_LIMIT"]


def torque_limit(run):
    """Time from the first measured torque beyond the telecommanded limit to the first controlword other than 0x0F."""
    worst, count = None, 0
    limits = _limits(run)
    for number, (time_us, limit) in enumerate(limits):
        end = limits[number + 1][0] if number + 1 < len(limits) else run.count * CYCLE_US
        window = slice(time_us // CYCLE_US + 1, end // CYCLE_US)
        over = np.zeros(window.stop - window.start, bool)
        left = np.zeros_like(over)
        for joint in range(2):
            tpdo = run.joint_tpdo[joint]
            enabled = tpdo["status"][window] & STATE_MASK == OPERATION_ENABLED
            torque = np.abs(tpdo["torque"][window]) * runs.JOINT_TORQUE_NM
            over |= tpdo.seen[window] & enabled & (torque > limit[joint])
            for rpdo in (run.joint_cst[joint], run.joint_csp[joint]):
                left |= rpdo.seen[window] & (rpdo["control"][window] & 0xF != ENABLE_OPERATION)
        if not over.any():
            continue
        first = int(np.argmax(over))
        after = np.flatnonzero(left[first:])
        if not len(after):
            raise Missing("the torque limit was exceeded without an answer")
        count += 1
        worst = max(worst or 0, int(after[0]))
    if worst is None:
        raise Missing("no telecommanded torque limit was exceeded")
    return {"torque_limit_reaction_cycles": worst, "torque_limits_exceeded": count}


ALWAYS = ((joystick_count, ("joystick_count_rad",)), (contact_figures.passivity, ("passivity_local_j",)))
FIGURES = (
    (latency_forward, ("latency_forward_cycles",)),
    (latency_back, ("latency_back_cycles",)),
    (tracking, ("tracking_error",)),
    (reflection, ("reflection_error",)),
    (reflection_contour, ("reflection_error_contour",)),
    (hold_motion, ("hold_motion_rad",)),
    (contact, ("contact_share", "contact_force_max_n")),
    (brake_drop, ("brake_drop_rad",)),
    (engagement_step, ("engagement_step_rad",)),
    (link_lost, ("link_lost",)),
    (unplug, ("unplug_reaction_s",)),
    (torque_limit, ("torque_limit_reaction_cycles",)),
    (free_drag, ("free_drag_nm",)),
    (contact_figures.press_ripple, ("press_ripple_nm",)),
    (contact_figures.follow_transparency, ("follow_transparency",)),
    *ALWAYS,
)
PRESS_FIGURES = (
    (
        contact_figures.press_hold,
        (
            "press_hold_oscillation_rad",
            "press_hold_motion_rad",
            "hold_force_ripple_nm",
            "hold_contact_share",
            "hold_force_peak",
            "hold_energy_j",
        ),
    ),
    (contact_figures.dynamic_transparency, ("dynamic_transparency",)),
    *ALWAYS,
)


def scenario_of(facts):
    """Name of the scenario flown, without directories and ending."""
    return pathlib.Path(str(facts.get("scenario", ""))).stem


def _press_bounds(facts):
    is_coarse = (facts.get("joystick_count_rad") or 1.0) > FINE_COUNT_RAD
    return {**PRESS_BOUNDS, **COARSE_BOUNDS} if is_coarse else PRESS_BOUNDS


# By mission and scenario: the functions with the names of their figures, and the bounds of a run with these facts.
TABLES = {
    ("rokviss", "telepresence"): (FIGURES, lambda facts: BOUNDS),
    ("rokviss", "press"): (PRESS_FIGURES, _press_bounds),
    ("rokviss", "relay"): (delay_figures.FIGURES, delay_figures.bounds_of),
    ("ur5e-telepresence", "ur5e-telepresence"): (tool_figures.FIGURES, lambda facts: tool_figures.BOUNDS),
}
# Figures of the other scenarios of a mission; they have bounds only if there is a file of bounds (figure_bounds.py).
OTHERS = {"rokviss": FIGURES, "classic": FIGURES}
KNOWN = (*FIGURES, *PRESS_FIGURES, *delay_figures.FIGURES, *tool_figures.FIGURES)


def _unknown(_):
    return {}


def _table(facts):
    mission = str(facts.get("mission", ""))
    own = TABLES.get((mission, scenario_of(facts)))
    if own:
        return own
    bounds = figure_bounds.of(facts)
    functions = dict((*OTHERS.get(mission, ()), *((one, names) for one, names in KNOWN if set(names) & set(bounds)), *arm_figures.figures_of(bounds)))
    unknown = set(bounds).difference(*functions.values())
    return (*functions.items(), *([(_unknown, sorted(unknown))] if unknown else [])), lambda facts: bounds


def bounds_of(facts):
    """Dict name -> (relation, bound) of the figures by which a run is judged; empty for most missions and scenarios."""
    return _table(facts)[1](facts)


def compute(run):
    """(figures, reasons): every figure by name, None with a reason if the logs do not contain its data."""
    figures, reasons = {}, {}
    for function, names in _table(run.facts)[0]:
        try:
            found = function(run)
            reasons.update(dict.fromkeys(set(names) - set(found), "no function computes a figure of this name for this flight"))
            reasons.update({name: "the logs give no finite number" for name, value in found.items() if value is not None and not np.isfinite(value)})
            figures.update({name: value for name, value in found.items() if name not in reasons})
        except Missing as problem:
            reasons.update(dict.fromkeys(names, str(problem)))
        except (LookupError, ValueError, TypeError, AttributeError, ArithmeticError, np.linalg.LinAlgError) as problem:
            reasons.update(dict.fromkeys(names, f"{type(problem).__name__}: {problem}"))
    return {**dict.fromkeys(reasons), **figures}, reasons


def holds(name, value, bounds=BOUNDS):
    """True if a figure is within its bound; False also for None."""
    relation, bound = bounds[name]
    if value is None:
        return False
    return {"<": value < bound, "<=": value <= bound, ">=": value >= bound}[relation]


def failures(facts):
    """A line for each figure of a run that is missing or out of its bound. In a run that was ended early figures may be missing."""
    lines = []
    for name, (relation, bound) in (bounds := bounds_of(facts)).items():
        value = facts.get(name)
        if not holds(name, value, bounds) and not (value is None and facts.get("cut_short")):
            found = f"{value:.4g}" if value is not None else f"missing: {facts.get('figures_missing', {}).get(name, '?')}"
            lines.append(f"{name} {relation} {bound:g}: {found}")
    return lines
