# SPDX-License-Identifier: Apache-2.0
"""Completion of commands with the names of the dictionary, for bash, zsh and `gse shell`.

The shells call `gse complete WORD...` with the words up to the cursor; the last one is completed. Its output has one candidate a line;
after a candidate that ends with a blank, the next word begins.
"""

import glob
import os

from . import usage
from .commands import REST_STATES

OPTIONS = ("--host", "--port", "--dictionary", "--timeout", "--key", "--json", "--run", "--help", "--version")
OPTIONS_WITH_VALUE = ("--host", "--port", "--dictionary", "--timeout", "--key", "--run", "--listen", "--http-port", "--cosimulation")
OPTIONS_WITH_FILE = ("--dictionary", "--key", "--run", "--cosimulation")

BASH = """\
# Completion of gse for bash: eval "$(gse completion bash)"
_gse()
{
    local IFS=$'\\n' word="${COMP_LINE:0:COMP_POINT}"
    local -a words
    # Split at blanks only: bash splits at = and :, too.
    IFS=$' \\t' read -r -a words <<<"$word"
    [[ "$word" == *[[:blank:]] ]] && words+=("")
    local last="${words[${#words[@]}-1]}" cut=""
    # If a word contains = or :, bash replaces only the part after this character.
    [[ "$last" == *[=:]* ]] && cut="${last%"${last##*[=:]}"}"
    local candidate
    COMPREPLY=()
    while IFS= read -r candidate; do
        COMPREPLY+=("${candidate#"$cut"}")
    done < <("${words[0]/#\\~/$HOME}" complete -- "${words[@]:1}" 2>/dev/null)
}
complete -o nospace -F _gse gse gse/gse build/venv/bin/gse
"""

ZSH = """\
#compdef gse
# Completion of gse for zsh: eval "$(gse completion zsh)"
_gse()
{
    local -a candidates ended open
    candidates=("${(@f)$("${words[1]/#\\~/$HOME}" complete -- "${(@)words[2,CURRENT]}" 2>/dev/null)}")
    ended=("${(@)${(@M)candidates:#* }% }")
    open=("${(@)candidates:#* }")
    compadd -U -- "${(@)ended:#}"
    compadd -U -S '' -- "${(@)open:#}"
}
compdef _gse gse gse/gse build/venv/bin/gse
"""


def _end(words):
    return [f"{word} " for word in words]


def _files(prefix):
    return [f"{path}/" if os.path.isdir(path) else f"{path} " for path in sorted(glob.glob(f"{glob.escape(os.path.expanduser(prefix))}*"))]


def _assigned(prefix, known):
    """Candidates for NAME=VALUE: names that are not given yet, or words of the value. known: name -> words, empty if it has none."""
    name, sign, value = prefix.partition("=")
    if not sign:
        return [f"{name}=" for name in known]
    earlier, _, _ = value.rpartition(",")
    words = next((words for key, words in known.items() if key.upper() == name.upper()), ())
    return [f"{name}={earlier}{',' if earlier else ''}{word}" for word in words]


class _Names:
    """Candidates for a word that the usage writes in upper case. bound: the words before it, by their names in the usage."""

    def __init__(self, dictionary, bound, prefix):
        self._dictionary, self._bound, self._prefix = dictionary, bound, prefix

    def _subsystem(self):
        return self._dictionary.subsystem(self._bound["SUBSYSTEM"])

    def _given(self):
        return {word.partition("=")[0].upper() for word in self._bound.get("given", ())}

    def subsystem(self):
        return _end(self._dictionary.subsystems)

    def subsystem_function(self):
        return [f"{one.name}.{name} " for one in self._dictionary.subsystems.values() for name in one.functions]

    def subsystem_parameter_field(self):
        is_set = self._bound["verb"] == "set"
        found = []
        for one in self._dictionary.subsystems.values():
            for item in one.parameters.values():
                if item.settable or not is_set:
                    found.append(f"{one.name}.{item.name} ")
                    found += [f"{one.name}.{item.name}.{field.name} " for field in item.fields]
        return found if self._prefix.count(".") > 1 else [name for name in found if name.count(".") == 1]

    def value(self):
        name, _, rest = self._bound.get("SUBSYSTEM.PARAMETER[.FIELD]", "").partition(".")
        head, _, field = rest.partition(".")
        item = self._dictionary.subsystem(name).parameter(head)
        item = item.field(field)[0] if field else item
        earlier, comma, _ = self._prefix.rpartition(",")
        return [f"{earlier}{comma}{word}" for word in (item.words or {}).values()]

    def argument_value(self):
        name, _, function = self._bound["SUBSYSTEM.FUNCTION"].partition(".")
        known = {item.name: (item.words or {}).values() for item in self._dictionary.subsystem(name).function(function).arguments}
        return _assigned(self._prefix, {key: words for key, words in known.items() if key.upper() not in self._given()})

    def field_value(self):
        service, _, subtype = self._bound["SERVICE,SUBTYPE"].partition(",")
        catalogue = self._dictionary.catalogue
        entry = catalogue.find("TC", int(service), int(subtype)) or {"fields": []}
        names = [field.get("name") or field.get("repeat") for field in entry["fields"]]
        known = {name: list(catalogue.words(int(service), name).values()) for name in names if name and name not in self._given()}
        return _assigned(self._prefix, known)

    def service_subtype(self):
        return _end(f"{entry['service']},{entry['subtype']}" for entry in self._dictionary.catalogue.all("TC"))

    def state(self):
        return _end(REST_STATES)

    def configuration(self):
        return _end(self._subsystem().configurations)

    def structure(self):
        return _end(sorted({str(number) for item in self._subsystem().configurations.values() for number in item.structures}))

    def parameter(self):
        return _end(self._subsystem().parameters)

    def event(self):
        return _end(self._subsystem().events)

    def link(self):
        return _end(item.name for item in self._dictionary.links)

    def mode(self):
        return _end(item["name"] for item in self._dictionary.modes)

    def bus(self):
        return _end(item["name"] for item in self._dictionary.buses)

    def process(self):
        return _end(item["executable"] for item in self._dictionary.content["subsystems"])

    def _devices(self, is_wanted):
        every = [
            device
            for item in self._dictionary.content["subsystems"]
            for configuration in item["configurations"]
            for device in configuration.get("devices", ())
            if any(is_wanted(end) for end in device["endnodes"])
        ]
        return _end(dict.fromkeys(device["name"] for device in every))

    def device(self):
        bus = self._bound.get("BUS|INSTRUMENT", self._bound.get("BUS"))
        return self._devices(lambda end: bus in (end.get("bus"), end.get("redundantBus")))

    def joint(self):
        return self._devices(lambda end: "bus" in end)

    def instrument(self):
        return self._devices(lambda end: "bus" not in end)

    def file(self):
        return _files(self._prefix)

    run = file


def _of_token(token, dictionary, bound, prefix):
    """Candidates for one word of a form of a command (usage.py)."""
    found = []
    for part in token.split("|"):
        if part.islower() or part == "-f":
            found.append(f"{part} ")
            continue
        names = getattr(_Names(dictionary, bound, prefix), part.lower().translate(str.maketrans({".": "_", "=": "_", ",": "_", "[": None, "]": None})), None)
        try:
            found += names() if names else []
        except (ValueError, KeyError):
            pass  # A word before this one is not in the dictionary.
    return found


def _fits(token, word):
    parts = token.split("|")
    return word in parts or any(not part.islower() for part in parts)


def _of_form(form, words, dictionary):
    """Candidates for the last word by one form of a command."""
    bound, at = {"verb": form[0], "given": words[:-1]}, 1
    for index, word in enumerate(words[1:-1], 1):
        if at >= len(form):
            return []
        token = form[at]
        if "COMMAND" in form[at : at + 2] and word in usage.table():
            return candidates(words[index:], dictionary)
        if not _fits(token, word):
            if word.startswith("-") or token != "-f":
                return []
            at += 1
            if at >= len(form):
                return []
            token = form[at]
        bound[token] = word
        if "SUBSYSTEM" in token.split("|"):
            bound["SUBSYSTEM"] = word
        if form[at + 1 : at + 2] != ["..."]:
            at += 1
    if at >= len(form):
        return []
    if "COMMAND" in form[at : at + 2]:
        return candidates(words[-1:], dictionary)
    found = _of_token(form[at], dictionary, bound, words[-1])
    is_optional = form[at] == "-f" and at + 1 < len(form)
    return found + (_of_token(form[at + 1], dictionary, bound, words[-1]) if is_optional else [])


def candidates(words, dictionary):
    """Candidates for the last of these words, the first of which is the name of a command. A blank at the end of a candidate ends the word."""
    if len(words) == 1:
        found = _end(usage.table())
    elif words[0] in usage.table():
        found = [one for form in usage.forms(words[0]) for one in _of_form(form, words, dictionary)]
    else:
        found = []
    prefix = words[-1].upper()
    return [one for one in dict.fromkeys(found) if one.upper().startswith(prefix)]


def complete(words, load):
    """Candidates for the last word of a command line with options. load() returns the dictionary for the options that were found."""
    options, rest, words = {}, [], list(words) or [""]
    at = 0
    while at < len(words) - 1:
        if words[at] in OPTIONS_WITH_VALUE:
            if at + 1 == len(words) - 1:
                return _files(words[-1]) if words[at] in OPTIONS_WITH_FILE else []
            options[words[at]] = words[at + 1]
            at += 1
        elif not words[at].startswith("--"):
            rest.append(words[at])
        at += 1
    if words[-1].startswith("--"):
        return [f"{option} " for option in OPTIONS if option.startswith(words[-1])]
    return candidates([*rest, words[-1]], load(options))
