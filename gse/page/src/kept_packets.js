// SPDX-License-Identifier: Apache-2.0
// The kinds of packets that the station has received and sent, and the octets and fields of the one that the
// user selects. The list keeps the order of its kinds, so that no row moves while packets arrive.

import { every } from "./beat.js";
import { store } from "./store.js";
import { counted, el, refill, text } from "./dom.js";

const REFRESH_MS = 1000; // Time between two updates of the list.
const OCTETS_IN_ROW = 16;
const DRAWN_MAX = 4096; // Octets that are drawn of a packet. Only packets in parts have more.
const hex = (value, digits) => value.toString(16).toUpperCase().padStart(digits, "0");
const seconds = (time) => (time === null ? "–" : time.toFixed(4));

// Words for the place of a field: its first octet, or its first and last one.
export const placeOf = ({ at, size }) => (size > 1 ? `${at} to ${at + size - 1}` : `${at}`);

// Fields that contain the octet at a place; the smallest field is the last one.
export const fieldsAt = (fields, place) =>
  fields
    .filter(({ at, size }) => place >= at && place < at + size)
    .sort((one, other) => other.size - one.size);

export class KeptPackets {
  // others: elements that are hidden while a packet is shown.
  constructor(others) {
    this.others = others;
    this.packets = []; // Those of the kind that is shown, the oldest first.
    this.list = el("div", { class: "kinds", role: "group", "aria-label": "Newest packet of each kind" });
    this.rows = new Map(); // Kind as text -> its row
    this.title = el("span", { class: "name what" });
    this.about = el("span", { class: "hint what" });
    const button = (words, title, onclick) => el("button", { title, onclick }, words);
    this.back = button("‹ Packets", "Back to the kinds of packets (Esc)", () => this.close());
    this.earlier = button("Earlier", "The packet of this kind before this one", () => this.step(-1));
    this.later = button("Later", "The packet of this kind after this one", () => this.step(1));
    this.octets = el("div", { class: "dump mono", role: "group", "aria-label": "Octets, hexadecimal" });
    this.fields = el("div", { class: "of-packet", role: "group", "aria-label": "Fields of the packet" });
    this.refused = el("p", { class: "reason", role: "status", hidden: true });
    this.one = el(
      "div",
      { hidden: true },
      el("div", { class: "filter" }, this.back, this.title, this.earlier, this.later),
      el("div", { class: "sides" }, this.about),
      this.octets,
      this.fields,
    );
    this.node = el("div", {}, this.list, this.refused, this.one);
    this.node.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || this.one.hidden) return;
      event.stopPropagation(); // Esc also disarms a command.
      this.close();
    });
    for (const kind of ["pointerover", "focusin"])
      this.octets.addEventListener(kind, ({ target }) => this.mark(this.fieldOf(target)));
    store.on("hello", () => this.begin());
    every(REFRESH_MS, () => this.look());
  }

  begin() {
    this.rows.clear();
    this.list.replaceChildren();
    this.close();
  }

  get isSeen() {
    return this.node.offsetParent !== null && store.isOpen();
  }

  async look() {
    if (!this.isSeen || !this.one.hidden) return;
    const { rows, refused } = await store.ask({ do: "packets" });
    this.refuse(refused);
    for (const row of rows ?? []) this.put(row);
    this.order(rows ?? []);
  }

  refuse(words) {
    text(this.refused, words ?? "");
    this.refused.hidden = !words;
  }

  // Update the row of a kind; a new kind gets one.
  put(row) {
    const key = JSON.stringify(row.kind);
    if (!this.rows.has(key)) {
      const parts = { time: el("span", { class: "mono" }) };
      parts.node = el(
        "button",
        { class: "entry", tabindex: -1, onclick: () => this.show(row.kind) },
        parts.time,
        el("span", { class: "mono" }, row.message),
        el("span", {}, el("span", { class: "name" }, row.subsystem), ` ${row.name}`),
      );
      this.rows.set(key, parts);
    }
    const parts = this.rows.get(key);
    text(parts.time, seconds(row.time));
  }

  order(rows) {
    const nodes = rows.map((row) => this.rows.get(JSON.stringify(row.kind)).node);
    if (nodes.length !== this.list.children.length || nodes.some((node, n) => node !== this.list.children[n]))
      refill(this.list, ...nodes);
    // One row is a stop of the Tab key; the arrow keys go from row to row.
    if (!nodes.some((node) => node.tabIndex === 0) && nodes[0]) nodes[0].tabIndex = 0;
  }

  // Show the newest packet of a kind instead of the list. The page keeps the packets of the kind that the
  // station has stored, so that the user can read them while others arrive.
  async show(kind) {
    const { refused, message, subsystem, name, packets } = await store.ask({ do: "packets", kind });
    this.refuse(refused);
    if (refused) return;
    Object.assign(this, { kind, name, packets, at: packets.length - 1 });
    this.toggle(true);
    text(this.title, `${message} ${subsystem}`);
    this.draw();
    this.back.focus();
  }

  step(by) {
    this.at += by;
    this.draw();
  }

  get shown() {
    return this.packets[this.at];
  }

  toggle(isShown) {
    this.one.hidden = !isShown;
    for (const node of [this.list, ...this.others]) node.hidden = isShown;
  }

  close() {
    const key = JSON.stringify(this.kind);
    this.toggle(false);
    this.kind = null;
    this.packets = [];
    this.rows.get(key)?.node.focus();
    this.look();
  }

  draw() {
    const { time, octets, fields } = this.shown;
    const newer = this.packets.length - 1 - this.at;
    const place = newer ? `${counted(newer, "packet")} before the newest` : "the newest";
    text(this.about, `${this.name}, at ${seconds(time)} s, ${place}`);
    this.earlier.disabled = this.at === 0;
    this.later.disabled = newer === 0;
    const all = octets.match(/../g).slice(0, DRAWN_MAX);
    const rows = [];
    for (let from = 0; from < all.length; from += OCTETS_IN_ROW)
      rows.push(
        el(
          "div",
          {},
          el("span", { class: "place" }, hex(from, 4)),
          ...all
            .slice(from, from + OCTETS_IN_ROW)
            .map((octet, n) => el("span", { "data-at": from + n }, octet.toUpperCase())),
        ),
      );
    this.octets.replaceChildren(...rows);
    this.fields.replaceChildren(
      ...fields.map((field, n) => {
        const mark = () => this.mark(field);
        return el(
          "button",
          { class: "entry", tabindex: n ? -1 : 0, onfocus: mark, onpointerenter: mark, onclick: mark },
          el("span", { class: "mono" }, placeOf(field)),
          el("span", { class: "name" }, field.name),
          el("span", { class: "value" }, field.text),
        );
      }),
    );
    this.mark(null);
  }

  fieldOf(node) {
    const place = node.dataset?.at;
    return place === undefined ? null : (fieldsAt(this.shown.fields, Number(place)).at(-1) ?? null);
  }

  // Mark a field and its octets.
  mark(field) {
    const { at, size } = field ?? { at: 0, size: 0 };
    for (const octet of this.octets.querySelectorAll("[data-at]")) {
      const place = Number(octet.dataset.at);
      octet.classList.toggle("marked", place >= at && place < at + size);
    }
    [...this.fields.children].forEach((node, n) =>
      node.classList.toggle("marked", this.shown?.fields[n] === field),
    );
  }
}
