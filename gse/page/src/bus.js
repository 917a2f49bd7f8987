// SPDX-License-Identifier: Apache-2.0
// Tab Bus: load, errors and decoded frames of one bus. While this tab is open, the simulator sends the frames
// from a listen-only tap.

import { every } from "./beat.js";
import { store } from "./store.js";
import { agesOf, devicesOn, stateOf } from "./bus_devices.js";
import { age, counted, el, put, refill, show, symbol, tableHead, text } from "./dom.js";

const NUMBERS = ["Rate", "Heartbeat", "Process data"]; // Columns that are aligned at the right.
const REFRESH_MS = 250; // Time between two updates of the tab.

const number = (label) => {
  const value = el("span", { class: "value" }),
    below = el("span", { class: "hint" });
  return { value, below, node: el("div", {}, el("span", { class: "hint" }, label), value, below) };
};

export class Bus {
  constructor() {
    this.pick = el("div", { class: "pick", role: "group", "aria-label": "Buses" });
    this.numbers = {
      load: number("Load"),
      tx: number("Tx errors"),
      lost: number("Frames lost"),
      off: number("Bus-off"),
    };
    this.words = el("p", { class: "reason counts-line" });
    this.errors = el("tbody");
    this.frames = el("tbody");
    this.devices = el("tbody");
    this.deviceRows = { of: "", all: [] };
    this.device = null; // Device whose frames are shown; null: all frames of the bus
    const table = (words, body) =>
      el(
        "table",
        { class: "frames values" },
        tableHead(...words.map((word) => [word, NUMBERS.includes(word) ? "num" : ""])),
        body,
      );
    this.node = el(
      "div",
      { style: "display:contents" },
      this.pick,
      el("div", { class: "four" }, ...Object.values(this.numbers).map((one) => one.node)),
      this.words,
      el(
        "div",
        { class: "scroll", tabindex: 0, role: "group", "aria-label": "Frames" },
        (this.deviceTable = table(["Device", "Node", "State", "Heartbeat", "Process data"], this.devices)),
        (this.errorTable = table(["Time s", "", "Error", "In words"], this.errors)),
        table(["Time s", "Id", "Name", "Rate"], this.frames),
      ),
    );
    this.errorTable.hidden = true;
    this.deviceTable.classList.add("devices");
    store.on("hello", () => {
      this.name = this.device = null;
      this.watched = null;
      this.build();
    });
    every(REFRESH_MS, () => this.draw());
  }

  build() {
    const names = (store.hello?.buses ?? []).map((bus) => bus.name);
    this.name = this.name ?? names[0] ?? null;
    refill(
      this.pick,
      ...names.map((name) =>
        el(
          "button",
          {
            "aria-pressed": String(name === this.name),
            onclick: () => {
              this.name = name;
              this.device = null;
              this.build();
            },
          },
          name,
        ),
      ),
    );
    this.draw();
  }

  // Show the frames of a device on a bus; device null: all frames of the bus.
  open({ bus, device }) {
    this.name = bus;
    this.device = device;
    this.build();
    this.devices.querySelector("[aria-pressed=true]")?.focus({ preventScroll: true });
  }

  // Sum of a counter over the subsystems that have a device on this bus; null if no subsystem has reported
  // it.
  counter(leaf) {
    let sum = null;
    for (const { name } of store.hello?.subsystems ?? []) {
      if (!store.configuration(name)?.buses.includes(this.name)) continue;
      const value = store.value(name, `COUNTERS.${leaf}`)?.[0];
      if (typeof value === "number") sum = (sum ?? 0) + value;
    }
    return sum;
  }

  draw() {
    const isShown =
      this.node.parentElement && !this.node.parentElement.hidden && store.hello && !store.replay;
    const wanted = isShown ? this.name : null;
    if (wanted !== this.watched && store.hasSocket) {
      this.watched = wanted;
      store.ask({ do: "watch", bus: wanted });
    }
    if (!isShown) return;
    const said = store.buses.get(this.name);
    const warning = said?.warning ? `${said.warning}. ` : "";
    const shown = this.device ? `, those of ${this.device} shown` : "";
    const identifiers = `${counted(said?.frames?.length, "identifier")}${shown}`;
    const errors = counted(said?.error_count, "error frame");
    const problem = said?.problem ?? (store.pace.is_there ? null : "this flight has no live port");
    text(
      this.words,
      !this.name
        ? "This mission has no bus."
        : problem
          ? `No frames: ${problem}`
          : !said
            ? "Waiting for frames"
            : said.dropped
              ? `${warning}${counted(said.dropped, "frame")} not passed on: the tap was too slow`
              : `${warning}${identifiers}, ${errors} since this tab is open`,
    );
    const { load, tx, lost, off } = this.numbers;
    const tell = (one, value, below) => {
      text(one.value, value === null || value === undefined ? "–" : String(value));
      text(one.below, below);
    };
    tell(
      load,
      said?.load === null || said?.load === undefined ? null : `${(said.load * 100).toFixed(0)} %`,
      "with average bit stuffing",
    );
    tell(
      tx,
      said?.transmit_errors ?? (said && !problem ? 0 : null),
      (said?.transmit_errors ?? 0) > 127
        ? "error passive"
        : (said?.transmit_errors ?? 0) > 95
          ? "error warning"
          : "error active",
    );
    tell(lost, this.counter("RECEIVE_OVERRUNS"), "overruns of the flight software");
    tell(off, this.counter("BUS_OFF"), "since start");
    this.drawDevices(said);
    if (said?.frames) this.list(said);
  }

  // The devices of the bus. A press on one shows its frames only, and the next press all frames again.
  drawDevices(said) {
    const found = devicesOn(store).filter((one) => one.bus === this.name);
    this.deviceTable.hidden = !found.length;
    const wanted = found.map(({ device, node }) => `${device} ${node}`).join();
    if (this.deviceRows.of !== wanted) {
      this.deviceRows = { of: wanted, all: found.map((one) => this.rowOf(one)) };
      refill(this.devices, ...this.deviceRows.all.map((row) => row.tr));
    }
    found.forEach(({ device, node, isLost }, n) => {
      const row = this.deviceRows.all[n];
      const { heartbeat, data } = agesOf(device, node, said);
      const [symbolOf, word] = isLost ? ["critical", "lost"] : stateOf(heartbeat, data);
      put(row.button, "aria-pressed", this.device === device);
      show(row.sym, symbolOf, "state");
      text(row.state, word);
      text(row.heartbeat, age(heartbeat));
      text(row.data, age(data));
    });
  }

  rowOf({ device, node }) {
    const toggle = () => {
      this.device = this.device === device ? null : device;
      this.draw();
    };
    const row = Object.fromEntries(["state", "heartbeat", "data"].map((key) => [key, el("span")]));
    row.sym = el("span", { "aria-hidden": "true" }); // The word beside it says the same.
    row.button = el("button", { class: "device", onclick: toggle }, device);
    row.tr = el(
      "tr",
      {},
      el("td", { class: "name" }, row.button),
      el("td", { class: "mono" }, node ?? "–"),
      el("td", {}, row.sym, " ", row.state),
      el("td", { class: "mono num" }, row.heartbeat),
      el("td", { class: "mono num" }, row.data),
    );
    return row;
  }

  list({ errors, frames: all }) {
    const frames = all.filter((one) => this.device === null || one.name.startsWith(`${this.device}_`));
    const cell = (words, className) => el("td", { class: className }, words);
    this.errors.replaceChildren(
      ...[...errors]
        .reverse()
        .map((one) =>
          el(
            "tr",
            {},
            cell(one.time.toFixed(6), "mono"),
            el("td", {}, symbol(one.symbol, one.symbol)),
            cell(one.name, "name"),
            cell(one.words, "words"),
          ),
        ),
    );
    this.errorTable.hidden = !errors.length;
    this.frames.replaceChildren(
      ...frames.flatMap((one) => [
        el(
          "tr",
          { title: one.octets },
          cell(one.time.toFixed(4), "mono"),
          cell(one.id, "mono"),
          cell(one.name || "–", "name"),
          cell(one.rate >= 1 ? `${one.rate.toFixed(0)} Hz` : "–", "mono num"),
        ),
        ...(one.words || one.octets
          ? [el("tr", { class: "below" }, el("td", { class: "words", colspan: 4 }, one.words || one.octets))]
          : []),
      ]),
    );
  }
}
