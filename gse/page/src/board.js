// SPDX-License-Identifier: Apache-2.0
// Tab On board: lists of the schedule, packet stores, procedures and files, uploads, and buttons that open a
// command for an entry in the tab Command.

import { store } from "./store.js";
import { el, refill, tableHead, text, unseen } from "./dom.js";

const LIST_MS = 250; // Period of checking whether the tab is open.

// Button that opens a command in the tab Command.
const prepare = (line, word) =>
  el("button", { "aria-label": line, onclick: () => store.tell("again", line) }, word);

// A list: `request` is the command that reads it, `row` gives the cells of an entry, `commands` its buttons
// [word, command].
class List {
  constructor(name, request, columns, row, commands, extra) {
    Object.assign(this, { name, request, row, commands });
    this.hint = el("span", { class: "hint" });
    this.body = el("tbody");
    this.node = el(
      "section",
      { "aria-label": name },
      el("div", { class: "head" }, el("h2", {}, name), this.hint, ...(extra ?? [])),
      el(
        "table",
        { class: "values" },
        tableHead(...columns.map((word) => [word]), [unseen("Commands")]),
        this.body,
      ),
    );
  }

  async refresh() {
    const answer = await store.ask({
      do: "ask",
      text: typeof this.request === "function" ? this.request() : this.request,
    });
    const entries = (answer.rows ?? []).flatMap((row) => row.n ?? (row.object_name ? [row] : []));
    text(this.hint, answer.refused ?? (entries.length ? "" : "none"));
    refill(
      this.body,
      ...entries.map((entry) =>
        el(
          "tr",
          {},
          ...this.row(entry).map((word) => el("td", { class: "mono" }, String(word ?? "–"))),
          el("td", { class: "num" }, ...this.commands(entry).map(([word, line]) => prepare(line, word))),
        ),
      ),
    );
  }
}

const seconds = (time) => (typeof time === "number" ? time.toFixed(3) : "–");
// A name on board as one word of a command, whatever its characters are.
const word = (name) => (/^[\w@%+=:,./-]+$/.test(name) ? name : `'${name.replaceAll("'", `'"'"'`)}'`);
const octetsOf = async (file) =>
  btoa(Array.from(new Uint8Array(await file.arrayBuffer()), (octet) => String.fromCharCode(octet)).join(""));

export class Board {
  constructor() {
    this.directory = el("input", {
      value: "/",
      "aria-label": "Directory on board",
      onchange: () => this.files.refresh(),
    });
    const path = (entry) => `${this.directory.value.replace(/\/$/, "")}/${entry.object_name}`;
    this.files = new List(
      "Files",
      () => `file list ${word(this.directory.value || "/")}`,
      ["Kind", "Name"],
      (one) => [one.object_type, one.object_name],
      (one) => [["delete", `file delete ${word(path(one))}`]],
      [this.directory],
    );
    this.lists = [
      new List(
        "Schedule",
        "schedule list",
        ["Time s", "Addressee", "Count"],
        (one) => [
          seconds(one.release_time),
          store.hello?.subsystems.find((item) => item.apid === one.apid)?.name ?? one.apid,
          one.sequence_count,
        ],
        () => [],
        ["enable", "disable", "reset"].map((verb) => prepare(`schedule ${verb}`, verb)),
      ),
      new List(
        "Packet stores",
        "store list",
        ["Store", "Storage", "Retrieval"],
        (one) => [one.packet_store_id, one.packet_store_status, one.open_retrieval_status],
        (one) =>
          ["enable", "disable", "summary"].map((verb) => [
            verb,
            `store ${verb} ${word(one.packet_store_id)}`,
          ]),
      ),
      new List(
        "Procedures",
        "procedure status",
        ["Procedure", "State"],
        (one) => [one.obcp_id, one.obcp_execution_status],
        (one) =>
          ["run", "suspend", "resume", "stop", "unload"].map((verb) => [
            verb,
            `procedure ${verb} ${word(one.obcp_id)}`,
          ]),
      ),
      this.files,
    ];
    this.file = el("input", { type: "file", "aria-label": "File of this computer" });
    this.as = el("input", { "aria-label": "Name of a procedure, or path on board" });
    this.said = el("p", { class: "reason", role: "status" });
    this.node = el(
      "div",
      { class: "scroll", tabindex: 0, role: "group", "aria-label": "On board" },
      el(
        "div",
        { class: "filter" },
        el("button", { onclick: () => this.refresh() }, "Refresh"),
        el("span", { class: "hint" }, "commands are prepared in the tab Command"),
      ),
      ...this.lists.map((list) => list.node),
      el(
        "section",
        { "aria-label": "Upload" },
        el("div", { class: "head" }, el("h2", {}, "Upload")),
        el(
          "div",
          { class: "form" },
          el("label", {}, el("span", {}, "File"), this.file),
          el("label", {}, el("span", {}, "Name or path"), this.as),
          el(
            "div",
            { class: "acts" },
            el(
              "button",
              { onclick: () => this.upload((name) => ["procedure", "load", name, "{}"]) },
              "as procedure",
            ),
            el("button", { onclick: () => this.upload((name) => ["file", "upload", "{}", name]) }, "as file"),
          ),
          this.said,
        ),
      ),
    );
    store.on("command", (call) => {
      if (call.over && this.isShown) this.refresh();
    });
    setInterval(() => this.watch(), LIST_MS);
  }

  // Read the lists each time the tab is opened.
  watch() {
    const isShown = Boolean(this.node.parentElement && !this.node.parentElement.hidden && store.link.is_live);
    if (isShown && !this.isShown) this.refresh();
    this.isShown = isShown;
  }

  async refresh() {
    for (const list of this.lists) await list.refresh();
  }

  async upload(words) {
    const file = this.file.files[0];
    if (!file || !this.as.value.trim()) {
      text(this.said, "choose a file, and give its name or path on board");
      return;
    }
    const answer = await store.ask({
      do: "upload",
      words: words(this.as.value.trim()),
      data: await octetsOf(file),
    });
    text(this.said, answer.refused ?? "sent; the list of commands shows its progress");
  }
}
