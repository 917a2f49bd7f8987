// SPDX-License-Identifier: Apache-2.0
// Tab Bus: load, errors and decoded frames of one bus. While this tab is open, the simulator sends the frames
// from a listen-only tap.

import { every } from "./beat.js";
import { store } from "./store.js";
import { counted, el, refill, symbol, text } from "./dom.js";

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
    const table = (words, body) =>
      el(
        "table",
        { class: "frames values" },
        el(
          "thead",
          {},
          el("tr", {}, ...words.map((word) => el("th", { class: word === "Rate" ? "num" : "" }, word))),
        ),
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
        (this.errorTable = table(["Time s", "", "Error", "In words"], this.errors)),
        table(["Time s", "Id", "Name", "Rate"], this.frames),
      ),
    );
    this.errorTable.hidden = true;
    store.on("hello", () => {
      this.name = null;
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
              this.build();
            },
          },
          name,
        ),
      ),
    );
    this.draw();
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
    const identifiers = counted(said?.frames?.length, "identifier");
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
    const put = (one, value, below) => {
      text(one.value, value === null || value === undefined ? "–" : String(value));
      text(one.below, below);
    };
    put(
      load,
      said?.load === null || said?.load === undefined ? null : `${(said.load * 100).toFixed(0)} %`,
      "with average bit stuffing",
    );
    put(
      tx,
      said?.transmit_errors ?? (said && !problem ? 0 : null),
      (said?.transmit_errors ?? 0) > 127
        ? "error passive"
        : (said?.transmit_errors ?? 0) > 95
          ? "error warning"
          : "error active",
    );
    put(lost, this.counter("RECEIVE_OVERRUNS"), "overruns of the flight software");
    put(off, this.counter("BUS_OFF"), "since start");
    if (said?.frames) this.list(said);
  }

  list({ errors, frames }) {
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
