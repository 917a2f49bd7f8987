# SPDX-License-Identifier: Apache-2.0
"""Report of a run: python3 -m hirosco_gse.report RUN_DIR

Completes run.json (figures, sha256 of the logs, versions) and writes report.html: verdict, figures with their bounds, and the page
of the station with the recording of the run, all in one file that needs no other file. It uses the logs that exist: a run that
crashed gets a report, too.

Exit codes: 0 the report is written; 1 it is not written; 3 it is written, and the run has failed by its figures (a line for each is
printed); 4 it is not written, and the figures with bounds are therefore unknown, or run.json is damaged; 130 Ctrl-C has ended the report of
a run without bounds (with bounds: 4).
"""

from . import interrupt

if __name__ == "__main__":
    interrupt.hold()

import base64
import contextlib
import hashlib
import html
import importlib.metadata
import pathlib
import platform
import re
import signal
import sys
import time
import traceback

from . import __version__, arm_figures, figures, recording
from . import run as runs
from .figure_bounds import BoundsError, path_of
from .files import next_step, write_whole
from .run_directory import ROOT, facts_of, is_under_way, problem_of
from .values import json_of

LOGS = ("packets.log", "packets.db", "can-*.log", "truth.lcm")
TEXTS = {
    "latency_forward_cycles": ("Latency, joystick sample to robot command", "cycles"),
    "latency_back_cycles": ("Latency, joint torque to joystick torque", "cycles"),
    "tracking_error": ("Tracking error in free space at 0.5 Hz, lag removed", ""),
    "reflection_error": ("Error of the reflected force, spring hold", ""),
    "reflection_error_contour": ("Error of the reflected force, contour hold", ""),
    "hold_motion_rad": ("Joystick motion in the holds, peak to peak", "rad"),
    "contact_share": ("Contact kept while following and holding", ""),
    "contact_force_max_n": ("Largest contact force at a commanded force of 15 N", "N"),
    "brake_drop_rad": ("Motion of the arm when it leaves operation", "rad"),
    "engagement_step_rad": ("Step of the joint command when a drive is enabled", "rad"),
    "link_lost": ("Link samples lost", "samples"),
    "unplug_reaction_s": ("Time from the unplug until no drive is in operation", "s"),
    "torque_limit_reaction_cycles": ("Time from the exceeded torque limit to the command that ends operation", "cycles"),
    "free_drag_nm": ("Torque of the joystick in free space at 0.5 Hz, rms", "Nm"),
    "press_ripple_nm": ("Fast part of the torque of joint 2 from touch to follow, peak to peak", "Nm"),
    "passivity_local_j": ("Least energy put into the loop by hand and environment", "J"),
    "press_hold_oscillation_rad": ("Joystick motion above 2.5 Hz, press and hold, peak to peak", "rad"),
    "press_hold_motion_rad": ("Joystick motion, press and hold, peak to peak", "rad"),
    "hold_force_ripple_nm": ("Torque of the joystick, press and hold, standard deviation", "Nm"),
    "hold_contact_share": ("Contact kept, press and hold", ""),
    "hold_force_peak": ("Largest contact force relative to the commanded force, press and hold", ""),
    "hold_energy_j": ("Energy taken from the hand in 10 s of hold (negative: given to the hand)", "J"),
    "dynamic_transparency": ("Error of changes of the reflected force below 10 Hz", ""),
    "delay_hold_oscillation_rad": ("Joystick motion above 2.5 Hz, first hold, peak to peak", "rad"),
    "delay_after_follow_rad": ("Joystick motion above 2.5 Hz, hold after the follow, peak to peak", "rad"),
    "delay_reflection_error": ("Error of the reflected force, first hold", ""),
    "delay_contact_share": ("Contact kept in the holds, the smaller share", ""),
    "delay_force_peak_n": ("Largest contact force at a commanded force of 15 N", "N"),
    "delay_end_error_m": ("Error of the tip at the end of the flight", "m"),
    "delay_free_drag_nm": ("Torque of the joystick in free space at 0.5 Hz, rms", "Nm"),
    "tool_tracking_error": ("Error of the tool in free space relative to its motion, lag removed", ""),
    "tool_tracking_lag_s": ("Lag of the tool behind the joystick", "s"),
    "tool_force_free_n": ("Force reported in free space, rms", "N"),
    "tool_force_error": ("Error of the reported force, hold on the table", ""),
    "tool_reflection_error": ("Error of the reflected force, hold on the table", ""),
    "tool_hold_motion_rad": ("Joystick motion, hold on the table, peak to peak", "rad"),
    "tool_hold_ripple_n": ("Change of the contact force, hold on the table, peak to peak", "N"),
    "tool_contact_share": ("Contact kept, hold on the table", ""),
    "tool_force_peak_n": ("Largest contact force", "N"),
    "tool_drag_nm": ("Torque of the joystick in free space, rms", "Nm"),
    "tool_left_alone_m": ("Motion of the tool while its link is closed", "m"),
}
RELATIONS = {"<": "<", "<=": "≤", ">": ">", ">=": "≥"}
PAGE = ROOT / "build" / "station" / "page"
NEXT_STEP = "The film and the charts are drawn by the page of the station, which is not built yet. With a network, run: make report OUT={}"
BAR, BOUND_AT = 96, 0.8  # Width of a bar, and the place of the bound on it.


class ReportError(ValueError):
    """A directory of which no report is made, in words, with the next step."""


def sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as log:
        for part in iter(lambda: log.read(1 << 20), b""):
            digest.update(part)
    return digest.hexdigest()


def versions():
    """Versions of the programs that made the report."""
    return {"gse": __version__, "python": platform.python_version(), "numpy": importlib.metadata.version("numpy")}


FIGURES_FAILED = 3  # Exit codes that the launcher evaluates.
FIGURES_UNKNOWN = 4
INTERRUPTED = 128 + signal.SIGINT


def complete_facts(run):
    """Content of run.json: the launcher's facts, figures by their names, hashes, versions."""
    if "figures_hold" in run.facts and not figures.bounds_of(run.facts):
        raise ReportError(f"{path_of(str(run.facts.get('scenario')))}: no such file, expected the bounds by which the figures of this run were judged")
    computed, reasons = figures.compute(run)
    facts = dict(run.facts)
    facts.update(computed)
    facts["figures_missing"] = reasons
    if facts.pop("figures_failed", None):  # of an earlier report
        facts.update(exit_code=0, exit_reason="")
    if figures.bounds_of(facts):
        failed = figures.failures(facts)
        facts["figures_hold"] = not failed
        if failed and facts.get("exit_code") == 0:
            names = " ".join(line.split()[0] for line in failed)
            facts.update(exit_code=1, exit_reason=f"figures missing or out of their bounds: {names}", figures_failed=failed)
    facts["sha256"] = {path.name: sha256(path) for pattern in LOGS for path in sorted(run.directory.glob(pattern))}
    facts["versions"] = {**facts.get("versions", {}), **versions()}
    if run.dictionary is not None:
        facts.setdefault("interface_hash", run.dictionary.interface_hash)
        facts.setdefault("configuration_hash", run.dictionary.configuration_hash)
    facts.setdefault("simulated_s", run.count * runs.CYCLE_US / 1e6)
    facts["packets"] = max(len(run.packets), facts.get("packets", 0))  # A log that was cut later has fewer.
    facts["report_problems"] = run.problems + mismatches(run)
    return facts


def mismatches(run):
    """Interface hashes that were reported in flight and differ from those of the dictionary."""
    found = set()
    for _, packet, decoded in run.reports_of("status"):
        subsystem = run.dictionary.subsystem_of_apid(packet.apid)
        flown = int(decoded["interface_hash"], 0)
        if subsystem and subsystem.interface_hash not in (0, flown):
            wanted = subsystem.interface_hash
            found.add(f"{subsystem.name} flew interface 0x{flown:016x}, the dictionary has 0x{wanted:016x}: run make")
    flown, known = (source.get("device_classes_hash") for source in (run.facts, run.dictionary.content if run.dictionary else {}))
    if flown and known and int(flown, 0) != int(known, 0):
        found.add(f"the flight had device classes {flown}, the dictionary has those of {known}: run make")
    return sorted(found)


def _count_of(facts):
    """(number of figures within their bounds, number of figures with a bound)."""
    bounds = figures.bounds_of(facts)
    return sum(figures.holds(name, facts.get(name), bounds) for name in bounds), len(bounds)


def _verdict(run, facts):
    """(is good, words)."""
    reason = str(facts.get("exit_reason") or "")
    code = facts.get("exit_code")
    if code not in (0, None) or (code is None and reason):
        return False, f"ended with exit code {code}: {reason}" if code is not None else reason
    if "figures_hold" in facts and not facts["figures_hold"]:
        return False, "flown to the end; not all figures hold"
    if code is None:
        return not run.problems, "run.json does not contain how the run ended"
    return True, "flown to the end" + ("; all figures hold" if facts.get("figures_hold") else "")


def _in_readable_unit(value, bound, unit):
    """(value, bound, unit) in a unit that is easy to read: ratios in percent; thousandths of the unit if the bound is below 0.1 rad, s, m, J, Nm or N."""
    if unit == "":
        return value * 100, bound * 100, "%"
    if unit in ("rad", "s", "m", "J", "Nm", "N") and abs(bound) < 0.1:
        return value * 1000, bound * 1000, f"m{unit}"
    return value, bound, unit


def _number(value):
    return f"{value:.3g}".replace("-", "−")


def _bar(value, bound):
    """The value as a bar, with a mark at its bound."""
    share = value / bound if bound else float(value != 0)
    width = min(1.0, max(0.02, share * BOUND_AT)) * BAR
    mark = BOUND_AT * BAR
    return (
        f'<svg class="figure-bar" viewBox="0 0 {BAR} 12" aria-hidden="true"><path class="all" d="M0 6h{BAR}"/>'
        f'<path class="value" d="M0 6h{width:.1f}"/><path class="bound" d="M{mark:.1f} 1v10"/></svg>'
    )


def text_of(name):
    """(title, unit) of a figure; an unknown one has its name as the title."""
    return TEXTS.get(name) or arm_figures.text_of(name) or (name, "")


def _figure_rows(facts):
    rows = []
    for name, (relation, bound) in (bounds := figures.bounds_of(facts)).items():
        value = facts.get(name)
        good = figures.holds(name, value, bounds)
        title, unit = text_of(name)
        reason = html.escape(facts["figures_missing"].get(name) or "")
        shown, limit, unit = _in_readable_unit(value if value is not None else 0.0, bound, unit)
        number = _number(shown) if value is not None else "missing"
        words = "holds" if good else "fails" if value is not None else "missing"
        rows.append(
            f'<tr class="{words}"><td class="mark" aria-label="{words}">{"✓" if good else "✗"}</td>'
            f'<td title="{name}">{html.escape(title)}{f"<br>{reason}" if reason else ""}</td><td class="value num">{number}</td>'
            f'<td>{unit if value is not None else ""}</td><td>{_bar(value, bound) if value is not None else ""}</td>'
            f'<td class="num">{RELATIONS[relation]} {_number(limit)}</td></tr>'
        )
    return "".join(rows)


def _cell(first, second, mark=None):
    sign = {True: '<span class="mark good">✓</span>', False: '<span class="mark bad">✗</span>', None: ""}[mark]
    return f'<div class="cell">{sign}<div class="two"><strong>{html.escape(first)}</strong><span>{html.escape(second)}</span></div></div>'


def _head(run, facts):
    """Head line: what flew, and the verdict."""
    good, verdict = _verdict(run, facts)
    words = [f"seed {facts['seed']}"] if "seed" in facts else []
    words += [str(facts["form"])] if "form" in facts else []
    words += [f"{facts['time']} time"] if "time" in facts else []
    flown = f"{facts['simulated_s']:.2f} s flown" + (f" in {facts['wall_s']:.1f} s" if isinstance(facts.get("wall_s"), (int, float)) else "")
    line = "; ".join(filter(None, [", ".join(words), f"hirosco {facts.get('versions', {}).get('hirosco', __version__)}", flown]))
    names = (facts.get("mission", "?"), pathlib.Path(facts.get("scenario", "?")).name)  # The tab Run has the whole path.
    title = ", ".join(dict.fromkeys(names))  # Often the scenario has the name of the mission.
    hold, count = _count_of(facts)
    cells = [_cell(f"{hold} of {count} figures hold" if count else "no figures for this scenario", verdict, good)]
    if "reproducible" in facts:
        reproducible = "reproducible" if facts["reproducible"] else "not reproducible"
        cells.append(_cell(reproducible, f"{len(facts['sha256'])} logs, sha256 in run.json"))
    if "interface_hash" in facts:
        differs = mismatches(run)
        about = "differs from the dictionary of this report" if differs else "the same as in the dictionary of this report"
        cells.append(_cell(f"interface {str(facts['interface_hash'])[2:10]}", about, False if differs else None))
    return f'<div class="cell mission"><div><h1>{html.escape(title)}</h1><span>{html.escape(line)}</span></div></div>{"".join(cells)}'


def _side(facts):
    """Problems, and the figures with their bounds."""
    parts = []
    if facts["report_problems"]:
        items = "".join(f"<li>{html.escape(problem)}</li>" for problem in facts["report_problems"])
        parts.append(f'<ul class="problems">{items}</ul>')
    if figures.bounds_of(facts):
        parts.append(f"<table>{_figure_rows(facts)}</table>")
    else:
        parts.append('<p class="reason">This scenario has no figures with bounds.</p>')
    return "".join(parts)


def _style(text, directory):
    """The style sheet of the page with its fonts included, except the font format of old browsers."""
    text = re.sub(r',\s*url\(\)\s*format\("?woff"?\)', "", text)

    def inside(match):
        octets = (directory / match[1]).read_bytes()
        return f"url(data:font/woff2;base64,{base64.b64encode(octets).decode('ascii')})"

    return re.sub(r'url\("?(?:\./)?([\w.-]+\.woff2)"?\)', inside, text)


def _table(title, heads, rows):
    """A panel with a table of texts."""
    lines = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return (f'<section class="panel"><div class="head"><h2>{title}</h2></div><div class="scroll" tabindex="0" role="group" aria-label="{title}">'
            f'<table><tr>{"".join(f"<th>{one}</th>" for one in heads)}</tr>{lines}</table></div></section>')


def _outcome(lights):
    """Outcome of a command by the first letters of the last states of its verification lights (station/lights.py)."""
    return "failed" if "f" in lights else "done" if lights.endswith("d") else "not known"


def _lists(run):
    """Events, commands and states of a run as tables, for a report without the page that draws film and charts."""
    head = recording.head_of(run)
    commands = [(f"{row['time']:.3f}", row["text"], _outcome(row["lights"][-1][1]), row.get("words", ""))
                for row in head.get("commands", ())]
    events = [(f"{seconds:.3f}", name, severity, event, text) for seconds, name, severity, event, text, *_ in head.get("events", ())]
    states = [(f"{seconds:.3f}", name, state, cause or "") for seconds, name, state, _, _, cause in head.get("states", ())]
    return (f'<section class="panel next"><p>{html.escape(NEXT_STEP.format(run.directory))}</p></section>'
            + _table("Events", ("s", "subsystem", "severity", "event", "what it says"), events)
            + _table("Commands", ("s", "command", "completion", "reason"), commands)
            + _table("States", ("s", "subsystem", "state", "cause"), states))


def page(run, facts, built=None):
    """Text of report.html. built: directory of the page of the station, if not that of this tree; without a page the report has tables of events,
    commands and states instead of film and charts."""
    built = built or PAGE
    is_whole = (built / "station.js").exists()
    name = html.escape(run.directory.resolve().name)
    if is_whole:
        style = _style((built / "station.css").read_text(encoding="utf-8"), built)
        script = (built / "station.js").read_text(encoding="utf-8").replace("</script", "<\\/script")
        octets = base64.b64encode(recording.make(run, {"facts": facts})).decode("ascii")
        main = '<station-scene class="panel"></station-scene><station-strips class="panel"></station-strips>'
        log, foot = '<station-log class="panel"></station-log>', "<station-player></station-player>"
        scripts = f'<script id="recording" type="text/plain">{octets}</script><script>{script}</script>'
    else:
        source = ROOT / "gse" / "page" / "src" / "station.css"
        style = "".join(line for line in source.read_text(encoding="utf-8").splitlines(True) if not line.startswith("@import"))
        main = _lists(run)
        log = foot = scripts = ""
    classes = "replay report" if is_whole else "replay report plain"
    policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; font-src data:; img-src data:"
    return "".join([
        '<!DOCTYPE html>\n<html lang="en" data-theme="light"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">',
        f'<title>Run {name}</title><style>{style}</style></head><body class="{classes}">\n',
        f'<header>{_head(run, facts)}<div class="cell"><button id="theme" aria-label="Light or dark" title="Light or dark">☀</button></div></header>\n',
        f'<div class="body"><main aria-label="Flight">{main}</main><aside aria-label="Figures and log">',
        f'<section class="panel figures"><div class="head"><h2>Figures and their bounds</h2></div><div class="scroll" tabindex="0" role="group" '
        f'aria-label="Figures">{_side(facts)}</div></section>{log}</aside></div>\n<footer>{foot}</footer>\n',
        '<div id="said" class="unseen" role="status" aria-live="polite"></div><div id="alarm-said" class="unseen" role="alert"></div>\n',
        f"{scripts}</body></html>\n",
    ])


def _write(path, text):
    """Write the file completely or not at all. Returns its size."""
    octets = text.encode()
    write_whole(path, lambda stream: stream.write(octets))
    return len(octets)


def _write_facts(directory, facts):
    _write(pathlib.Path(directory) / "run.json", json_of(facts, default=float, indent=1) + "\n")


def _check(directory):
    """Raise ReportError if no report can be made of a directory. A flight under way gets none: a report writes run.json, by which ground users see that
    a flight has ended."""
    if problem := problem_of(directory):
        raise ReportError(f"{problem}. Name such a directory: make report OUT=runs/...")
    if problem := facts_of(directory)[1]:
        raise ReportError(f"{directory}: {problem}. Correct the value, or for a report without these facts delete the file and call: "
                          f"make report OUT={directory}")
    if is_under_way(pathlib.Path(directory)):
        raise ReportError(f"{directory}: its flight is under way, expected one that has ended. After its end call: make report OUT={directory} (if this "
                          f"flight was killed and another one has its port, delete {directory}/ground.port)")


def write(directory, dictionary_path=None):
    """Write the report of a run's directory; returns the facts. Raises ReportError, before anything is written, if the directory is not that of a
    run, its run.json is damaged, or its flight is under way."""
    start = time.monotonic()
    _check(directory)
    run = runs.load(directory, dictionary_path)
    facts = complete_facts(run)
    _write_facts(directory, facts)
    octets = _write(run.directory / "report.html", page(run, facts))
    facts["report"] = {"octets": octets, "seconds": round(time.monotonic() - start, 2)}
    _write_facts(directory, facts)
    return facts


def _has_bounds(facts):
    """Whether the run has figures with bounds, as far as its facts are readable."""
    try:
        return bool(figures.bounds_of(facts))
    except Exception:  # The facts may be anything.
        return True


def _reason(problem, directory):
    """Sentences about an error: of a file that cannot be read or written, or of a log with unexpected content."""
    if isinstance(problem, KeyboardInterrupt):
        return "ended by Ctrl-C."
    if isinstance(problem, BoundsError):
        return f"{problem}."
    if isinstance(problem, OSError) and problem.filename:
        return f"{problem.filename}: {problem.strerror}{next_step(problem)}."
    place = traceback.extract_tb(problem.__traceback__)[-1]
    return f"{type(problem).__name__}: {problem} ({pathlib.Path(place.filename).name}:{place.lineno}). Is a log of {directory} damaged?"


def _not_written(directory, problem):
    """Print why there is no report. A run whose figures have bounds has then failed. Returns the exit code."""
    facts, damage = facts_of(directory)
    if isinstance(problem, ReportError):
        print(f"report: not written: {problem}", file=sys.stderr)
        return FIGURES_UNKNOWN if damage else 1
    print(f"report: not written: {_reason(problem, directory)} To try again: make report OUT={directory}", file=sys.stderr)
    if not facts or not _has_bounds(facts):
        return INTERRUPTED if isinstance(problem, KeyboardInterrupt) else 1
    facts = {**facts, "figures_hold": False, "figures_failed": ["report: not written"]}
    if facts.get("exit_code") == 0:
        facts.update(exit_code=1, exit_reason="the report could not be made, so the figures are not known")
    with contextlib.suppress(OSError):
        _write_facts(directory, facts)
    return FIGURES_UNKNOWN


def main(argv=None):
    arguments = sys.argv[1:] if argv is None else argv
    if not 1 <= len(arguments) <= 2:
        print("usage: python3 -m hirosco_gse.report RUN_DIR [DICTIONARY]", file=sys.stderr)
        return 1
    try:
        interrupt.release()
        facts = write(*arguments)
    except (Exception, KeyboardInterrupt) as problem:  # Logs of a crashed run may contain any error; report it.
        return _not_written(arguments[0], problem)
    failed = facts.get("figures_failed", [])
    for line in failed:
        print(f"figure {line}")
    if not (PAGE / "station.js").exists():
        print(f"report: {NEXT_STEP.format(arguments[0])}")
    for problem in facts["report_problems"]:
        print(f"report: {problem}", file=sys.stderr)
    return FIGURES_FAILED if failed else 0


if __name__ == "__main__":
    sys.exit(main())
