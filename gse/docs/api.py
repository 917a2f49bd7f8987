# SPDX-License-Identifier: Apache-2.0
"""API reference from the headers: one page for each layer with its headers in order."""

import re

import headers
from page import ROOT, anchor, escape, shell

KEYWORDS = "typedef|struct|enum|union|const|static|inline|void|bool|char|int|unsigned|double|float|size_t|u?int(?:8|16|32|64)_t|return"
LAYERS = (
    ("osal/include/osal", "osal", "The operating system, one header per object"),
    ("base", "base", "Status, assertion, octets, CRC, text, value, pools"),
    ("fsw/framework/parameter", "parameter", "The parameter dictionary"),
    ("fsw/framework/dataflow", "dataflow", "End nodes: CAN, shared memory, UDP, TCP ..."),
    ("fsw/framework/xml", "xml", "Sequential XML parser on a static arena"),
    ("fsw/framework/descriptor", "descriptor", "Descriptors to a checked model"),
    ("fsw/framework/message", "message", "Octet blocks between components"),
    ("fsw/framework/journal", "journal", "Records that survive power cuts"),
    ("fsw/framework/sdls", "sdls", "Authenticated telecommands"),
    ("fsw/framework/rtlink", "rtlink", "Data plane of real-time links"),
    ("fsw/framework/control", "control", "Elementary control functions"),
    ("fsw/framework/subsystem", "subsystem", "The generic subsystem: begin here"),
    ("pus/*", "pus", "Packets and ECSS PUS-C services"),
    ("fsw/canopen", "canopen", "CiA 301/402 master"),
    ("fsw/drives", "drives", "Functions that subsystems with drives share"),
    ("fsw/devices", "devices", "Functions that subsystems with stream devices share"),
    ("fsw/equipment", "equipment", "Devices on CAN and stream devices in one subsystem"),
    ("fsw/procedures", "procedures", "Lua engine of on-board control procedures"),
    ("fsw/supervisor", "supervisor", "Routing, permission, logs, links, errors"),
)
NOT_IN_THE_REFERENCE = ("fsw/programs", "fsw/subsystems", "fsw/supervisor/services")  # Programs, not libraries.


def page_of(layer):
    """File name of a layer's page."""
    return f"api-{layer}.html"


def read_all():
    """Read the headers of the libraries: a list of (layer, about, headers) in the order of LAYERS. A directory that LAYERS does not name is
    an error."""
    known = {directory for directory, _, _ in LAYERS}
    there = {str(path.parent.relative_to(ROOT)) for top in ("base", "osal/include", "fsw") for path in (ROOT / top).rglob("*.h")}
    missing = sorted(directory for directory in there - known if not directory.startswith(NOT_IN_THE_REFERENCE))
    if missing:
        raise SystemExit(f"gse/docs/api.py: LAYERS has no line for {', '.join(missing)}: add one for each, with the name of its page and a description")
    found = []
    for directory, layer, about in LAYERS:
        files = [path for path in sorted(ROOT.glob(f"{directory}/*.h")) if path.parent.name != "tool" and not path.stem.endswith(("_internal", "_builder"))]
        files.sort(key=lambda path, layer=layer: path.stem != layer)
        found.append((layer, about, [headers.read(path, str(path.relative_to(ROOT))) for path in files]))
    return found


def index_of(layers):
    """Addresses of all declarations in the reference, by name."""
    addresses = {}
    for layer, _, files in layers:
        for header in files:
            for entry in header.entries:
                for name in entry.names:
                    addresses.setdefault(name, f"{page_of(layer)}#{name}")
    return addresses


def link_names(text, addresses, own=()):
    """Make each name of a declaration in a text a link to the declaration."""

    def link(found):
        name = found[0]
        return f'<a href="{addresses[name]}">{name}</a>' if "_" in name and name in addresses and name not in own else name

    return re.sub(r"\b[A-Za-z_]\w{3,}\b", link, text)


def code_block(entry, addresses):
    """HTML of a declaration with coloured comments and keywords."""
    lines = []
    body = entry.code
    if entry.is_private and len(body) > 3:
        body = [body[0], "    ...", body[-1]]
    for line in body:
        code, mark, comment = line.partition("//")
        shown = re.sub(rf"\b({KEYWORDS})\b", r'<span class="k">\1</span>', link_names(escape(code), addresses, entry.names))
        lines.append(shown + (f'<span class="c">{escape(mark + re.sub("^/<?", "", comment))}</span>' if mark else ""))
    return "<pre><code>" + "\n".join(lines) + "</code></pre>"


def prose(lines, addresses):
    """HTML of a comment: paragraphs, labelled lines and blocks of code."""
    out, labels, paragraph, block = [], [], [], []

    def close():
        if paragraph:
            out.append("<p>" + link_names(ticks(escape(" ".join(paragraph))).replace("\n", "<br>"), addresses) + "</p>")
            paragraph.clear()
        if labels:
            cells = "".join(f"<dt>{escape(k)}</dt><dd>{link_names(ticks(escape(' '.join(v))), addresses)}</dd>" for k, v in labels)
            out.append(f"<dl>{cells}</dl>")
            labels.clear()
        if block:
            out.append("<pre><code>" + link_names(escape("\n".join(block)), addresses) + "</code></pre>")
            block.clear()

    for line in lines:
        label = re.match(r"([A-Z][a-z]+(?: [a-z]+)?) {2,}(\S.*)", line)
        if not line:
            close()
        elif label:
            if not labels:
                close()
            labels.append((label[1], [label[2]]))
        elif labels:
            labels[-1][1].append(line.strip())
        elif line.startswith("    "):
            if not block:
                close()
            block.append(line[4:])
        else:
            if block:
                close()
            paragraph.append(("\n" if re.match(r" +([0-9]+\.|-) ", line) else "") + line.strip())
    close()
    return "".join(out)


def ticks(text):
    """Mark each `name` in a text as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", text)


def layer_page(layer, about, files, addresses):
    body, contents = [f'<h1>{layer}</h1><p class="sub">{escape(about)}</p>'], []
    for header in files:
        fragment = anchor(header.path)
        contents.append((2, fragment, header.path.rpartition("/")[2]))
        body.append(f'<h2 id="{fragment}"><span class="mono">{escape(header.path)}</span></h2>{prose(header.contract, addresses)}')
        for entry in header.entries:
            if entry.title:
                body.append(f"<h3>{escape(entry.title)}</h3>")
                continue
            marks = "".join(f'<a id="{name}"></a>' for name in entry.names)
            body.append(f'<div class="entry">{marks}{code_block(entry, addresses)}{prose(entry.text, addresses)}</div>')
    return shell(page_of(layer), layer, "".join(body), contents)


def pages():
    """Dict file -> HTML of the whole reference."""
    layers = read_all()
    addresses = index_of(layers)
    made = {page_of(layer): layer_page(layer, about, files, addresses) for layer, about, files in layers}
    cards = "".join(
        f'<a href="{page_of(layer)}"><b>{layer}</b><span>{escape(about)}; {len(files)} header{"s" if len(files) != 1 else ""}</span></a>'
        for layer, about, files in layers
    )
    names = "".join(f'<a href="{address}">{name}</a><br>' for name, address in sorted(addresses.items()))
    made["api.html"] = shell(
        "api.html",
        "API reference",
        f'<h1>API reference</h1><p class="sub">Made from the headers, which define the contracts.</p><div class="cards">{cards}</div>'
        f'<h2 id="names">All {len(addresses)} names</h2><div class="mono" style="columns:17em">{names}</div>',
    )
    return made
