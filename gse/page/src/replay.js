// SPDX-License-Identifier: Apache-2.0
// Replay of a recorded flight: sets the store to the contents that it had at a given instant of the flight.

import { store } from "./store.js";
import { after, History } from "./history.js";
import { posesBetween } from "./kinematics.js";

const KEPT_COMMANDS = 500;
const TO_COME = "eeee"; // Lights of a command that is sent later.
// A gap between reports [s] in which the robot is not drawn; time after the last report in which it is
// drawn.
const GAP_S = 1,
  LAST_S = 3;
const LIGHTS = { d: "done", f: "failed", w: "waiting", n: "none", e: "empty" };
const same = (name) => name;
const NAMES = {
  POSITION: "CUR_VALUES.POSITION",
  VELOCITY: "CUR_VALUES.VELOCITY",
  TORQUE: "CUR_VALUES.TORQUE",
  EXTERNAL_TORQUE: "CUR_VALUES.EXTERNAL_TORQUE",
};

export class Replay {
  constructor(recording) {
    Object.assign(this, {
      about: recording.about,
      end: recording.end,
      phases: recording.phases,
      names: recording.truth,
    });
    this.isPlaying = false;
    this.speed = 1;
    this.time = 0;
    store.replay = this;
    store.take({
      ...(recording.hello ?? { subsystems: [], links: [], modes: [], states: [], verbs: {} }),
      kind: "hello",
    });
    store.take({
      kind: "link",
      is_live: false,
      is_replay: true,
      text: "replay: a recorded flight takes no commands",
    });
    this.index(recording);
    store.take({ kind: "ready" });
    this.pace();
    this.use(this.truth?.t.length ? "truth" : "telemetry");
    // A browser draws no page in the background; its replay stands still there.
    document.addEventListener("visibilitychange", () => (this.last = performance.now()));
  }

  index({ states = [], events = [], commands = [], links = [], modes = [], tables }) {
    this.states = new Map();
    for (const [time, subsystem, state, phase, configuration, cause] of states) {
      if (!this.states.has(subsystem)) this.states.set(subsystem, { t: [], rows: [] });
      const list = this.states.get(subsystem);
      const before = list.rows[list.rows.length - 1];
      list.t.push(time);
      list.rows.push({
        kind: "state",
        subsystem,
        state,
        phase,
        configuration,
        time,
        since: before?.state === state ? before.since : time,
        cause: cause ?? (before?.state === state ? before.cause : null),
        targets: {},
      });
    }
    this.lanes = new Map(
      [...this.states].map(([name, { rows }]) => [
        name,
        rows.filter((row, n) => row.state !== rows[n - 1]?.state).map((row) => [row.time, row.state]),
      ]),
    );
    store.lanes = this.lanes;
    this.events = events.map(([time, subsystem, severity, event, text, device, values], number) => ({
      kind: "event",
      number,
      time,
      subsystem,
      severity,
      event,
      text,
      device,
      values,
    }));
    this.eventTimes = events.map(([time]) => time);
    this.commands = commands.map((call, n) => ({ kind: "command", number: n + 1, answer: [], ...call }));
    this.changes = commands
      .flatMap((call) => [...call.lights, ...(call.led_to?.rows ?? [])].map(([time]) => time))
      .sort((a, b) => a - b);
    this.links = { t: links.map(([time]) => time), rows: [] };
    let present = [];
    for (const [, name, facts] of links) {
      present = [
        ...present.filter((row) => row.name !== name),
        { ...present.find((row) => row.name === name), name, ...facts },
      ];
      this.links.rows.push(present);
    }
    this.modes = { t: modes.map(([time]) => time), rows: modes.map(([, mode]) => mode) };
    this.housekeeping = tables.filter((table) => table.kind === "housekeeping");
    this.heard = tables.filter((table) => table.kind === "heard");
    const source = store.members().find((item) => store.drives(item))?.name;
    this.source = source;
    this.telemetry = new History(
      this.housekeeping.filter(
        (table) => table.subsystem === source && table.leaves.has("CUR_VALUES.POSITION"),
      ),
      same,
      3,
    );
    const truth = tables.find((table) => table.kind === "truth");
    this.truth = truth ? new History([truth], (name) => NAMES[name] ?? name, GAP_S) : null;
    for (const name of new Set(this.housekeeping.map((table) => table.subsystem))) {
      if (name !== source)
        store.history.set(
          name,
          new History(
            this.housekeeping.filter(
              (table) => table.subsystem === name && table.leaves.has("CUR_VALUES.POSITION"),
            ),
            same,
            3,
          ),
        );
    }
  }

  // Select the source that moves the robot of the scene and is drawn in the strips: "telemetry" or "truth".
  // `film` is the history of this source.
  use(which) {
    this.film = this[which] ?? this.telemetry;
    this.which = which;
    store.history.set(this.source, this.film);
    store.tell("source", which);
    this.seek(this.time);
  }

  // Show the requests that stations sent by themselves, too, or only those of operators, as a flight does.
  showOwn(is) {
    this.hasOwn = is;
    this.shownChanges = null;
    this.showLists();
  }

  pace() {
    store.tell("player");
  }

  play(is) {
    if (is && this.time >= this.end) this.seek(0);
    this.isPlaying = is;
    this.last = performance.now();
    cancelAnimationFrame(this.coming);
    if (is) this.ahead();
    this.pace();
  }

  // Ask the browser for the next picture, as long as the replay plays.
  ahead() {
    this.coming = requestAnimationFrame((now) => {
      this.seek(this.time + (Math.max(0, now - this.last) / 1000) * this.speed);
      this.last = Math.max(now, this.last);
      if (this.time >= this.end) this.play(false);
      else this.ahead();
    });
  }

  fast(speed) {
    this.speed = speed;
    this.pace();
  }

  // Row of a history at a time, interpolated linearly between two reports. Null in a gap, more than GAP_S
  // before the first report and more than LAST_S after the last.
  at(time, film = this.film) {
    const { t } = film;
    const n = after(t, time) - 1;
    if (n < 0) return t.length && t[0] - time < GAP_S ? film.row(0) : null;
    const row = film.row(n),
      next = film.row(n + 1);
    if (!next && time - t[n] > LAST_S) return null;
    if (!row || !next || t[n + 1] <= time) return row ?? null;
    const share = (time - t[n]) / (t[n + 1] - t[n]);
    const mean = (name) =>
      row[name] && next[name]
        ? row[name].map((value, k) => value + (next[name][k] - value) * share)
        : row[name];
    return {
      ...row,
      "CUR_VALUES.POSITION": mean("CUR_VALUES.POSITION"),
      "CUR_VALUES.EXTERNAL_TORQUE": mean("CUR_VALUES.EXTERNAL_TORQUE"),
      "CUR_VALUES.TOOL_FORCE": mean("CUR_VALUES.TOOL_FORCE"),
      FORCE: mean("FORCE"),
      BASE: row.BASE && next.BASE ? posesBetween(row.BASE, next.BASE, share) : row.BASE,
    };
  }

  // The truth { row, names, time } at an instant; null if the recording has none.
  truthAt(time) {
    const row = this.truth && this.at(time, this.truth);
    return row ? { row, names: this.names, time } : null;
  }

  // Rows [time, row] of the last `seconds` before the present instant, at most since the last gap; about 150
  // of them.
  before(seconds) {
    const { t, index } = this.film;
    const end = after(t, this.time);
    let first = end;
    while (first > 0 && index[first - 1] >= 0 && t[first - 1] > this.time - seconds) first--;
    const step = Math.max(1, Math.round((end - first) / 150));
    const found = [];
    for (let n = first; n < end; n += step) found.push([t[n], this.film.row(n)]);
    return found;
  }

  seek(time) {
    this.time = store.time = Math.max(0, Math.min(this.end, time));
    this.showStates();
    this.showValues();
    this.showLists();
    store.tell("film", { time: this.time, row: this.at(this.time) });
    store.tell("player");
  }

  showStates() {
    for (const [name, { t, rows }] of this.states) {
      const row = rows[after(t, this.time) - 1];
      if (row === store.states.get(name)) continue;
      if (row) store.states.set(name, row);
      else store.states.delete(name);
      store.tell("state", row ?? { kind: "state", subsystem: name });
    }
    for (const { subsystem, t } of this.heard) {
      const at = t[after(t, this.time) - 1];
      if (at === undefined) store.heard.delete(subsystem);
      else store.heard.set(subsystem, at * 1000);
    }
  }

  showValues() {
    for (const table of this.housekeeping) {
      const n = after(table.t, this.time) - 1;
      if (n === table.shown) continue;
      table.shown = n;
      if (!store.values.has(table.subsystem)) store.values.set(table.subsystem, new Map());
      const values = store.values.get(table.subsystem);
      const time = table.t[n];
      this.report(table, n);
      for (const [leaf, parts] of table.leaves) {
        const known = values.get(leaf);
        if (known && known.table !== table && known.time > time && known.time <= this.time) continue;
        if (n < 0) {
          if (known?.table === table) values.delete(leaf);
          continue;
        }
        const period = n ? (time - table.t[n - 1]) * 1000 : 1000;
        values.set(leaf, { value: parts.map((part) => part[n]), time, at: time * 1000, period, table });
      }
    }
  }

  // Store row `n` of a table as the last report of its structure; the tab Telemetry shows it.
  report(table, n) {
    const key = `${table.subsystem}/${table.structure}`;
    if (n < 0) {
      store.reports.delete(key);
      return;
    }
    const time = table.t[n],
      values = {};
    for (const [leaf, parts] of table.leaves) values[leaf] = parts.map((part) => part[n]);
    store.reports.set(key, {
      subsystem: table.subsystem,
      id: table.structure,
      time,
      at: time * 1000,
      gap: n ? (time - table.t[n - 1]) * 1000 : 1000,
      count: n + 1,
      values,
    });
  }

  // Make the history of a structure, whose key is "SUBSYSTEM/ID", and keep it in the store.
  historyOf(key) {
    const found = new History(
      this.housekeeping.filter((table) => key === `${table.subsystem}/${table.structure}`),
      same,
      15,
    );
    store.history.set(key, found);
    return found;
  }

  showLists() {
    const events = after(this.eventTimes, this.time);
    if (events !== store.events.length) {
      store.events = this.events.slice(0, events);
      store.seen = events;
      store.tell("event", store.events[events - 1] ?? { severity: "INFORMATIVE" });
    }
    const changes = after(this.changes, this.time);
    if (changes !== this.shownChanges) {
      this.shownChanges = changes;
      const known = this.shownCommands()
        .filter((call) => call.time <= this.time)
        .slice(-KEPT_COMMANDS);
      store.commands = new Map(known.map((call) => [call.number, this.callAt(call)]));
      store.tell("command", { number: 0 });
    }
    const links = this.links.rows[after(this.links.t, this.time) - 1] ?? [];
    if (links !== store.links && (links.length || store.links.length)) {
      store.links = links;
      store.tell("links");
    }
    const mode =
      this.modes.rows[after(this.modes.t, this.time) - 1] ??
      store.hello?.modes?.find((one) => one.initial)?.name ??
      null;
    if (mode !== store.mode) {
      store.mode = mode;
      store.tell("mode");
    }
  }

  // Commands of the whole flight, with those that stations sent by themselves only if they are to be shown.
  shownCommands() {
    return this.commands.filter((call) => this.hasOwn || !call.own);
  }

  callAt(call) {
    const lights =
      call.lights.filter(([time]) => time <= this.time).pop()?.[1] ??
      (call.time > this.time ? TO_COME : "weee");
    const isOver = lights === call.lights[call.lights.length - 1][1];
    return {
      ...call,
      lights: [...lights].map((one) => LIGHTS[one]),
      over: isOver,
      words: isOver ? call.words : undefined,
      led_to: this.ledTo(call.led_to),
    };
  }

  // The reports of a command until the present instant; undefined if there are none. Only the first ones of
  // a command with many have a row.
  ledTo(all) {
    const rows = (all?.rows ?? []).filter(([time]) => time <= this.time);
    if (!rows.length) return undefined;
    return { count: rows.length < all.rows.length ? rows.length : all.count, rows };
  }
}
