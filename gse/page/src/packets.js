// SPDX-License-Identifier: Apache-2.0
// Tab Packets: packets that the station has received and lost, for each subsystem, and their octets.

import { store } from "./store.js";
import { counted, el, show, tableHead, text } from "./dom.js";
import { KeptPackets } from "./kept_packets.js";

const RATE_S = 5; // Time over which a rate is the mean.

export class Packets {
  constructor() {
    this.total = el("p", { class: "reason counts-line" });
    this.rows = new Map(); // Subsystem -> cells
    this.body = el("tbody");
    this.seen = []; // [mission time, counts] of the last RATE_S
    this.table = el(
      "table",
      {},
      tableHead(["Subsystem"], ["Received", "num"], ["per s", "num"], ["Lost", "num"]),
      this.body,
    );
    this.kept = new KeptPackets([this.total, this.table]);
    this.node = el(
      "div",
      { class: "scroll", tabindex: 0, role: "group", "aria-label": "Packets" },
      this.total,
      this.table,
      this.kept.node,
    );
    store.on("hello", () => this.begin());
    store.on("counts dropped", () => this.draw());
  }

  begin() {
    this.rows.clear();
    this.seen = [];
    this.body.replaceChildren();
    this.draw();
  }

  sum(key) {
    return Object.values(store.counts).reduce((total, row) => total + row[key], 0);
  }

  // Cells of a subsystem, with a row of their own in the table.
  cellsOf(name) {
    if (!this.rows.has(name)) {
      const cells = Object.fromEntries(["received", "rate", "sym", "lost"].map((key) => [key, el("span")]));
      this.rows.set(name, cells);
      const number = (...parts) => el("td", { class: "value num" }, ...parts);
      this.body.append(
        el(
          "tr",
          {},
          el("td", { class: "name" }, name),
          number(cells.received),
          number(cells.rate),
          number(cells.sym, " ", cells.lost),
        ),
      );
    }
    return this.rows.get(name);
  }

  // Counts of RATE_S ago, or the oldest known ones after them.
  before() {
    const { time } = store;
    if (this.seen.at(-1)?.[0] !== time)
      this.seen.push([
        time,
        Object.fromEntries(Object.entries(store.counts).map(([name, row]) => [name, row.received])),
      ]);
    while (this.seen.length > 2 && this.seen[1][0] <= time - RATE_S) this.seen.shift();
    return this.seen[0];
  }

  draw() {
    const [since, old] = this.before();
    const passed = store.time - since;
    const dropped = store.dropped
      ? `, ${counted(store.dropped, "report")} dropped: this page reads too slowly`
      : "";
    const received = counted(this.sum("received"), "packet");
    text(this.total, `${received} received, ${this.sum("lost")} lost${dropped} since the connection`);
    for (const [name, row] of Object.entries(store.counts)) {
      const cells = this.cellsOf(name);
      text(cells.received, String(row.received));
      text(cells.rate, passed > 0 ? ((row.received - (old[name] ?? 0)) / passed).toFixed(1) : "–");
      text(cells.lost, String(row.lost));
      if (row.lost) show(cells.sym, "caution", "packets were lost");
      else cells.sym.replaceChildren();
    }
  }
}
