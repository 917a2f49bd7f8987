# SPDX-License-Identifier: Apache-2.0
"""The layer graph, drawn from the includes of the code by graphviz."""

import re
import subprocess
import sys

from page import ROOT

sys.path.insert(0, str(ROOT / "test" / "lint"))

import check_layers

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
GROUPS = {
    "fsw/programs": ("programs", "#fdf1dd"),
    "launcher": ("launcher", "#fdf1dd"),
    "fsw/subsystems": ("subsystems", "#e4f3ea"),
    "fsw/supervisor": ("supervisor", "#e4f3ea"),
    "fsw/framework": ("framework", "#eaf1fa"),
    "pus": ("pus", "#eaf1fa"),
    "osal": ("osal", "#f3ecf8"),
    "sim": ("sim", "#fbe7e5"),
    "base": ("base", "#f3ecf8"),
}


def home_of(path, layers):
    """Layer of a file according to test/lint/layers.txt; of the simulator, its directory."""
    if path.startswith("sim/"):
        return "/".join(path.split("/")[:2])
    return check_layers.first_match(layers, path)[0]


def edges():
    """Set of (layer, layer that it includes) in the code, and the number of files in each layer."""
    layers, _ = check_layers.read_rules(ROOT / "test" / "lint" / "layers.txt")
    found, files = set(), {}
    for top in ("base", "osal", "pus", "fsw", "launcher", "sim"):
        for path in sorted((ROOT / top).rglob("*.[ch]")):
            name = str(path.relative_to(ROOT))
            home = home_of(name, layers)
            files[home] = files.get(home, 0) + 1
            for included in INCLUDE.findall(path.read_text(encoding="utf-8")):
                other = home_of(included, layers)
                if not included.startswith("generated/") and other and other != home:
                    found.add((home, other))
    return found, files


def reduced(pairs):
    """Remove edges that a longer path implies (transitive reduction); the graph has no cycle."""
    sees = {}
    for home, other in pairs:
        sees.setdefault(home, set()).add(other)

    def reaches(start, goal, skip):
        waiting, done = [other for other in sees.get(start, ()) if (start, other) != skip], set()
        while waiting:
            at = waiting.pop()
            if at == goal:
                return True
            if at not in done:
                done.add(at)
                waiting += sees.get(at, ())
        return False

    return {(home, other) for home, other in pairs if not reaches(home, other, (home, other))}


def colour(layer):
    """Fill of a layer's box."""
    return next((fill for prefix, (_, fill) in GROUPS.items() if layer == prefix or layer.startswith(prefix + "/")), "#f6f7f9")


def label(layer):
    return layer.removeprefix("fsw/framework/").removeprefix("fsw/").replace("/include", "")


def dot(pairs, files, wanted):
    """Text for graphviz: the graph of the layers for which `wanted` is true."""
    lines = ['digraph{rankdir=TB;ranksep=.42;nodesep=.22;bgcolor="transparent";node[shape=box,style="rounded,filled",'
             'color="#c9d0d8",fontname="Helvetica",fontsize=11,height=.32,margin=".12,.05"];edge[color="#9aa5b1",arrowsize=.55]']
    shown = sorted(layer for layer in files if layer and wanted(layer))
    for layer in shown:
        lines.append(f'"{layer}"[label="{label(layer)}",fillcolor="{colour(layer)}",tooltip="{layer}: {files[layer]} files"]')
    lines += [f'"{home}"->"{other}"' for home, other in sorted(reduced({p for p in pairs if p[0] in shown and p[1] in shown}))]
    return "\n".join([*lines, "}"])


def svg(graph):
    """The graph as SVG for a page."""
    done = subprocess.run(["dot", "-Tsvg"], input=graph, capture_output=True, text=True, check=True)
    picture = done.stdout[done.stdout.index("<svg") :]
    return '<div class="graph">' + re.sub(r"<!--.*?-->\n?", "", picture, flags=re.DOTALL) + "</div>"


def section():
    """HTML: both graphs with an explanation."""
    pairs, files = edges()
    flight = svg(dot(pairs, files, lambda layer: not layer.startswith("sim/")))
    simulator = svg(dot(pairs, files, lambda layer: layer.startswith("sim/")))
    return (
        '<h2 id="layers">Layers</h2><p>Drawn from the includes of the code. An arrow leads from a layer to one that it includes; a layer that is also included '
        "through another layer has no arrow of its own. <code>make check</code> refuses every include that "
        "<code>test/lint/layers.txt</code> does not allow.</p>"
        f"{flight}<p>The simulator shares nothing with flight software except the contract of the operating system "
        f"layer and the status type:</p>{simulator}"
    )
