// SPDX-License-Identifier: Apache-2.0
// State of the page, updated by the messages of the station in their order. Elements subscribe to kinds of
// messages.

import { jointsOf } from "./kinematics.js";

const EVENTS_KEPT = 10000;
const HISTORY_S = 600; // Time for which reports are stored.
const RETRY_MS = 500; // Time between two attempts to connect.
// The station sends a message at least every 0.5 s. Time without any after which it is silent, and time
// between two checks of that.
const SILENT_MS = 1000,
  CHECK_MS = 200;
const LEAST_PERIOD_MS = 350; // Shortest period that freshness uses: faster reports may arrive in groups.

class Store {
  constructor() {
    this.listeners = new Map();
    this.waiting = new Map();
    this.next = 1;
    this.offset = null; // Mission time minus the clock of the page [s].
    this.hasSocket = false;
    this.isSilent = false; // The connection to the station is open, but nothing arrives.
    this.silent = { ms: 0, at: 0 };
    this.paused = { ms: 0, since: null }; // Time spent in pauses, and beginning of the present pause [ms].
    this.replay = null;
    this.clear();
  }

  clear() {
    this.hello = null;
    // State of the link as the page shows it, and as the station reported it last.
    this.link = this.reportedLink = { is_live: false, text: "connecting" };
    this.pace = { is_there: false, is_paused: false, speed: 1 };
    this.hand = { page: null, other: null }; // Page, or other program, that commands the hand; null: none
    this.mismatches = new Map(); // "SUBSYSTEM" -> text: its interface hash differs from the dictionary
    this.mode = null;
    this.links = [];
    this.states = new Map();
    this.values = new Map(); // "SUBSYSTEM" -> Map(leaf -> {value, time, at, period})
    this.history = new Map(); // "SUBSYSTEM" or "SUBSYSTEM/ID" -> {t: [], rows: [values or null]}
    this.reports = new Map(); // "SUBSYSTEM/ID" -> the last report of a housekeeping structure
    // "SUBSYSTEM/ID" -> whether the housekeeping structure is enabled on board, and its interval
    this.enabled = new Map();
    this.buses = new Map(); // Name of a bus -> last message of its tap
    this.charted = new Map(); // Key -> line that the user has added to the strip charts
    this.counts = {}; // SUBSYSTEM -> received and lost packets
    this.dropped = 0; // Messages that the station has dropped because this page reads too slowly
    this.heard = new Map(); // "SUBSYSTEM" -> clock of the page at its last report
    this.lanes = new Map(); // "SUBSYSTEM" -> [[time, state], ...]
    this.events = [];
    this.commands = new Map();
    this.time = 0;
    this.selected = null;
    this.seen = 0; // Number of events that the user has seen
  }

  on(kinds, call) {
    for (const kind of kinds.split(" ")) {
      if (!this.listeners.has(kind)) this.listeners.set(kind, []);
      this.listeners.get(kind).push(call);
    }
  }

  tell(kind, message) {
    if (kind === "link" || kind === "pace") this.countPause();
    for (const call of this.listeners.get(kind) ?? []) call(message);
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/ws`);
    this.silenceTimer ??= setInterval(() => this.checkSilence(), CHECK_MS);
    socket.onopen = () => {
      this.hasSocket = true;
      this.socket = socket;
      this.silent = { ms: 0, at: performance.now() };
    };
    socket.onmessage = (event) => {
      this.noteMessage();
      this.take(JSON.parse(event.data));
    };
    socket.onclose = () => {
      this.hasSocket = this.isSilent = false;
      for (const answer of this.waiting.values()) answer({ refused: "the station does not answer" });
      this.waiting.clear();
      this.showLost("no station, trying again");
      setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  showLost(text, is_silent = false) {
    this.link = { is_live: false, text, is_silent };
    this.tell("link", this.link);
  }

  // A message of the station has arrived.
  noteMessage() {
    this.silent.ms = 0;
    if (!this.isSilent) return;
    this.isSilent = false;
    this.link = this.reportedLink;
    this.tell("link", this.link);
  }

  // Tell if the station is silent. If the page itself was busy or asleep, the messages of that time may still
  // wait to be read, so little of it counts.
  checkSilence() {
    const now = performance.now();
    this.silent.ms += Math.min(now - this.silent.at, 2 * CHECK_MS);
    this.silent.at = now;
    if (!this.hasSocket || this.isSilent || this.silent.ms < SILENT_MS) return;
    this.isSilent = true;
    this.showLost("the station does not answer", true);
  }

  isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  // Send a request to the station. The promise resolves with the answer.
  ask(order) {
    return new Promise((resolve) => {
      if (!this.isOpen()) {
        resolve({ refused: this.replay ? this.link.text : "the station does not answer" });
        return;
      }
      const id = this.next++;
      this.waiting.set(id, resolve);
      this.socket.send(JSON.stringify({ ...order, id }));
    });
  }

  command(text) {
    return this.ask({ do: "command", text });
  }
  live(line) {
    return this.ask({ do: "live", line });
  }

  select(name) {
    this.selected = name;
    this.tell("select", name);
  }

  subsystem(name) {
    return this.hello?.subsystems.find((item) => item.name === name);
  }
  members() {
    return this.hello?.subsystems.filter((item) => !item.infrastructure) ?? [];
  }

  // Subsystems in the order of all lists: those that move the robot first, infrastructure last.
  ordered() {
    return [...(this.hello?.subsystems ?? [])].sort(
      (a, b) => a.infrastructure - b.infrastructure || this.drives(b) - this.drives(a),
    );
  }

  // Longest expected time between two reports of a subsystem [ms of the page]. Members of a network send
  // their status each second; infrastructure sends only housekeeping, so its shortest interval counts.
  period(name) {
    const about = this.subsystem(name);
    const part = this.configuration(name) ?? about?.configurations[0];
    const intervals = (part?.structures ?? []).map((one) => one.period_us / 1000).filter((ms) => ms > 0);
    return (
      Math.max(1000, about?.infrastructure ? Math.min(60000, ...intervals) : 1000) / (this.pace.speed || 1)
    );
  }

  configuration(name) {
    const present = this.states.get(name)?.configuration;
    return this.subsystem(name)?.configurations.find((item) => item.name === present);
  }

  // Present time for the ages of values [ms]: by the clock of the page without pauses of simulated time, in a
  // replay the mission time.
  clock() {
    return this.replay ? this.time * 1000 : (this.paused.since ?? performance.now()) - this.paused.ms;
  }

  // Simulated time stands still from now on, or goes on. Without a link the page does not know, so ages grow.
  countPause() {
    const isPaused = this.pace.is_paused && this.link.is_live;
    if (isPaused === (this.paused.since !== null)) return;
    if (isPaused) this.paused.since = performance.now();
    else this.paused = { ms: this.paused.ms + performance.now() - this.paused.since, since: null };
  }

  // Electrical power that the present states need [W]; null if the mission does not define it.
  power() {
    const needs =
      this.hello?.subsystems.map((item) => item.power_w?.[this.states.get(item.name)?.state] ?? 0) ?? [];
    const isDefined = (item) => Object.keys(item.power_w ?? {}).length > 0;
    return this.hello?.power_available_w && this.hello.subsystems.some(isDefined)
      ? needs.reduce((sum, one) => sum + one, 0)
      : null;
  }

  // Whether this page holds the hand.
  isHolding() {
    return this.hand.page !== null && this.hand.page === this.page;
  }

  // Words that say which other page or program has the hand; null if the hand is free or belongs to this
  // page.
  handOwner() {
    if (this.hand.other) return `by ${this.hand.other}`;
    return this.hand.page !== null && this.hand.page !== this.page ? "by another page" : null;
  }

  // Reason why no command can be sent now; null if commands can be sent.
  barrier() {
    if (!this.link.is_live) return this.replay || this.link.is_silent ? this.link.text : "no link";
    return this.hello?.read_only ? "this station is read only" : null;
  }

  // A housekeeping structure of the present configuration, or of the first if none is selected.
  structure(name, id) {
    const part = this.configuration(name) ?? this.subsystem(name)?.configurations[0];
    return part?.structures.find((one) => one.id === id);
  }

  // The display structure of the present configuration of a subsystem: a station lets the subsystem report it
  // 20 times a second while a page is open.
  display(name) {
    return this.configuration(name)?.structures.find((one) => one.display);
  }

  // Time between two reports of a structure [ms of the page]: its interval on board, or what was observed.
  periodOf(name, id) {
    const known = this.structure(name, id)?.period_us ?? 0;
    return (known ? known / 1000 : (this.reports.get(`${name}/${id}`)?.gap ?? 1000)) / (this.pace.speed || 1);
  }

  // Freshness of a report: "live", "late" from 2 periods, "stale" from 3, "never".
  freshness(name, id) {
    const report = this.reports.get(`${name}/${id}`);
    if (!report) return "never";
    const periods = (this.clock() - report.at) / Math.max(LEAST_PERIOD_MS, this.periodOf(name, id));
    return periods < 2 ? "live" : periods < 3 ? "late" : "stale";
  }

  // Whether a structure is reported less often than another one that is live.
  isSlower(name, id, other) {
    if (id === undefined || other === undefined || id === other) return false;
    return this.freshness(name, other) === "live" && this.periodOf(name, other) <= this.periodOf(name, id);
  }

  // Present mission time [s]. It also advances between two reports, but not in a pause.
  now() {
    if (this.offset === null) return this.time;
    if (this.pace.is_paused || !this.link.is_live) return this.time;
    return Math.max(
      this.time,
      this.time + Math.min(1, performance.now() / 1000 - this.arrived) * (this.pace.speed || 1),
    );
  }

  advance(time) {
    if (time !== null && time !== undefined && time > this.time) {
      this.time = time;
      this.arrived = performance.now() / 1000;
      this.offset = time - this.arrived;
    }
  }

  take(message) {
    if (message.id !== undefined && this.waiting.has(message.id)) {
      this.waiting.get(message.id)(message);
      this.waiting.delete(message.id);
      return;
    }
    const taker = this[`take_${message.kind}`];
    if (taker) taker.call(this, message);
    this.tell(message.kind, message);
  }

  take_hello(message) {
    this.clear();
    this.hello = message;
    this.selected =
      message.subsystems.find((item) => !item.infrastructure && this.drives(item))?.name ??
      message.subsystems[0].name;
  }

  // The moving joints of the robot that a subsystem drives.
  jointsOf(name) {
    const part = this.configuration(name) ?? this.subsystem(name)?.configurations[0];
    return jointsOf(this.hello?.world, part?.devices ?? []);
  }

  // Whether a subsystem moves a robot of the world: one of its devices drives a joint.
  drives(item) {
    const drives = this.hello?.world?.drives ?? {};
    return item.configurations.some((part) => part.devices.some((device) => drives[device]));
  }

  take_link(message) {
    this.link = this.reportedLink = message;
  }
  take_pace(message) {
    this.pace = message;
  }
  take_hand(message) {
    this.hand = message;
  }
  take_ready(message) {
    this.page = message.page;
  }
  take_mismatch(message) {
    if (message.words) this.mismatches.set(message.subsystem, message.words);
    else this.mismatches.delete(message.subsystem);
  }
  take_mode(message) {
    this.mode = message.mode;
  }
  take_links(message) {
    this.links = message.rows;
  }

  // The states before this page was opened.
  take_lanes(message) {
    this.lanes = new Map(Object.entries(message.lanes));
  }

  take_state(message) {
    this.advance(message.time);
    const lane = this.lanes.get(message.subsystem) ?? [];
    if (!lane.length || lane[lane.length - 1][1] !== message.state)
      lane.push([message.since ?? this.time, message.state]);
    this.lanes.set(message.subsystem, lane);
    this.states.set(message.subsystem, message);
    if (message.time !== null) this.heard.set(message.subsystem, this.clock());
  }

  take_housekeeping(message) {
    this.advance(message.time);
    const now = this.clock();
    this.heard.set(message.subsystem, now);
    if (!this.values.has(message.subsystem)) this.values.set(message.subsystem, new Map());
    const values = this.values.get(message.subsystem);
    for (const [leaf, value] of Object.entries(message.values)) {
      const old = values.get(leaf);
      if (old && old.time > message.time) continue;
      const gap = old ? (message.time - old.time) * 1000 : 0;
      values.set(leaf, { value, time: message.time, at: now, period: gap > 0 ? gap : (old?.period ?? 1000) });
    }
    this.remember(message, now);
    this.record(message);
  }

  take_structures(message) {
    for (const row of message.rows) this.enabled.set(`${message.subsystem}/${row.id}`, row);
  }

  take_bus(message) {
    this.buses.set(message.bus, message);
  }

  take_dropped(message) {
    this.dropped = message.updates;
  }

  take_counts(message) {
    this.counts = message.rows;
  }

  // Keep the last report of each structure, and its history.
  remember(message, now) {
    const key = `${message.subsystem}/${message.structure}`;
    const old = this.reports.get(key);
    const gap = old && message.time > old.time ? (message.time - old.time) * 1000 : (old?.gap ?? 1000);
    this.reports.set(key, {
      subsystem: message.subsystem,
      id: message.structure,
      time: message.time,
      at: now,
      gap,
      count: (old?.count ?? 0) + 1,
      values: message.values,
    });
    const known = this.structure(message.subsystem, message.structure)?.period_us;
    // From 3 periods and a margin on, the history has a gap: reports are missing.
    this.append(key, message, 3 * (known ? known / 1e6 : (old?.gap ?? 1000) / 1000) + 0.2);
  }

  // Add a report to the history of the subsystem, if it contains the positions of joints.
  record(message) {
    if (message.values["CUR_VALUES.POSITION"]) this.append(message.subsystem, message, 1);
  }

  append(key, message, gap) {
    let history = this.history.get(key);
    if (!history) {
      history = { t: [], rows: [] };
      this.history.set(key, history);
    }
    const last = history.t[history.t.length - 1] ?? -1;
    if (message.time <= last) return;
    if (last >= 0 && message.time - last > gap) {
      history.t.push(last + 0.001);
      history.rows.push(null);
    }
    history.t.push(message.time);
    history.rows.push(message.values);
    // Remove 60 s at a time, because each removal moves the whole array.
    if (history.t[0] < message.time - HISTORY_S - 60) {
      const cut = history.t.findIndex((t) => t > message.time - HISTORY_S);
      history.t.splice(0, cut);
      history.rows.splice(0, cut);
    }
  }

  take_event(message) {
    this.advance(message.time);
    this.events.push(message);
    if (this.events.length > EVENTS_KEPT) {
      this.events.shift();
      this.seen = Math.max(0, this.seen - 1);
    }
  }

  take_command(message) {
    this.commands.set(message.number, message);
  }

  value(subsystem, leaf) {
    return this.values.get(subsystem)?.get(leaf)?.value;
  }
}

export const store = new Store();
