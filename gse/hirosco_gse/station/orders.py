# SPDX-License-Identifier: Apache-2.0
"""The requests of browsers, checked: other clients may send anything."""

import json

from ..command import UsageError
from ..values import quoted

KINDS = {str: "a text", dict: "an object", list: "a list"}
# Request -> fields that it must have, with their types. A command and a plan may have "form" and "values" instead.
TEXT, FORM = {"text": str}, {"form": str, "values": dict}
FIELDS = {"command": TEXT, "plan": TEXT, "ask": TEXT, "live": {"line": str}, "structures": {"subsystem": str}, "upload": {"words": list, "data": str},
          "watch": {}, "packets": {}, "forms": {}, "script": {}}


def _wrong(found, expected):
    return UsageError(f"not understood: found {found}, expected {expected}")


def read(text):
    """The JSON object of a request. Raises UsageError."""
    try:
        order = json.loads(text)
    except (ValueError, RecursionError):
        order = None
    if not isinstance(order, dict):
        raise _wrong(quoted(text), 'a JSON object such as {"do": "command", "text": "ping all"}')
    return order


def check(order):
    """Refuse a request whose fields are missing or have the wrong type. Raises UsageError."""
    do = order.get("do")
    if not isinstance(do, str) or do not in FIELDS:
        raise _wrong(f'"do": {quoted(json.dumps(do))}' if "do" in order else 'no "do"', f'"do" with one of {", ".join(FIELDS)}')
    fields = FORM if FIELDS[do] is TEXT and do != "ask" and "form" in order else FIELDS[do]
    for name, kind in fields.items():
        if not isinstance(order.get(name), kind):
            found = f'"{name}": {quoted(json.dumps(order[name]))}' if name in order else f'no "{name}"'
            raise _wrong(f"{found} in a request {do}", f'"{name}" with {KINDS[kind]}')
    kind = order.get("kind")
    if do == "packets" and kind is not None and not (isinstance(kind, list) and all(isinstance(one, (str, int, type(None))) for one in kind)):
        raise _wrong(f'"kind": {quoted(json.dumps(kind))}', 'the "kind" of a row in the answer to {"do": "packets"}')
