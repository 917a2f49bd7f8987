# SPDX-License-Identifier: Apache-2.0
"""Interface control document from the descriptors: the contents of packets and frames, octet by octet. One page for each mission."""

import descriptions
import icd_messages
import layers
from ground_dictionary import dictionary
from page import escape, shell, table
from source import STATES

LINKS = "<p>A provided port has one writer and any number of readers. Each of its links is opened, closed and lost independently.</p>"
TELECOMMANDS = {
    (3, 1): "create a housekeeping structure", (3, 3): "delete structures", (3, 5): "enable reports", (3, 6): "disable reports",
    (3, 27): "one-shot report", (3, 31): "modify the interval", (5, 5): "enable event reports", (5, 6): "disable event reports",
    (8, 1): "perform a function", (17, 1): "are-you-alive", (20, 1): "report parameters", (20, 3): "set parameters",
    (129, 1): "request a state", (129, 3): "select a configuration", (129, 6): "reload the descriptor", (130, 3): "request a link",
    (130, 6): "open a link", (131, 1): "set the mode", (131, 3): "select the packet log", (131, 6): "start a process",
    (131, 7): "stop a process",
}


def mono(text):
    """Cell in the typeface of code."""
    return f'<span class="mono">{escape(text)}</span>'


def type_of(item, subsystem=None):
    """Type of a field, such as DOUBLE[2], with its enumeration."""
    text = mono(item["type"] + (f"[{item['count']}]" if item.get("count", 1) > 1 else ""))
    if "enumeration" not in item:
        return text
    return f'{text} <a class="mono" href="#{subsystem["name"].lower()}-enumeration-{item["enumeration"].lower()}">{item["enumeration"]}</a>'


def number(value):
    """Text of a bound; empty for None."""
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def bounds(item):
    """Text `min .. max` of a field. Empty if the field has no bounds or an enumeration, whose numbers are listed elsewhere."""
    if "enumeration" in item:
        return ""
    low, high = number(item.get("min")), number(item.get("max"))
    return f"{low} .. {high}" if low or high else ""


def initially(subsystem, item):
    """Initial value of a field. Numbers of an enumeration are given by their names."""
    text = item["init"] or ""
    if "enumeration" in item:
        words = {str(number): word for word, number in subsystem["enumerations"][item["enumeration"]].items()}
        text = " ".join(words[number] for number in text.split())
    return escape(text)


def unit(item):
    """Unit of a field, what its number counts, or the kind of an identifier."""
    return escape(item["unit"] or item.get("quantity") or item.get("kind", ""))


def meaning(item):
    """Description of a field, the words for its numbers, and its warning limit."""
    numbers = item.get("words", {"numbers": {}})["numbers"]
    words = "".join(f"<br>{number}: {mono(word)}" for number, word in numbers.items())
    if "bits" in item:
        states = "".join(f"<br>mask 0x{mask:02X}, 0x{value:02X}: {mono(name)}" for mask, value, name in item["bits"]["states"])
        words = states + "".join(f"<br>bit {bit}: {mono(name)}" for bit, name in item["bits"]["flags"].items())
    warning = f"; warning above {number(item['warning'])}" if "warning" in item else ""
    return escape(item.get("description", "") + warning) + words


def octets_of(item, sizes):
    return sizes[item["type"]] * item.get("count", 1)


def parameters(subsystem, sizes):
    """Table of all parameters. The fields of a structure follow it with their offset in the structure."""
    rows, kinds = [], []
    for item in subsystem["parameters"]:
        anchor = f'<a id="{subsystem["name"].lower()}-{item["name"].lower()}"></a>'
        mark = ' <span class="chip">settable</span>' if item["settable"] else ""
        first = [anchor + mono(item["name"]) + mark, mono(f"0x{item['parameter_id']:08X}")]
        if item["type"] == "STRUCT":
            rows.append([*first, mono("STRUCT"), "0", item["size"], "", "", "", ""])
            kinds.append("")
            at = 0
            for field in item["fields"]:
                size = octets_of(field, sizes)
                rows.append([mono(field["name"]), "", type_of(field, subsystem), at, size, unit(field), bounds(field), initially(subsystem, field), meaning(field)])
                kinds.append("in")
                at += size
        else:
            rows.append([*first, type_of(item, subsystem), "0", item["size"], unit(item), bounds(item), initially(subsystem, item), meaning(item)])
            kinds.append("")
    return table(["parameter", "id", "type", "offset", "octets", "unit", "range", "initial value", "meaning"], rows, (3, 4), kinds)


def enumerations(subsystem, _):
    """Table of enumerations with their numbers."""
    rows = []
    for name, numbers in subsystem["enumerations"].items():
        anchor = f'<a id="{subsystem["name"].lower()}-enumeration-{name.lower()}"></a>'
        rows.append([anchor + mono(name), "<br>".join(f"{number}: {mono(word)}" for word, number in numbers.items())])
    return table(["enumeration", "numbers"], rows)


def failures(subsystem, _):
    """Table of the failure codes that the subsystem defines itself."""
    rows = [[mono(f"0x{item['code']:04X}"), mono(item["name"]), escape(item["detail"])] for item in subsystem["failures"]]
    return table(["failure code", "meaning", "detail"], rows)


def layout(subsystem, fields, sizes, start=0):
    """Packet layout of consecutive fields."""
    rows, at = [], start
    for item in fields:
        size = octets_of(item, sizes)
        rows.append([at, size, mono(item["name"]), type_of(item, subsystem), escape(item.get("unit") or "")])
        at += size
    return table(["offset", "octets", "value", "type", "unit"], rows, (0, 1))


def refer(subsystem, name):
    """Link to a parameter of the subsystem."""
    return f'<a class="mono" href="#{subsystem["name"].lower()}-{name.lower()}">{escape(name)}</a>'


def events(subsystem, sizes):
    """Table of events with their auxiliary data."""
    rows = []
    for item in subsystem["events"]:
        at, parts = 0, []
        for value in item["parameters"]:
            if isinstance(value, dict):
                parts.append(f"{at}: {mono(value['name'])} {type_of(value, subsystem)} {unit(value)} {meaning(value)}")
                at += octets_of(value, sizes)
            else:
                parts.append(f"{at}: {refer(subsystem, value)}, sampled")
                at += next(p["size"] for p in subsystem["parameters"] if p["name"] == value)
        chip = f'<span class="chip {item["severity"]}">{item["severity"]}</span>'
        subtype = ("INFORMATIVE", "LOW", "MEDIUM", "HIGH").index(item["severity"]) + 1
        name = mono(item["name"]) + f"<br>{escape(item['description'])}"
        rows.append([item["id"], name, chip, f"TM[5,{subtype}]", "<br>".join(parts) or "none", at])
    return table(["id", "event", "severity", "report", "auxiliary data", "octets"], rows, (0, 5))


def functions(subsystem, sizes):
    """Table of functions with their arguments."""
    rows = []
    for item in subsystem["functions"]:
        arguments = [
            f"{argument['id']}: {mono(argument['name'])} {type_of(argument, subsystem)} {unit(argument)} {bounds(argument)} {meaning(argument)}"
            for argument in item["arguments"]
        ]
        states = "any" if len(item["states"]) == len(STATES) else "<br>".join(item["states"])
        every = len(item["configurations"]) == len(subsystem["configurations"])
        mark = ' <span class="chip">critical</span>' if item["critical"] else ""
        name = mono(item["name"]) + mark + f"<br>{escape(item['description'])}"
        rows.append([name, "<br>".join(arguments) or "none", states, "any" if every else "<br>".join(item["configurations"])])
    return table(["function", "arguments (id: name, type, unit, range)", "states", "configurations"], rows)


def structure(subsystem, item):
    """Heading and layout of a housekeeping report."""
    size_of = {p["name"]: p["size"] for p in subsystem["parameters"]}
    rows, at = [], 0
    for name in item["once"]:
        rows.append([at, size_of[name], refer(subsystem, name), "once"])
        at += size_of[name]
    for part in item["repeated"]:
        each = sum(size_of[name] for name in part["parameters"])
        for name in part["parameters"]:
            rows.append([at, size_of[name], refer(subsystem, name), f"{part['nrep']} times, {each} octets apart"])
            at += size_of[name]
        at += each * (part["nrep"] - 1)
    off = "" if item["enabled"] else ", disabled at first"
    loop = f" of loop {item['loop']}" if item["loop"] else ""
    display = ", display structure" if item["display"] else ""
    every = f"every {item['interval']} cycles{loop}, {item['period_us'] / 1e6:g} s{off}{display}"
    return f"<p>Structure <b>{item['id']}</b>: {every}; {at} octets</p>" + table(["offset", "octets", "parameter", "sampled"], rows, (0, 1))


def ports(subsystem, title, items, sizes):
    """Ports of a configuration with the layout of their samples."""
    parts = []
    for item in items:
        needs = "" if title == "provides" else f", {'required' if item['required'] else 'optional'}, stale after {item['stale_us'] / 1000:g} ms"
        head = f"{title} <b class='mono'>{item['name']}</b>, port {item['id']}: {item['octets']} octets each {item['period_us'] / 1000:g} ms{needs}"
        code = mono(f"0x{item['layout_hash']:08X}")
        parts.append(f"<p>{head}; by {', '.join(item['methods'])}; layout hash {code}</p>" + layout(subsystem, item["layout"], sizes))
    return "".join(parts)


def devices(items):
    """Devices of a configuration with end nodes and settings."""
    rows = []
    for item in items:
        ends = "<br>".join(escape(" ".join(f"{key} {value}" for key, value in end.items())) for end in item["endnodes"])
        settings = "<br>".join(mono(f"{s['object']} = {s['value']} ({s['type']})") for s in item["settings"])
        rows.append([mono(item["name"]), mono(item["type"]), ends, settings])
    return table(["device", "class", "end node", "settings, in this order"], rows) if rows else ""


def configuration(subsystem, item, sizes):
    anchor = f"{subsystem['name'].lower()}-configuration-{item['name'].lower()}"
    loops = "".join(
        f" Loop {loop['name']}: {loop['sampling_us'] / 1000:g} ms, priority {loop['priority']}"
        + "".join(f", ST[{number:02}]" for number in loop["services"]) + "."
        for loop in item["loops"])
    head = f'<h3 id="{anchor}">Configuration {item["name"]}, id {item["id"]}</h3><p>Cycle {item["sampling_us"] / 1000:g} ms, priority {item["priority"]}.{loops}</p>'
    reports = "".join(structure(subsystem, part) for part in item["housekeeping"])
    return head + reports + ports(subsystem, "provides", item["provides"], sizes) + ports(subsystem, "requires", item["requires"], sizes) + devices(item["devices"])


def subsystem_section(subsystem, sizes):
    name = subsystem["name"]
    hashes = f"interface {mono(subsystem['interface_hash'])}, configuration {mono(subsystem['configuration_hash'])}"
    parts = [f'<h2 id="{name.lower()}">{name}</h2><p class="sub">APID {subsystem["apid"]}, executable <code>{subsystem["executable"]}</code>; {hashes}</p>']
    for title, items, show in (
        ("Enumerations", "enumerations", enumerations), ("Parameters", "parameters", parameters), ("Events", "events", events),
        ("Functions", "functions", functions), ("Failure codes", "failures", failures),
    ):
        if subsystem[items]:
            parts.append(f"<h3>{title}</h3>{show(subsystem, sizes)}")
    parts += [configuration(subsystem, item, sizes) for item in subsystem["configurations"]]
    return "".join(parts)


def permissions(content):
    rows = []
    for rule in content["permissions"]:
        kind = (rule["service"], rule["subtype"])
        states = "any" if len(rule["states"]) == len(STATES) else ", ".join(rule["states"])
        rows.append([f"TC[{kind[0]},{kind[1]}]", TELECOMMANDS.get(kind, ""), mono(rule["select"]), mono(rule["to"]), ", ".join(rule["modes"]), states])
    return table(["telecommand", "", "selected", "to", "modes", "states"], rows)


def link_drawing(links):
    """Drawing of the links: an arrow from each producer to each consumer, dashed if the link is not required."""
    lines = ['digraph{rankdir=LR;bgcolor="transparent";node[shape=box,style="rounded,filled",color="#c9d0d8",fillcolor="#eaf1fa",'
             'fontname="Helvetica",fontsize=11];edge[color="#9aa5b1",arrowsize=.6,fontname="Helvetica",fontsize=9]']
    for link in links:
        style = "solid" if link["required"] else "dashed"
        lines.append(f'"{link["producer"]}"->"{link["consumer"]}"[label="{link["name"]}\\n{link["from"]}",style={style}]')
    return layers.svg("\n".join([*lines, "}"]))


def mission_page(loaded):
    """(file, title, HTML) of a mission."""
    content = descriptions.describe(dictionary(loaded), descriptions.load())
    sizes = {name: item["size"] for name, item in content["types"].items()}
    file, title = f"icd-{content['mission']}.html", f"ICD of {content['mission']}"
    members = [[s["apid"], f'<a href="#{s["name"].lower()}">{s["name"]}</a>', mono(s["executable"]), "yes" if s["autostart"] else "no"] for s in content["subsystems"]]
    links = [[l["number"], mono(l["name"]), f"{l['from']}, port {l['producer_port']}", f"{l['to']}, port {l['consumer_port']}", "yes" if l["required"] else "no"] for l in content["links"]]
    buses = [[mono(b["name"]), b["bit_rate"] // 1000, b["data_bit_rate"] // 1000 or ""] for b in content["buses"]]
    body = (
        f'<h1>{title}</h1><p class="sub">Made from the descriptors. Octets are big-endian; packets are CCSDS space packets with ECSS-E-ST-70-41C services. '
        f"Interface {mono(content['interface_hash'])}, configuration {mono(content['configuration_hash'])}; mission time 0 is {content['epoch_tai']} TAI; "
        f"ground port {content['ground']['address']}:{content['ground']['port']}.</p>"
        + '<h2 id="subsystems">Subsystems</h2>' + table(["APID", "subsystem", "executable", "autostart"], members, (0,))
        + '<h2 id="links">Real-time links</h2>' + (LINKS + link_drawing(content["links"]) + table(["number", "link", "from", "to", "required"], links, (0,)) if links else "<p>None.</p>")
        + '<h2 id="buses">Buses</h2>' + table(["bus", "kbit/s", "data phase kbit/s"], buses, (1, 2))
        + '<h2 id="permissions">Permissions</h2><p>A request that is not listed is refused, except requests for reports and values, ST[17], '
        "requests for a lower state or ERROR_OPERATIONAL, closing a link, and the shutdown of the mission.</p>" + permissions(content)
        + "".join(subsystem_section(item, sizes) for item in content["subsystems"])
    )
    contents = [(2, anchor, anchor.capitalize()) for anchor in ("subsystems", "links", "buses", "permissions")]
    for item in content["subsystems"]:
        contents.append((2, item["name"].lower(), item["name"]))
        contents += [(3, f"{item['name'].lower()}-configuration-{c['name'].lower()}", c["name"]) for c in item["configurations"]]
    return file, title, shell(file, title, body, contents)


def pages(missions):
    """Dict file -> HTML: a page for each mission, and an index of them."""
    made = [mission_page(loaded) for loaded in missions]
    cards = "".join(f'<a href="{file}"><b>{title}</b><span>{len(loaded.subsystems)} subsystems</span></a>' for (file, title, _), loaded in zip(made, missions))
    cards += f'<a href="{icd_messages.FILE}"><b>{icd_messages.TITLE}</b><span>every request and report, octet by octet</span></a>'
    front = shell("icd.html", "Interface control", f'<h1>Interface control documents</h1><p class="sub">Made from the descriptors, one document for each mission, and from the catalogue of messages.</p><div class="cards">{cards}</div>')
    return {"icd.html": front, icd_messages.FILE: icd_messages.page(), **{file: text for file, _, text in made}}
