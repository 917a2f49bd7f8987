// SPDX-License-Identifier: Apache-2.0
// Tab Command: forms that the station makes from the dictionary. The user searches, checks, arms, sends and
// repeats commands and saves them as a script.

import { store } from "./store.js";
import { el, lights, refill, text } from "./dom.js";

const ARMED_MS = 10000; // Time for which a critical command stays armed.
const FOUND_MAX = 60,
  RECENT_MAX = 6;
const AS_TYPED = { fields: [], kind: "as typed" }; // Form of a command whose words the user has typed.

// Make the lists of names that inputs suggest: one list for all inputs of a kind.
function suggestions(kinds) {
  return Object.entries(kinds ?? {}).map(([kind, items]) =>
    el(
      "datalist",
      { id: `suggest-${kind}` },
      ...items.map((item) => el("option", { value: item.value }, item.name)),
    ),
  );
}

function hintOf(field) {
  const range = field.min !== undefined ? `${field.min} to ${field.max ?? "…"}` : "";
  const many = field.count > 1 ? `${field.count} values` : "";
  return [many, range, field.unit, field.hint ?? (field.coding ? "" : field.type?.toLowerCase())]
    .filter(Boolean)
    .join(", ");
}

// Inputs of a group of fields. `values()` returns their texts; `changed` is called after each change.
class Fields {
  constructor(fields, changed, outer = null) {
    this.changed = changed;
    this.outer = outer;
    this.parts = fields.map((field) =>
      field.repeat ? this.repeat(field) : field.choice ? this.choice(field) : this.input(field),
    );
    this.node = el("div", { class: "fields" }, ...this.parts.map((part) => part.node));
    for (const part of this.parts) part.follow?.();
  }

  input(field) {
    const input = field.options
      ? el("select", {}, ...field.options.map((option) => el("option", { value: option.value }, option.name)))
      : el("input", { autocomplete: "off", list: field.suggest && `suggest-${field.suggest}` });
    input.addEventListener("input", () => {
      for (const part of this.parts) part.follow?.();
      this.changed();
    });
    return {
      name: field.name,
      value: () => input.value,
      put: (value) => {
        input.value = value;
      },
      node: el(
        "label",
        {},
        el("span", {}, field.unit ? `${field.name}, ${field.unit}` : field.name),
        input,
        el("span", { class: "hint range" }, hintOf(field)),
      ),
    };
  }

  repeat(field) {
    const groups = [];
    const list = el("div", { class: "groups" });
    const draw = () => {
      list.replaceChildren(
        ...groups.map((group, n) =>
          el(
            "div",
            { class: "group", role: "group", "aria-label": `${field.name} ${n + 1}` },
            group.node,
            el(
              "button",
              {
                "aria-label": `Remove ${field.name} ${n + 1}`,
                onclick: () => {
                  groups.splice(n, 1);
                  draw();
                  this.changed();
                },
              },
              "−",
            ),
          ),
        ),
      );
    };
    const add = () => {
      groups.push(new Fields(field.fields, this.changed, this));
      draw();
    };
    for (let n = 0; n < field.least; n++) add();
    return {
      name: field.name,
      value: () => groups.map((group) => group.values()),
      node: el(
        "div",
        { class: "repeat" },
        el(
          "div",
          { class: "acts" },
          el("span", {}, field.name),
          el(
            "button",
            {
              "aria-label": `Add ${field.name}`,
              onclick: () => {
                add();
                this.changed();
              },
            },
            "+",
          ),
        ),
        list,
      ),
    };
  }

  // Inputs whose fields depend on the present value of another field.
  choice(field) {
    const node = el("div");
    let shown = null,
      inner = null;
    const follow = () => {
      const value = this.valueOf(field.choice);
      if (value === shown) return;
      shown = value;
      inner = new Fields(field.cases[value] ?? [], this.changed, this);
      node.replaceChildren(inner.node);
    };
    return { follow, values: () => inner?.values() ?? {}, node };
  }

  valueOf(name) {
    const part = this.parts.find((one) => one.name === name);
    return part ? part.value() : this.outer?.valueOf(name);
  }

  values() {
    return Object.assign(
      {},
      ...this.parts.map((part) => (part.name ? { [part.name]: part.value() } : part.values())),
    );
  }
}

export class CommandForm {
  constructor() {
    this.find = el("input", {
      type: "search",
      id: "find",
      autocomplete: "off",
      oninput: () => this.search(),
      onkeydown: (event) => this.step(event),
    });
    this.list = el("div", {
      class: "choices",
      role: "group",
      "aria-label": "Commands found",
      onkeydown: (event) => this.step(event),
    });
    this.title_ = el("h2", { tabindex: -1 });
    this.fields = el("fieldset", { class: "bare" });
    this.lists = el("div", { hidden: true });
    this.octets = el("div", { class: "mono octets" });
    this.line = el("div", { class: "mono octets" });
    this.checked = el("span");
    this.arm = el("button", { onclick: () => this.toggleArm() }, "Arm");
    this.go = el("button", { class: "go", onclick: () => this.send() }, "Send");
    this.hint = el("span", { class: "hint" });
    this.left = el("i");
    this.runs = el("div", { class: "runs", "aria-hidden": "true" }, this.left);
    this.result = el("div", { "aria-live": "polite" });
    this.node = el(
      "div",
      { class: "form scroll", tabindex: 0, role: "group", "aria-label": "Command form" },
      el("label", {}, el("span", {}, "Find a command ", el("kbd", {}, "/")), this.find),
      this.list,
      this.title_,
      this.fields,
      this.lists,
      el("div", { class: "line" }, el("span", {}, "Octets"), this.octets),
      el("div", { class: "line" }, el("span", {}, "Words"), this.line),
      el("div", { class: "line" }, el("span", {}, "Checked"), this.checked),
      el("div", { class: "acts" }, this.arm, this.go, this.hint),
      this.runs,
      this.result,
      el(
        "div",
        { class: "acts" },
        el("button", { onclick: () => this.save() }, "Save as script"),
        el("span", { class: "hint" }, "all commands of this flight, for gse script"),
      ),
    );
    this.forms = [];
    this.depends = []; // Subsystems whose interface defines the present words.
    this.pick(null);
    store.on("hello", () => this.load());
    store.on("prepare", (words) => this.prepare(words));
    store.on("again", (line) => this.again(line));
    store.on("link", () => {
      if (!store.link.is_live) this.disarm();
      this.judge();
    });
    store.on("mismatch", () => this.tick());
    store.on("command", (call) => {
      if (call.number === this.sent) this.report(call);
      if (call.over) this.search();
    });
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.disarm();
      // A form in a hidden tab is not sent, and a key that is held sends once.
      if (event.key === "Enter" && event.ctrlKey && !event.repeat && this.node.checkVisibility()) this.send();
    });
    setInterval(() => this.tick(), 200);
  }

  async load() {
    const answer = await store.ask({ do: "forms" });
    this.forms = answer.forms ?? [];
    this.lists.replaceChildren(...suggestions(answer.suggestions));
    this.search();
  }

  // List what the typed words find: without words, recent commands before forms; otherwise forms before
  // recent commands. A text that begins with a verb can be sent as typed.
  search() {
    const typed = this.find.value.trim();
    const words = typed.toLowerCase().split(/\s+/);
    const fits = (name) => words.every((word) => name.toLowerCase().includes(word));
    const lines = [
      ...new Set(
        [...store.commands.values()]
          .reverse()
          .map((call) => call.line)
          .filter(Boolean),
      ),
    ]
      .filter(fits)
      .slice(0, RECENT_MAX);
    const found = this.forms.filter((form) => fits(form.name)).slice(0, FOUND_MAX);
    const isTyped = store.hello?.verbs[typed.split(/\s+/)[0]];
    const button = (name, kind, act) =>
      el(
        "button",
        {
          onclick: () => {
            act();
            this.enter();
          },
        },
        el("span", { class: "what" }, name),
        el("span", { class: "hint" }, kind),
      );
    refill(
      this.list,
      ...(isTyped ? [button(`as typed: ${typed}`, "text", () => this.again(typed))] : []),
      ...found
        .slice(0, typed ? FOUND_MAX : 0)
        .map((form) => button(form.name, form.kind, () => this.pick(form))),
      ...lines.map((line) => button(line, "again", () => this.again(line))),
      ...(typed ? [] : found.map((form) => button(form.name, form.kind, () => this.pick(form)))),
    );
    if (!this.list.children.length) this.list.append(el("p", { class: "reason" }, "No command matches."));
    // The Tab key stops once in the list; the arrow keys go through it.
    for (const one of [...this.list.querySelectorAll("button")].slice(1)) one.tabIndex = -1;
  }

  // From the search field Enter opens the first command found; the arrow keys go through the list.
  step(event) {
    const all = [...this.list.querySelectorAll("button")];
    const at = all.indexOf(document.activeElement);
    const next = { ArrowDown: at + 1, ArrowUp: at - 1 }[event.key];
    if (event.key === "Enter" && at < 0 && !event.ctrlKey) all[0]?.click();
    else if (next >= 0) all[next]?.focus();
    else if (next === -1) this.find.focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // Move the focus to the first field of the form that was opened, or to its heading.
  enter() {
    (this.fields.querySelector("input:enabled, select:enabled") ?? this.title_).focus();
  }

  // Open a form for another part of the page. `words` is "verb name", then optionally the value of the first
  // field.
  prepare(words) {
    const [verb, name, value] = words.split(" ");
    const form = this.forms.find((one) => one.id === `${verb} ${name}`);
    if (!form) return;
    this.pick(form);
    if (value && form.fields[0]) this.inputs.parts[0].put(value);
    this.judge();
  }

  // Choose a command in words that was sent before or typed.
  again(line) {
    this.pick({ ...AS_TYPED, name: line, line });
  }

  pick(form) {
    this.form = form;
    this.disarm();
    text(this.title_, form ? form.name : "No command chosen");
    this.inputs = new Fields(form?.fields ?? [], () => {
      this.disarm();
      this.judge();
    });
    this.fields.replaceChildren(this.inputs.node);
    this.result.replaceChildren();
    this.judge();
  }

  order() {
    return this.form.line ? { text: this.form.line } : { form: this.form.id, values: this.inputs.values() };
  }

  // Ask the station to encode the command without sending it, and show the octets or the error.
  async judge() {
    this.isFit = this.isCritical = false;
    this.depends = [];
    if (!this.form) {
      for (const node of [this.octets, this.line, this.checked]) text(node, "");
    } else {
      const order = this.order(),
        asked = JSON.stringify(order);
      const answer = await store.ask({ do: "plan", ...order });
      if (!this.form || asked !== JSON.stringify(this.order())) return;
      text(
        this.octets,
        (answer.octets ?? [])
          .map((one) =>
            one
              .toUpperCase()
              .replace(/(.{4})/g, "$1 ")
              .trim(),
          )
          .join(" / "),
      );
      text(this.line, answer.line ?? "");
      text(
        this.checked,
        answer.refused ?? `${(answer.messages ?? []).join(", ") || "procedure"}: complete, in range`,
      );
      this.isFit = !answer.refused;
      this.isCritical = Boolean(answer.critical);
      this.depends = answer.subsystems ?? [];
    }
    this.tick();
  }

  toggleArm() {
    if (this.armed) this.disarm();
    else {
      this.armed = performance.now();
      this.tick();
    }
  }
  disarm() {
    this.armed = null;
  }

  // Reason why these words may mean something else on board: one of the subsystems flies another interface
  // than that of the dictionary. Null if there is none.
  difference(subsystems) {
    const name = subsystems?.find((one) => store.mismatches.has(one));
    return name === undefined ? null : `disabled: ${store.mismatches.get(name)}`;
  }

  // Reason why the present command cannot be sent, whatever its values are; null if there is none.
  barrier() {
    return store.barrier() ?? this.difference(this.form?.subsystems) ?? this.difference(this.depends);
  }

  // Whether the present words may be sent: the station has checked them, and they are armed if they are
  // critical. The button shows it a moment later.
  isReady() {
    const isArmed = this.armed && performance.now() - this.armed < ARMED_MS;
    return Boolean(this.form && this.isFit && !this.barrier() && (isArmed || !this.isCritical));
  }

  tick() {
    const rest = this.armed ? ARMED_MS - (performance.now() - this.armed) : 0;
    if (this.armed && rest <= 0) this.disarm();
    const barrier = this.barrier();
    this.fields.disabled = Boolean(this.difference(this.form?.subsystems));
    this.arm.hidden = !this.isCritical;
    this.arm.disabled = !this.isFit || Boolean(barrier);
    text(this.arm, this.armed ? "Disarm" : "Arm");
    this.go.disabled = !this.isReady();
    text(
      this.hint,
      barrier ? barrier : this.isCritical ? "critical: arm, then send within 10 s" : "Ctrl Enter",
    );
    this.left.style.width = `${Math.max(0, (rest / ARMED_MS) * 100)}%`;
  }

  async send() {
    if (!this.isReady()) return;
    this.disarm();
    this.sent = null;
    this.result.replaceChildren();
    const answer = await store.ask({ do: "command", ...this.order() });
    if (answer.refused) {
      this.result.replaceChildren(el("div", { class: "refusal" }, answer.refused));
      return;
    }
    if (answer.time !== undefined) {
      this.result.replaceChildren(el("div", {}, `acts at ${answer.time.toFixed(4)} s`));
      return;
    }
    this.sent = answer.command;
    const known = store.commands.get(this.sent);
    if (known) this.report(known);
    this.tick();
  }

  report(call) {
    const shown = call.words
      ? el(
          "div",
          { class: "refusal" },
          el(
            "div",
            { class: "acts" },
            lights(call.lights),
            el("strong", {}, call.unknown ? "Result not known" : "Refused or failed"),
          ),
          el("div", {}, call.words.replace(/ \[0x[0-9A-Fa-f]+.*?\]$/, "")),
          el(
            "div",
            { class: "mono" },
            call.code !== undefined && call.code !== null
              ? `code 0x${call.code.toString(16).toUpperCase().padStart(4, "0")}`
              : "",
          ),
        )
      : el(
          "div",
          {},
          el(
            "div",
            { class: "acts" },
            lights(call.lights),
            call.over ? "completed" : call.silent ? "no answer for 10 s" : "under way",
          ),
          ...call.answer.slice(0, 12).map((line) => el("div", { class: "mono" }, line)),
        );
    this.result.replaceChildren(shown);
  }

  async save() {
    const answer = await store.ask({ do: "script" });
    if (answer.refused) {
      this.result.replaceChildren(el("div", { class: "refusal" }, answer.refused));
      return;
    }
    const address = URL.createObjectURL(new Blob([answer.text], { type: "text/plain" }));
    el("a", { href: address, download: `${store.hello?.mission ?? "commands"}.scn` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  }
}
