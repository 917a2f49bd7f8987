# SPDX-License-Identifier: Apache-2.0
"""The figures of a telepresence flight, computed from the raw logs: buses, truth and packets.

Every function takes a Run and returns a dict of named figures; a figure that cannot be computed is None (a
flight whose table requires it has then failed), and "why" names the reason.
"""

import itertools

import numpy as np

from . import run as runs
from .run import CYCLE_US, ENABLE_OPERATION, OPERATION_ENABLED, STATE_MASK

POSITION_SCALE = 2.0  # joint angle per joystick angle
FORCE_SCALE = 0.03  # joystick torque per external joint torque
CIRCLE_PERIODS = 4
HOLD_US, SETTLED_US, HOLD_LEAST_US = 10_000_000, 2_000_000, 5_000_000
TICKS_LEAST, TICK_GAP, TICK_CLEAR = 100, 4, 40
ROWS_LEAST = 1000
SIGNIFICANT = 6.0  # standard deviations
SMALLEST_TORQUE_NM = 2.0
BRAKE_WATCH_US, ENGAGE_WATCH_US, UNPLUG_WATCH_US = 500_000, 10_000, 1_000_000
JOINT_STIFFNESS_NM_RAD = 4000.0  # of the joint loop in torque mode
FORWARD_LAGS, BACK_LAGS = range(-3, 6), range(-3, 8)

BOUNDS = {
    "latency_forward_cycles": ("<=", 2),
    "latency_back_cycles": ("<=", 2),
    "tracking_error": ("<", 0.01),
    "reflection_error": ("<", 0.01),
    "reflection_error_contour": ("<", 0.02),
    "hold_motion_rad": ("<", 0.001),
    "contact_share": (">=", 0.99),
    "contact_force_max_n": ("<=", 25),
    "brake_drop_rad": ("<", 0.001),
    "engagement_step_rad": ("<", 0.001),
    "link_lost": ("<=", 0),
    "unplug_reaction_s": ("<=", 0.005),
    "torque_limit_reaction_cycles": ("<=", 2),
}


class Missing(Exception):
    """The logs do not contain the data for a figure."""


def _segment(run, verb, before):
    """(first, end) cycle of the first segment `verb` that comes later than a segment of one of `before`."""
    seen = before is None
    for name, first, end in run.segments():
        if name == verb and seen:
            return first, end
        seen = seen or (before is not None and name == before)
    raise Missing(f"the hand never did '{verb}'" + (f" after '{before}'" if before else ""))


def _hold_window(run, before):
    """Last 10 s of the hold after a verb, from 2 s after the intended position stops changing."""
    first, end = _segment(run, "hold", before)
    intent = run.at_cycles("OPERATOR", "intent_rad")[first:end]
    moving = np.flatnonzero(np.abs(np.diff(intent, axis=0)).max(axis=1) > 1e-9)
    still = first + (int(moving[-1]) + 1 if len(moving) else 0)
    start = max(still + SETTLED_US // CYCLE_US, end - HOLD_US // CYCLE_US)
    if end - start < HOLD_LEAST_US // CYCLE_US:
        raise Missing(f"the hold after '{before}' is too short: {max(0, end - start) * CYCLE_US / 1e6:.1f} s")
    return start, end


def _spring_window(run):
    return _hold_window(run, "pull")


def _contour_window(run):
    return _hold_window(run, "follow")


def _filled(cycles, name, start, end):
    """Words of a PDO in a window, a missing word replaced by the one before; Missing if there are gaps."""
    seen = cycles.seen[start:end]
    if not len(seen) or seen.mean() < 0.999:
        raise Missing(f"PDOs are missing between {start * CYCLE_US / 1e6:.1f} and {end * CYCLE_US / 1e6:.1f} s")
    index = np.maximum.accumulate(np.where(seen, np.arange(len(seen)), 0))
    return cycles[name][start:end][index]


def _robot_word(run, joint, start, end):
    """Command word of a joint in a window: torque in CST, position in CSP."""
    cst, csp = run.joint_cst[joint], run.joint_csp[joint]
    if cst.seen[start:end].sum() >= csp.seen[start:end].sum():
        return _filled(cst, "torque", start, end)
    return _filled(csp, "position", start, end)


def _ticks(position):
    """Increments larger than half an encoder count, else 0."""
    step = np.diff(position, prepend=position[:1]) * runs.POSITION_RAD
    return np.where(np.abs(step) > runs.COUNT_RAD / 2, np.sign(step), 0.0)


def _alone(ticks, gap):
    """Cycles with a tick and no other tick within `gap` cycles before and after."""
    count = np.convolve(ticks != 0, np.ones(2 * gap + 1), "same")
    return np.flatnonzero((ticks != 0) & (count == 1))


def _free_space(run):
    """From the start of the circle to the end of the last free segment before contact."""
    first, end = _segment(run, "circle", None)
    touch = np.flatnonzero(run.at_cycles("CONTACT", "in_contact")[first:] > 0)
    limit = first + int(touch[0]) if len(touch) else run.count
    following = [item for item in run.segments() if item[1] >= end and item[0] in ("move", "rest", "home")]
    return first, min(limit, following[0][2] if following else end)


def latency_forward(run):
    """Joystick sample to robot command, on the buses."""
    start, end = _free_space(run)
    jumps = {lag: [] for lag in FORWARD_LAGS}
    for axis in range(2):
        ticks = _ticks(_filled(run.stick_tpdo, str(axis), start, end))
        word = _robot_word(run, axis, start, end).astype(float)
        at = _alone(ticks, TICK_GAP)
        at = at[(at >= 4) & (at < len(word) - 6)]
        for lag in FORWARD_LAGS:
            jumps[lag].append(ticks[at] * (word[at + lag] - word[at + lag - 1]))
    jumps = {lag: np.concatenate(parts) for lag, parts in jumps.items()}
    events = len(jumps[0])
    if events < TICKS_LEAST:
        raise Missing(f"{events} isolated encoder ticks in free space, {TICKS_LEAST} are needed")
    means = {lag: float(values.mean()) for lag, values in jumps.items()}
    best = max(means, key=means.get)
    rest = max(mean for lag, mean in means.items() if lag != best)
    noise = float(jumps[best].std()) / np.sqrt(events)
    if means[best] < 2 * rest or means[best] <= SIGNIFICANT * noise:
        raise Missing(f"no clear answer to encoder ticks: {means[best]:.2f} at lag {best}, {rest:.2f} elsewhere")
    return {"latency_forward_cycles": best, "latency_forward_ticks": events}


def latency_back(run):
    """Joint torque sample to joystick torque command, on the buses; the sensor's noise is the excitation."""
    start, end = _spring_window(run)
    weights, variance = np.zeros(len(BACK_LAGS)), 0.0
    ticks = sum(np.abs(_ticks(_filled(run.stick_tpdo, str(axis), start, end))) for axis in range(2))
    busy = np.convolve(ticks > 0, np.ones(2 * TICK_CLEAR + 1), "same") > 0.5
    for axis in range(2):
        answer = np.diff(_filled(run.stick_rpdo, str(axis), start, end).astype(float), prepend=0.0)
        cause = np.diff(_filled(run.joint_tpdo[axis], "torque", start, end).astype(float), prepend=0.0)
        rows = np.flatnonzero(~busy)
        rows = rows[(rows > max(BACK_LAGS)) & (rows < len(cause) + min(BACK_LAGS))]
        if len(rows) < ROWS_LEAST:
            raise Missing(f"{len(rows)} quiet cycles in the spring hold, {ROWS_LEAST} are needed")
        matrix = np.stack([cause[rows - lag] for lag in BACK_LAGS], axis=1)
        found = np.linalg.lstsq(matrix, answer[rows], rcond=None)[0]
        weights += np.abs(found)
        variance += np.mean((answer[rows] - matrix @ found) ** 2) / max(1.0, np.sum(matrix[:, 0] ** 2))
    best = int(np.argmax(weights))
    rest = float(np.delete(weights, best).max())
    if weights[best] < 2 * rest or weights[best] <= max(1e-9, SIGNIFICANT * np.sqrt(variance)):
        raise Missing(f"no clear answer to torque noise: {weights[best]:.3f} against {rest:.3f}")
    return {"latency_back_cycles": list(BACK_LAGS)[best]}


def _circle_window(run):
    """Whole periods of constant amplitude, at most four, the last ones."""
    first, end = _segment(run, "circle", None)
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
        raise Missing(f"{turns:.1f} periods of constant amplitude, 3 are needed")
    length = round(len(angle) / turns * periods)
    last = first + int(steady[-1]) + 1
    return last - length, last, turns * 1e6 / (len(angle) * CYCLE_US)


def _best_lag(reference, signal, start, end):
    """(error, lag) of signal(k + lag) against reference(k), means removed."""
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
    for joint in range(2):
        stick = _filled(run.stick_tpdo, str(joint), low, high) * runs.POSITION_RAD
        motor = _filled(run.joint_tpdo[joint], "position", low, high) * runs.POSITION_RAD
        reference = POSITION_SCALE * stick
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


def _reflection(run, window):
    start, end = window
    external = run.at_cycles("CONTACT", "external_torque_nm")[start:end] * FORCE_SCALE
    worst, block = None, 0.0
    for axis in range(2):
        expected = external[:, axis]
        if abs(expected.mean()) / FORCE_SCALE < SMALLEST_TORQUE_NM:
            continue
        felt = _filled(run.stick_rpdo, str(axis), start, end) * runs.STICK_TORQUE_NM
        worst = max(worst or 0.0, float(abs(felt.mean() - expected.mean()) / abs(expected.mean())))
        size = 1_000_000 // CYCLE_US
        for at in range(0, len(felt) - size + 1, size):
            part = slice(at, at + size)
            block = max(block, float(abs(felt[part].mean() - expected[part].mean()) / abs(expected[part].mean())))
    if worst is None:
        raise Missing(f"no axis with {SMALLEST_TORQUE_NM} Nm of external joint torque in the hold")
    return worst, block


def reflection(run):
    """Mean reflected torque against truth in the spring hold."""
    worst, block = _reflection(run, _spring_window(run))
    return {"reflection_error": worst, "reflection_error_1s": block}


def reflection_contour(run):
    """Mean reflected torque against truth in the contour hold."""
    worst, block = _reflection(run, _contour_window(run))
    return {"reflection_error_contour": worst, "reflection_error_contour_1s": block}


def hold_motion(run):
    """Joystick motion in the holds, peak to peak."""
    spans = {}
    for name, window in (("spring", _spring_window(run)), ("contour", _contour_window(run))):
        positions = [_filled(run.stick_tpdo, str(axis), *window) for axis in range(2)]
        spans[name] = float(max(np.ptp(position) for position in positions) * runs.POSITION_RAD)
    return {
        "hold_motion_rad": max(spans.values()),
        "hold_motion_spring_rad": spans["spring"],
        "hold_motion_contour_rad": spans["contour"],
    }


def contact(run):
    """Contact kept while following and holding; largest contact force from the touch on."""
    touched = run.at_cycles("CONTACT", "in_contact")
    if touched is None:
        raise Missing("no truth of the contact")
    press, _ = _segment(run, "press", None)
    follow, _ = _segment(run, "follow", "press")
    _, hold_end = _segment(run, "hold", "follow")
    force = np.linalg.norm(run.at_cycles("CONTACT", "contact_force_n")[press:hold_end], axis=1)
    return {
        "contact_share": float(np.nanmean(touched[follow:hold_end] > 0)),
        "contact_force_max_n": float(np.nanmax(force)),
    }


def _drives(run):
    """Dict (bus, node, axis) -> list of (time_us, entry) of the truth."""
    found = {}
    for entry in run.truth["DRIVE"]:
        found.setdefault((entry["bus"], entry["node"], entry["axis"]), []).append(entry)
    return found


def _is_enabled(entry):
    return entry["statusword"] & STATE_MASK == OPERATION_ENABLED


def brake_drop(run):
    """Motion of the arm's links from the instant a joint drive left operation-enabled, until it is enabled again."""
    link = run.at_cycles("JOINTS", "position_rad")
    if link is None:
        raise Missing("no truth of the joints")
    worst, count = 0.0, 0
    for (bus, _, _), entries in _drives(run).items():
        if bus != "robot":
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
    """Position mode: first target in force against the drive's position before; None in torque mode."""
    csp = run.joint_csp[joint]
    commanded = csp.seen[at : at + 3] & (csp["control"][at : at + 3] & 0xF == ENABLE_OPERATION)
    if not commanded.any():
        return None
    first = at + int(np.argmax(commanded))
    return abs(csp["position"][first] - run.joint_tpdo[joint]["position"][at - 1]) * runs.POSITION_RAD


def _torque_step(run, joint, at):
    """Torque mode: first command against the torque that the brake held, as the position it stands for."""
    cst = run.joint_cst[joint]
    enabling = np.flatnonzero(cst.seen[at - 3 : at + 3] & (cst["control"][at - 3 : at + 3] & 0xF == ENABLE_OPERATION))
    if not len(enabling):
        return 0.0
    held = np.median(run.joint_tpdo[joint]["torque"][max(0, at - 20) : at])
    return abs(cst["torque"][at - 3 + int(enabling[0])] - held) * runs.JOINT_TORQUE_NM / JOINT_STIFFNESS_NM_RAD


def engagement_step(run):
    """Step of the joint command at engagement, and the motion of the motor within 10 ms after it.

    In position mode the command is on the bus; in torque mode the torque step is converted to a position step by
    the joint loop's stiffness. A later motion is no step: the arm follows the hand and its load.
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
    """Samples lost of all links, from the last TM[130,9] of each link and the members' counters."""
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
    """When each drive that was enabled at the cut left operation-enabled after it; None for one that did not."""
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
    """Time from the cut of a node until the last drive of the network leaves operation-enabled."""
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
    """Every member went to ERROR_OPERATIONAL within 0.1 s of each unplug, according to TM[129,2]."""
    cuts = [fault["time_us"] for fault in run.truth["FAULT"] if fault["kind"] == "unplug" and fault["active"]]
    members = {packet.apid for _, packet, _ in run.reports_of("link transition")}
    for cut in cuts:
        told = {
            packet.apid
            for time_ns, packet, decoded in run.reports_of("transition")
            if decoded["state"] == "ERROR_OPERATIONAL" and cut <= time_ns // 1000 <= cut + 100_000
        }
        if not members or not members <= told:
            return False
    return bool(cuts)


def _limits(run):
    """Telecommanded torque limits: list of (time_us, [Nm, Nm]) of successful-looking TC[20,3]."""
    found = []
    for time_ns, direction, packet, _ in run.packets:
        if direction != "TC" or packet is None or packet.message != (20, 3) or run.dictionary is None:
            continue
        subsystem = run.dictionary.subsystem_of_apid(packet.apid)
        parameter_id = int.from_bytes(packet.data[1:5], "big")
        parameter = subsystem.parameter_of_id(parameter_id) if subsystem else None
        if parameter is not None and parameter.name == "TORQUE_LIMIT" and packet.data[0] == 1:
            found.append((time_ns // 1000, parameter.decode(packet.data, 5)[0]))
    return found


def torque_limit(run):
    """Time from the first torque word beyond the telecommanded limit to the first controlword other than 0x0F."""
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
)


def compute(run):
    """(figures, reasons): every figure by name, None with a reason if the logs do not contain its data."""
    figures, reasons = {}, {}
    for function, names in FIGURES:
        try:
            figures.update(function(run))
        except (Missing, IndexError, ValueError, TypeError) as problem:
            for name in names:
                figures[name] = None
                reasons[name] = str(problem) or type(problem).__name__
    return figures, reasons


def holds(name, value):
    """True if a figure is within its bound; False also for None."""
    relation, bound = BOUNDS[name]
    if value is None:
        return False
    return {"<": value < bound, "<=": value <= bound, ">=": value >= bound}[relation]
