# SPDX-License-Identifier: Apache-2.0
"""The layout of the documentation: one page template, one style, the Markdown subset of the project."""

import html
import pathlib
import re

import markdown

ROOT = pathlib.Path(__file__).resolve().parents[2]
NAVIGATION = (("index.html", "hirosco"), ("architecture.html", "Architecture"), ("tutorial.html", "Tutorial"), ("api.html", "API"), ("icd.html", "ICD"))
STYLE = """
:root{--ink:#242a33;--dim:#667080;--line:#dfe3e8;--soft:#f6f7f9;--link:#2f6db3;--mark:#2d7a4b}
*{box-sizing:border-box}html{scroll-padding-top:3.6em}
body{font:15px/1.55 system-ui,sans-serif;color:var(--ink);margin:0}
nav.top{position:sticky;top:0;background:#fffffff2;border-bottom:1px solid var(--line);z-index:1}
nav.top div{max-width:1180px;margin:auto;padding:.55em 1.2em;display:flex;gap:1.4em;align-items:baseline}
nav.top a{color:var(--dim);font-weight:600}nav.top a:first-child{color:var(--ink);font-weight:750;letter-spacing:.01em}
nav.top a.here{color:var(--link)}nav.top form{margin-left:auto}input,button{font:inherit}
.page{max-width:1180px;margin:auto;padding:0 1.2em 5em;display:grid;grid-template-columns:13.5em minmax(0,1fr);gap:2.6em}
.page.wide{grid-template-columns:minmax(0,1fr)}
aside{font-size:.9em;position:sticky;top:3.2em;align-self:start;max-height:calc(100vh - 3.6em);overflow:auto;padding:1.6em 0}
aside ul{list-style:none;margin:0;padding:0}aside ul ul{padding-left:.9em}aside a{color:var(--dim);display:block;padding:.08em 0}
main{min-width:0;padding-top:.6em}
h1{font-size:1.7em;margin:.6em 0 .3em;line-height:1.25}h2{font-size:1.22em;margin:2.1em 0 .5em;padding-bottom:.25em;border-bottom:1px solid var(--line)}
h3{font-size:1.02em;margin:1.5em 0 .4em}.sub{color:var(--dim);margin:0 0 1.2em}
a{color:var(--link);text-decoration:none}a:hover{text-decoration:underline}
code,pre,.mono{font-family:ui-monospace,SFMono-Regular,Menlo,monospace;font-size:.9em}
code{background:var(--soft);padding:.08em .3em;border-radius:.25em}
pre{background:var(--soft);border:1px solid #eceff2;border-radius:.4em;padding:.75em 1em;overflow:auto;line-height:1.45;font-size:.84em}
pre code{background:none;padding:0;font-size:1em}pre .c{color:#6b7684}pre .k{color:#8a4a9e}pre .p{color:#1d7a3e}pre .m{color:#b3261e}
table{border-collapse:collapse;width:100%;font-size:.92em;margin:.6em 0 1em}
td,th{padding:.32em .8em .32em 0;text-align:left;vertical-align:top}td{border-top:1px solid #eceff2}
th{color:var(--dim);font-weight:600;white-space:nowrap}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;width:1%;white-space:nowrap}
tr.in td:first-child{padding-left:1.3em}tr.in td{border-top:1px dotted #eceff2}
dl{display:grid;grid-template-columns:7.2em 1fr;gap:.25em 1em;margin:.8em 0}dt{color:var(--dim);font-weight:600}dd{margin:0}
.entry{margin:1.5em 0;padding-top:.1em}.entry pre{margin:.3em 0}.entry p{margin:.35em 0}
.chip{font-size:.8em;font-weight:600;padding:.1em .55em;border-radius:.7em;background:var(--soft);color:var(--dim)}
.chip.HIGH{background:#fbe7e5;color:#b3261e}.chip.MEDIUM{background:#fdf1dd;color:#9a5b00}.chip.LOW{background:#eaf1fa;color:#2f6db3}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(17em,1fr));gap:.9em;margin:1em 0}
.cards a{border:1px solid var(--line);border-radius:.5em;padding:.75em 1em;color:var(--ink);display:block}
.cards a:hover{border-color:var(--link);text-decoration:none}.cards b{display:block}.cards span{color:var(--dim);font-size:.92em}
.graph{overflow:auto;margin:1em 0}.graph svg{max-width:100%;height:auto}img{max-width:100%}
@media(max-width:760px){.page{grid-template-columns:minmax(0,1fr);gap:0}aside{display:none}}
@media print{nav.top,aside{display:none}.page{display:block}}
"""


def escape(text):
    return html.escape(str(text), quote=False)


def anchor(text):
    return re.sub(r"[^a-z0-9]+", "-", str(text).lower()).strip("-")


def heading_anchor(text, _=None):
    """Anchor of a heading in Markdown, as GitHub makes it, so that a link works there and in these pages."""
    return re.sub(r"[^\w\- ]", "", text.lower()).strip().replace(" ", "-")


def table(head, rows, numeric=(), classes=()):
    """Table of HTML cells. `numeric`: indices of the columns to align right; `classes`: CSS class of each row."""
    side = ["n" if index in numeric else "" for index in range(len(head))]
    mark = [f' class="{name}"' if name else "" for name in side]
    top = "".join(f"<th{m}>{cell}</th>" for m, cell in zip(mark, head))
    lines = []
    for number, row in enumerate(rows):
        kind = classes[number] if classes else ""
        cells = "".join(f"<td{m}>{cell}</td>" for m, cell in zip(mark, row))
        lines.append(f"<tr{f' class={kind}' if kind else ''}>{cells}</tr>")
    return f"<table><tr>{top}</tr>{''.join(lines)}</table>"


def shell(name, title, body, contents=()):
    """Whole page. `contents` is a list of (level, anchor, text) for the table of contents beside the text."""
    # The page of a layer or a mission (api-osal.html, icd-rokviss.html) belongs to the entry with its first three letters.
    part = next((file for file, _ in NAVIGATION if file == name or file[:3] == name[:3]), "")
    here = (' class="here"' if file == part else "" for file, _ in NAVIGATION)
    links = "".join(f'<a href="{file}"{mark}>{text}</a>' for (file, text), mark in zip(NAVIGATION, here))
    links += '<form action="search.html"><input type="search" name="q" aria-label="Search" title="Search all pages"></form>'
    items = "".join(f'<li style="padding-left:{(level - 2) * 0.9}em"><a href="#{fragment}">{text}</a></li>' for level, fragment, text in contents)
    side = f"<aside><ul>{items}</ul></aside>" if items else ""
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f'<title>{escape(title)} - hirosco</title><link rel="stylesheet" href="style.css">'
        f'<nav class="top"><div>{links}</div></nav><div class="page{"" if side else " wide"}">{side}<main>{body}</main></div></html>\n'
    )


def colour_diff(found):
    """HTML of a diff block with coloured lines."""
    lines = []
    for line in found[1].splitlines():
        kind = "c" if line[:4] in ("--- ", "+++ ") else {"+": "p", "-": "m", "@": "c"}.get(line[:1], "")
        lines.append(f'<span class="{kind}">{line}</span>' if kind else line)
    return "<pre><code>" + "\n".join(lines) + "</code></pre>"


def from_markdown(path, rename):
    """(title, HTML, contents) of a Markdown file. rename(path) returns the page of a file, or None."""
    text = path.read_text(encoding="utf-8")
    engine = markdown.Markdown(extensions=["tables", "fenced_code", "toc", "sane_lists"], extension_configs={"toc": {"slugify": heading_anchor}})
    body = engine.convert(text)
    body = re.sub(r'<pre><code class="language-diff">(.*?)</code></pre>', colour_diff, body, flags=re.DOTALL)

    def link(found):
        target, _, fragment = found[1].partition("#")
        if re.match(r"[a-z]+:", target) or not target:
            return found[0]
        page = rename((path.parent / target).resolve())
        return f'href="{page}{"#" + fragment if fragment else ""}"' if page else found[0]

    body = re.sub(r'href="([^"]*)"', link, body)
    title = re.search(r"^# (.*)$", text, re.MULTILINE)
    contents = [(token["level"], token["id"], token["name"]) for token in flatten(engine.toc_tokens) if token["level"] in (2, 3)]
    return (title[1] if title else path.stem), body, contents


def flatten(tokens):
    """Headings of all levels in order."""
    for token in tokens:
        yield token
        yield from flatten(token["children"])
