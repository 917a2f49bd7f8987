# SPDX-License-Identifier: Apache-2.0
"""`gse monitor`: a live view of the flight in a terminal, also over ssh. It shows states, modes, links, housekeeping with units and age,
events, and commands with their verification, and ends with the flight. It uses the hub of the light station as a separate ground user. It needs
the package textual."""

import asyncio
import contextlib
import pathlib
import time

from rich.markup import escape
from rich.text import Text
from textual.app import App
from textual.containers import Horizontal, Vertical
from textual.suggester import Suggester
from textual.widgets import DataTable, Input, RichLog, Static

from . import completion, values
from .command import UsageError, words_of
from .run_directory import FACTS, end_of
from .station.hub import Hub
from .station.lights import LIGHTS

REFRESH_S = 0.25  # Time between two updates of the views.
GONE_S = 20.0  # If `communication` restarts, there is a link again within a shorter time.
STALE_S = 5.0  # A value that is older is shown dimmed, whatever its interval is.
COMMANDS_SHOWN = 50
STYLES = {"INFORMATIVE": "", "LOW": "cyan", "MEDIUM": "yellow", "HIGH": "bold red"}
STATE_STYLES = {"OPERATIONAL": "green", "ERROR_OPERATIONAL": "bold red"}
MARKS = {"done": "+", "failed": "x", "waiting": ".", "none": "-", "empty": " "}


class _Names(Suggester):
    """Completes the typed command with names of the flight's dictionary."""

    def __init__(self, hub):
        super().__init__(use_cache=False, case_sensitive=True)
        self._hub = hub

    async def get_suggestion(self, value):
        if self._hub.dictionary is None:
            return None
        words = value.split(" ")
        found = completion.candidates([word for word in words[:-1] if word] + words[-1:], self._hub.dictionary)
        return f"{' '.join([*words[:-1], ''])}{found[0]}" if found and words[-1] else None


class Monitor(App):
    """The dashboard of one run directory."""

    CSS = """
    #head { height: 1; background: $primary-background; }
    #views { height: 2fr; }
    #left { width: 1fr; }
    #states, #links { height: 1fr; border: round $primary; }
    #housekeeping { width: 1fr; border: round $primary; }
    #events, #commands { height: 1fr; border: round $primary; }
    """
    BINDINGS = [("ctrl+q", "quit", "leave")]
    ENABLE_COMMAND_PALETTE = False

    def __init__(self, run, **given):
        """run: run directory, or a link to it; given: arguments that replace those of the run directory (see Hub)."""
        super().__init__()
        self.hub = Hub(run, self._take, **given)
        self._new_events, self._task = [], None
        self._linked_at = None  # Monotonic time at which the link was last open; None before the first time.

    def compose(self):
        """The views."""
        yield Static(id="head")
        with Horizontal(id="views"):
            with Vertical(id="left"):
                yield DataTable(id="states", cursor_type="none")
                yield DataTable(id="links", cursor_type="none")
            yield DataTable(id="housekeeping", cursor_type="none")
        yield RichLog(id="events", max_lines=1000)
        yield DataTable(id="commands", cursor_type="none", show_header=False)
        yield Input(id="command", suggester=_Names(self.hub))

    def on_mount(self):
        """Set up the tables, and begin to follow the flight."""
        titles = {"states": ("subsystem", "state", "phase", "configuration", "since [s]"), "links": ("link", "state", "sent", "received", "lost", "late"),
                  "housekeeping": ("parameter", "value", "unit", "age [s]"), "commands": ("at [s]", "text", *LIGHTS, "result")}
        for name, columns in titles.items():
            table = self.query_one(f"#{name}", DataTable)
            table.border_title = name
            for column in columns:
                table.add_column(column, key=column)
        self.query_one("#events").border_title = "events"
        entry = self.query_one("#command")
        entry.border_title = "a command of gse, for example: ping all (Ctrl Q leaves)"
        entry.focus()
        self._task = asyncio.create_task(self.hub.serve())
        self.set_interval(REFRESH_S, self._refresh)

    async def on_unmount(self):
        """End the connection."""
        self._task.cancel()
        with contextlib.suppress(asyncio.CancelledError, BaseExceptionGroup):
            await self._task

    def on_input_submitted(self, message):
        """Perform the command that the user has entered."""
        if not message.value.strip():
            return
        line = message.value
        message.input.value = ""
        message.input.border_subtitle = ""
        try:
            if words_of(line)[0] in ("hand", "fault", "pause", "resume", "step", "speed"):
                self.run_worker(self._live(line))
            else:
                self.hub.command(line)
        except (UsageError, ValueError) as problem:
            message.input.border_subtitle = escape(str(problem))

    async def _live(self, line):
        answer = await self.hub.live(line)
        words = f"refused: {answer['refused']}" if "refused" in answer else f"at {answer['time']:.4f} s"
        self.query_one("#command", Input).border_subtitle = escape(f"{line}: {words}")

    def _take(self, message):
        if message["kind"] == "event":
            self._new_events.append(message)
        elif message["kind"] in ("hello", "mismatch"):
            self._new_events.append(message)

    # Contents of the views ----------------------------------------------------------------------------------

    def _link_rows(self):
        network = self.hub.network
        if self.hub.is_linked:
            network.keep()
        rows = network.message["rows"] if network.message else []
        return {row["name"]: [row["name"], row["state"], *(row.get(key, "") for key in ("sent", "received", "lost", "late"))] for row in rows}

    def _look(self):
        """Leave after the end of the flight, with (words about the end, exit code of the flight or None if it is not known)."""
        if self.hub.is_linked:
            self._linked_at = time.monotonic()
        elif self._linked_at is not None:
            run = pathlib.Path(self.hub.flight[0])
            if (run / FACTS).exists():
                self.exit(end_of(run))
            elif time.monotonic() - self._linked_at >= GONE_S:
                self.exit((f"{run}: the flight is gone: for {GONE_S:.0f} s there was no link, and it has left no {FACTS}; see {run}/console.log", None))

    def _refresh(self):
        if not self.query("#head"):
            return  # The application ends.
        self._look()
        hub = self.hub
        mission = hub.dictionary.mission if hub.dictionary else "no flight"
        mode = hub.session.mode if hub.session else None
        pace = "paused" if hub.pace["is_paused"] else f"x{hub.pace['speed']:g}" if hub.pace["is_there"] else ""
        seconds = f"{hub.seconds:.1f} s" if hub.seconds is not None else "-"
        link = Text(hub.link["text"], "green" if hub.link["is_live"] else "bold red")
        self.query_one("#head", Static).update(Text("  ").join([Text(mission, "bold"), Text(f"mode {mode or '-'}"), Text(seconds), Text(pace), link]))
        self._fill("states", {name: self._state_row(state) for name, state in hub.states.items()})
        self._fill("links", self._link_rows())
        self._fill("housekeeping", self._housekeeping_rows())
        self._fill("commands", {str(call.number): self._command_row(call) for call in reversed(list(hub.commands)[-COMMANDS_SHOWN:])})
        self._write_events(self.query_one("#events", RichLog))

    def _write_events(self, log):
        for event in self._new_events:
            if event["kind"] == "hello":
                log.clear()
            elif event["kind"] == "mismatch":
                if event["words"]:
                    log.write(Text(f"warning: {event['words']}", "yellow"))
            else:
                text = f"{event['time']:12.6f}  {event['severity']:<11} {event['subsystem']}.{event['event']}  {event['text']}"
                log.write(Text(text, STYLES.get(event["severity"], "")))
        self._new_events.clear()

    def _fill(self, name, rows):
        """Show these rows. Only cells that have changed are drawn, so that a slow connection transfers little."""
        table = self.query_one(f"#{name}", DataTable)
        if [key.value for key in table.rows] != list(rows):
            table.clear()
            for key, row in rows.items():
                table.add_row(*row, key=key)
            return
        for key, row in rows.items():
            for column, cell in zip(table.columns, row):
                if table.get_cell(key, column) != cell:
                    table.update_cell(key, column, cell, update_width=True)

    @staticmethod
    def _state_row(state):
        since = "-" if state["since"] is None else f"{state['since']:.1f}"
        return [state["subsystem"], Text(state["state"], STATE_STYLES.get(state["state"], "")), state["phase"], state["configuration"], since]

    def _housekeeping_rows(self):
        newest = {}
        for (subsystem, _), report in self.hub.housekeeping.items():
            for leaf, value in report["values"].items():
                key = f"{subsystem}.{leaf}"
                if key not in newest or newest[key][0] < report["time"]:
                    newest[key] = (report["time"], value, subsystem, leaf)
        subsystems = self.hub.dictionary.subsystems if newest else {}
        order = sorted(newest, key=lambda key: (subsystems[newest[key][2]].is_infrastructure, key))
        return {key: self._value_row(key, *newest[key]) for key in order}

    def _value_row(self, key, seconds, value, subsystem, leaf):
        head, _, tail = leaf.partition(".")
        item = self.hub.dictionary.subsystem(subsystem).parameter(head)
        item = item.field(tail)[0] if tail else item
        numbers = [number for number in value if isinstance(number, (int, float))]
        is_beyond = any((item.min is not None and number < item.min) or (item.max is not None and number > item.max) for number in numbers)
        age = self.hub.seconds - seconds
        return [key, Text(values.to_text(value), "bold red" if is_beyond else ""), item.unit, Text(f"{age:.1f}", "dim" if age > STALE_S else "")]

    @staticmethod
    def _command_row(call):
        message = call.message()
        lights = [Text(f"{MARKS[light]} {name}" if light != "empty" else "", "red" if light == "failed" else "") for name, light in zip(LIGHTS, message["lights"])]
        result = Text(message.get("words") or "; ".join(message["answer"]), "red" if "words" in message else "")
        return ["-" if message["time"] is None else f"{message['time']:.1f}", message["text"], *lights, result]
