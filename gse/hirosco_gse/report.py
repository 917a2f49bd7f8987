# SPDX-License-Identifier: Apache-2.0
"""Report of a run: python3 -m hirosco_gse.report RUN_DIR

Completes run.json (figures, sha256 of the logs, versions), draws the plots as PNG and writes report.html,
which contains all its pictures. It uses the logs that exist: a run that crashed gets its report, too.
Exit codes: 0 written, 1 not written.
"""

import base64
import hashlib
import html
import importlib.metadata
import json
import os
import pathlib
import platform
import sys

from . import __version__, figures
from . import run as runs

LOGS = ("packets.log", "packets.db", "can-*.log", "truth.lcm")
TEXTS = {
    "latency_forward_cycles": ("Latency, joystick sample to robot command", "cycles"),
    "latency_back_cycles": ("Latency, joint torque to joystick torque", "cycles"),
    "tracking_error": ("Tracking error in free space at 0.5 Hz, lag removed", ""),
    "reflection_error": ("Error of the reflected force, spring hold", ""),
    "reflection_error_contour": ("Error of the reflected force, contour hold", ""),
    "hold_motion_rad": ("Joystick motion in the holds, peak to peak", "rad"),
    "contact_share": ("Contact kept while following and holding", ""),
    "contact_force_max_n": ("Largest contact force for 15 N asked", "N"),
    "brake_drop_rad": ("Motion of the arm when it leaves operation", "rad"),
    "engagement_step_rad": ("Step of the joint command at engagement", "rad"),
    "link_lost": ("Link samples lost", ""),
    "unplug_reaction_s": ("Unplug to all drives out of operation", "s"),
    "torque_limit_reaction_cycles": ("Torque limit to the command that leaves operation", "cycles"),
}
STYLE = """
body{font:15px/1.5 system-ui,sans-serif;color:#242a33;max-width:1080px;margin:2em auto;padding:0 1em}
h1{font-size:1.6em;margin:0}h2{font-size:1.15em;margin:1.8em 0 .4em;border-bottom:1px solid #dfe3e8}
.sub{color:#667080}.good{color:#2d7a4b}.bad{color:#b3261e}.chip{padding:.15em .6em;border-radius:.7em;font-weight:600}
.chip.good{background:#e4f3ea}.chip.bad{background:#fbe7e5}img{width:100%;margin:.3em 0}
table{border-collapse:collapse;width:100%;font-size:.93em}td,th{padding:.22em .7em .22em 0;text-align:left;vertical-align:top}
tr+tr td{border-top:1px solid #eef0f3}th{color:#667080;font-weight:600}code,.num{font-family:ui-monospace,monospace;font-size:.92em}
details{margin:.4em 0}summary{cursor:pointer;color:#2f6db3}.wrap{word-break:break-all}
"""


def sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as log:
        for part in iter(lambda: log.read(1 << 20), b""):
            digest.update(part)
    return digest.hexdigest()


def versions():
    """Versions of the programs that made the report."""
    found = {"gse": __version__, "python": platform.python_version()}
    for name in ("numpy", "matplotlib"):
        found[name] = importlib.metadata.version(name)
    return found


FIGURES_FAILED = 3  # Exit code that the launcher evaluates.


def is_telepresence(run):
    """True for the telepresence scenario, for which the figures are defined."""
    return pathlib.Path(str(run.facts.get("scenario", ""))).stem == "telepresence"


def failed_figures(facts):
    """Names of the figures whose value is out of its bound."""
    names = figures.BOUNDS if "figures_hold" in facts else ()
    return [name for name in names if facts.get(name) is not None and not figures.holds(name, facts[name])]


def complete_facts(run):
    """Content of run.json: the launcher's facts, figures by their names, hashes, versions."""
    computed, reasons = figures.compute(run)
    facts = dict(run.facts)
    facts.update(computed)
    facts["figures_missing"] = reasons
    if is_telepresence(run):
        facts["figures_hold"] = all(figures.holds(name, computed.get(name)) for name in figures.BOUNDS)
        failed = failed_figures(facts)
        if failed and facts.get("exit_code") == 0:
            facts.update(exit_code=1, exit_reason=f"figures out of their bounds: {' '.join(failed)}")
    facts["sha256"] = {path.name: sha256(path) for pattern in LOGS for path in sorted(run.folder.glob(pattern))}
    facts["versions"] = {**facts.get("versions", {}), **versions()}
    if run.dictionary is not None:
        facts.setdefault("interface_hash", run.dictionary.interface_hash)
        facts.setdefault("configuration_hash", run.dictionary.configuration_hash)
    facts.setdefault("simulated_s", run.count * runs.CYCLE_US / 1e6)
    facts["packets"] = len(run.packets)
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
    return sorted(found)


def _save_plots(run):
    """List of (title, png octets); each is also a file in the run's folder."""
    # matplotlib takes a second to load: only when a report is written.
    from . import plots

    drawn = []
    for name, title, plot in plots.PLOTS:
        try:
            figure = plot(run)
        except (ValueError, IndexError, KeyError, TypeError) as problem:
            run.problems.append(f"plot '{name}': {problem}")
            continue
        if figure is None:
            continue
        path = run.folder / f"{name}.png"
        figure.savefig(path, dpi=110, metadata={"Software": None})
        plots.plt.close(figure)
        drawn.append((title, path.read_bytes()))
    return drawn


def _value(value):
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _figure_rows(facts):
    rows = ["<tr><th>figure</th><th>value</th><th>bound</th><th></th><th>name in run.json</th></tr>"]
    for name, (relation, bound) in figures.BOUNDS.items():
        value = facts.get(name)
        good = figures.holds(name, value)
        title, unit = TEXTS[name]
        reason = facts["figures_missing"].get(name)
        note = f'<br><span class="sub">{html.escape(reason)}</span>' if reason else ""
        mark = '<span class="good">holds</span>' if good else f'<span class="bad">{"fails" if value is not None else "missing"}</span>'
        rows.append(
            f'<tr><td>{html.escape(title)}{note}</td><td class="num">{_value(value)} {unit}</td>'
            f'<td class="num">{html.escape(relation)} {bound:g}</td><td>{mark}</td><td><code>{name}</code></td></tr>'
        )
    return "\n".join(rows)


def _events(run):
    rows = []
    for time_ns, packet, decoded in run.reports:
        if decoded["kind"] not in ("event", "transition", "mode", "packet log", "link transition"):
            continue
        text = runs.telemetry.describe(packet, decoded, run.dictionary)
        rows.append(f'<tr><td class="num">{time_ns / 1e9:.4f}</td><td>{html.escape(text)}</td></tr>')
    return "\n".join(rows)


def _steps(run):
    rows = []
    for entry in run.operator:
        failed = str(entry.get("outcome", "")).startswith("FAILED")
        outcome = html.escape(str(entry.get("outcome", ""))).replace("\n", "<br>")
        text = html.escape(" ".join([entry.get("verb", ""), *entry.get("words", [])]))
        style = ' class="bad"' if failed else ""
        rows.append(
            f'<tr><td class="num">{entry["time"]:.4f}</td><td class="num">{entry["end"] - entry["time"]:.4f}</td>'
            f"<td>{text}</td><td{style}>{outcome}</td></tr>"
        )
    return "\n".join(rows)


def _details(title, rows, head):
    if not rows:
        return ""
    return f"<details><summary>{title}</summary><table><tr>{head}</tr>{rows}</table></details>"


def _verdict(run, facts):
    """(is good, words)."""
    reason = str(facts.get("exit_reason") or "")
    code = facts.get("exit_code")
    if code not in (0, None) or (code is None and reason):
        return False, f"ended with exit code {code}: {reason}" if code is not None else reason
    if "figures_hold" in facts and not facts["figures_hold"]:
        return False, "flown to the end; not all figures hold"
    if code is None:
        return not run.problems, "the run did not say how it ended"
    return True, "flown to the end" + ("; all figures hold" if facts.get("figures_hold") else "")


def _facts_rows(facts):
    hidden = set(TEXTS) | {"figures_missing", "report_problems"}
    rows = []
    for key, value in facts.items():
        if key not in hidden:
            text = json.dumps(value) if isinstance(value, (dict, list, bool)) else _value(value)
            rows.append(f'<tr><td>{html.escape(key)}</td><td class="num wrap">{html.escape(text)}</td></tr>')
    return "\n".join(rows)


def page(run, facts, drawn):
    """report.html."""
    good, verdict = _verdict(run, facts)
    words = [f"mission {facts.get('mission', '?')}", f"scenario {facts.get('scenario', '?')}"]
    words += [f"{key} {facts[key]}" for key in ("seed", "form", "time", "links") if key in facts]
    words.append(f"{facts['simulated_s']:.1f} s simulated")
    if isinstance(facts.get("real_time_factor"), (int, float)):
        words.append(f"{facts['real_time_factor']:.1f} x real time")
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        f"<title>Run {html.escape(run.folder.resolve().name)}</title><style>{STYLE}</style></head><body>",
        f"<h1>Run {html.escape(run.folder.resolve().name)}</h1><p class='sub'>{html.escape(' · '.join(words))}</p>",
        f"<p><span class='chip {'good' if good else 'bad'}'>{html.escape(verdict)}</span></p>",
    ]
    if facts["report_problems"]:
        items = "".join(f"<li>{html.escape(problem)}</li>" for problem in facts["report_problems"])
        parts.append(f"<ul class='bad'>{items}</ul>")
    if is_telepresence(run):
        parts.append(f"<h2>Figures</h2><table>{_figure_rows(facts)}</table>")
    for title, png in drawn:
        data = base64.b64encode(png).decode("ascii")
        parts.append(f"<h2>{html.escape(title)}</h2><img alt='{html.escape(title)}' src='data:image/png;base64,{data}'>")
    if not drawn:
        parts.append("<p>There is no log to draw.</p>")
    parts.append("<h2>In words</h2>")
    parts.append(_details("What the operator did", _steps(run), "<th>s</th><th>took s</th><th>step</th><th>outcome</th>"))
    parts.append(_details("Events and transitions", _events(run), "<th>s</th><th></th>"))
    parts.append(_details("Everything in run.json", _facts_rows(facts), "<th>name</th><th>value</th>"))
    return "\n".join([*parts, "</body></html>\n"])


def _write(path, text):
    """Write the file completely or not at all."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def write(folder, dictionary_path=None):
    """Write the report of a run's folder; returns the facts."""
    run = runs.load(folder, dictionary_path)
    drawn = _save_plots(run)
    facts = complete_facts(run)
    _write(run.folder / "run.json", json.dumps(facts, indent=1, default=float) + "\n")
    _write(run.folder / "report.html", page(run, facts, drawn))
    return facts


def main(argv=None):
    arguments = sys.argv[1:] if argv is None else argv
    if not 1 <= len(arguments) <= 2:
        print("usage: python3 -m hirosco_gse.report RUN_DIR [DICTIONARY]", file=sys.stderr)
        return 1
    try:
        facts = write(*arguments)
    except OSError as problem:
        print(f"report: {problem}", file=sys.stderr)
        return 1
    for name in figures.BOUNDS if "figures_hold" in facts else ():
        relation, bound = figures.BOUNDS[name]
        mark = "ok  " if figures.holds(name, facts.get(name)) else "FAIL"
        reason = facts["figures_missing"].get(name, "")
        print(f"{mark} {name:<30} {_value(facts.get(name)):>10}  {relation} {bound:g}  {reason}".rstrip())
    for problem in facts["report_problems"]:
        print(f"report: {problem}", file=sys.stderr)
    return FIGURES_FAILED if failed_figures(facts) else 0


if __name__ == "__main__":
    sys.exit(main())
