// SPDX-License-Identifier: Apache-2.0
// Right column with its tabs: the hand and the fastest housekeeping (Operate), forms of commands (Command),
// all housekeeping (Telemetry), and others.

import { every } from "./beat.js";
import { store } from "./store.js";
import { el, isPageKey, number, put, show, svg, tableHead, tabs, text } from "./dom.js";
import { CommandForm } from "./form.js";
import { Board } from "./board.js";
import { Bus } from "./bus.js";
import { Fastest, Telemetry } from "./telemetry.js";

const RANGE_RAD = 0.35; // Largest angle of the joystick that the page commands.
const AIM_MS = 20,
  AIM_S = 0.03;
const REPEAT_MS = 100; // Time between two lines of the same aim; without one for 500 ms the simulator holds.
const TICK_MAX_MS = 5 * AIM_MS; // A longer time between two ticks counts as this much.
const IDLE_MS = 2000; // Time without input after which the hand is given back.
// Lines of the hand that may wait for their answers: fewer than a station permits a page. The browser gives
// the page its input before the answers.
const LINES_MAX = 12;
const ANSWER_MS = 1000; // If a line of the hand has no answer for this time, the hand is given back.
const FIELD = 80; // Radius of the round field in units of its drawing.
const CEILING_NM = 1.5; // Felt torque of the full arc and of the strongest rumble.
const TRACE_MS = 2000; // Length of the trace of the joystick.
const DEAD_ZONE = 0.08; // Deflection of a gamepad's stick that counts as zero.
const RUMBLE_MS = 60,
  TOUCH_NM = 0.05;
// On a narrow page the left column has no room for states and network.
const NARROW = matchMedia("(max-width: 1279px)");

class Hand {
  constructor() {
    this.aim = null;
    this.asked = 0; // Lines without an answer.
    this.silent = 0; // Time in ms without an answer to any of them.
    this.idle = 0; // Time in ms without input.
    this.ticked = performance.now();
    this.trace = [];
    const path = (style) => svg("path", { style });
    this.traceLine = path("fill:none;stroke:var(--measured);stroke-width:1.5");
    this.arrow = path("fill:none;stroke:var(--force);stroke-width:4");
    this.tip = path("fill:var(--force);stroke:none");
    this.arc = path("fill:none;stroke:var(--force);stroke-width:3");
    this.ring = svg("circle", { r: 8, style: "fill:var(--bg1);stroke:var(--fg0);stroke-width:2.5" });
    this.dot = svg("circle", { r: 2.5, style: "fill:var(--fg0);stroke:none" });
    this.field = svg(
      "svg",
      { class: "field", viewBox: "-92 -92 184 184", role: "img", "aria-label": "Hand on the joystick" },
      svg("circle", { r: FIELD, style: "fill:var(--bg2)" }),
      svg("circle", { r: FIELD / 2, style: "stroke:var(--line)" }),
      svg("path", { d: "M-6 0h12M0 -6v12" }),
      this.traceLine,
      this.arrow,
      this.tip,
      this.arc,
      this.ring,
      this.dot,
    );
    this.sym = el("span");
    this.source = el("span", { class: "name" });
    this.words = el("p");
    this.cells = [0, 1].map(() => [
      el("td", { class: "value num" }),
      el("td", { class: "value num", style: "color:var(--force)" }),
    ]);
    this.take = el("button", { onclick: () => this.toggle() }, "Take the hand ", el("kbd", {}, "H"));
    this.node = el(
      "div",
      { class: "hand" },
      this.field,
      el(
        "div",
        { class: "side" },
        el("div", { style: "display:flex;gap:8px;align-items:center" }, this.sym, this.source),
        this.words,
        el(
          "table",
          {},
          tableHead(["Axis"], ["Hand rad", "num"], ["Felt Nm", "num felt"]),
          el(
            "tbody",
            {},
            ...this.cells.map((cells, n) => el("tr", {}, el("td", {}, String(n + 1)), ...cells)),
          ),
        ),
        el(
          "div",
          { class: "acts", style: "margin-top:auto" },
          this.take,
          el("span", { class: "hint" }, "drag, arrow keys or gamepad; Shift: fine"),
        ),
      ),
    );
    this.listen();
  }

  listen() {
    this.field.addEventListener("pointerdown", (event) => {
      if (!this.aim) return;
      this.field.setPointerCapture(event.pointerId);
      // Read once: reading the width during a movement would make the browser compute the layout, and delay
      // the line of the movement.
      const scale = RANGE_RAD / ((this.field.clientWidth * FIELD) / 184);
      this.from = { x: event.clientX, y: event.clientY, aim: [...this.aim], scale };
    });
    // Raw pointer movements arrive before the page draws its next frame. Browsers provide them to secure
    // pages only.
    const moved = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";
    this.field.addEventListener(moved, (event) => {
      if (!this.aim || !this.from) return;
      const scale = this.from.scale * (event.shiftKey ? 0.25 : 1);
      this.move(
        this.from.aim[0] + (event.clientX - this.from.x) * scale,
        this.from.aim[1] - (event.clientY - this.from.y) * scale,
      );
      this.sendAim();
    });
    this.field.addEventListener("pointerup", () => {
      this.from = null;
    });
    // The browser has taken the pointer away in the middle of a drag, for example for a gesture.
    for (const kind of ["pointercancel", "lostpointercapture"])
      this.field.addEventListener(kind, () => {
        if (this.from) this.release("the pointer was lost");
      });
    window.addEventListener("blur", () => this.release("the window lost the focus"));
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.release("the page is hidden");
    });
    window.addEventListener("gamepaddisconnected", (event) => {
      if (event.gamepad.index === this.pad) this.release("the gamepad was disconnected");
    });
    store.on("link", () => {
      if (!store.link.is_live) this.release(store.link.is_silent ? store.link.text : "link lost");
    });
    this.keys = new Set();
    document.addEventListener("keyup", (event) => this.keys.delete(event.key));
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") {
        this.release("Esc");
        return;
      }
      if (event.target.closest("input, select, textarea, [role=tab]") || event.ctrlKey || event.altKey)
        return;
      if (event.key.toUpperCase() === "H") this.toggle();
      if (this.aim && event.key.startsWith("Arrow")) {
        this.keys.add(event.key);
        event.preventDefault();
      }
    });
    setInterval(() => this.tick(), AIM_MS);
  }

  toggle() {
    if (this.aim) {
      this.release("released");
      return;
    }
    if (this.take.disabled) return;
    const at = this.position() ?? [0, 0];
    this.aim = [...at];
    this.idle = this.silent = 0;
    this.sent = null;
    this.note = "From now on this flight differs from its scenario.";
    this.draw();
  }

  // Deflection of the first gamepad stick that is not at rest, as target of the hand; null if there is none.
  stick() {
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (!pad?.connected || pad.axes.length < 2) continue;
      const size = Math.hypot(pad.axes[0], pad.axes[1]);
      if (size > DEAD_ZONE) this.pad = pad.index;
      if (this.pad !== pad.index) continue;
      const share = size > DEAD_ZONE ? Math.min(1, (size - DEAD_ZONE) / (1 - DEAD_ZONE)) / size : 0;
      return {
        at: [pad.axes[0] * share * RANGE_RAD, -pad.axes[1] * share * RANGE_RAD],
        isMoved: share > 0,
        pad,
      };
    }
    return null;
  }

  followStick() {
    const found = this.from || this.keys.size ? null : this.stick();
    if (!found) {
      if (this.pad !== undefined && !navigator.getGamepads()[this.pad]?.connected)
        this.release("the gamepad was disconnected");
      return;
    }
    if (found.isMoved) this.move(...found.at);
    else this.aim = [...found.at];
    this.rumble(found.pad);
  }

  // Rumble in proportion to the felt torque, and with one short pulse when a contact begins.
  rumble(pad) {
    const felt = Math.hypot(...(store.value(this.source_(), "CUR_VALUES.FELT_TORQUE") ?? [0]));
    this.isTouch ||= felt > TOUCH_NM && (this.felt ?? 0) <= TOUCH_NM; // Stays true until the pulse is played.
    this.felt = felt;
    if (!pad.vibrationActuator || performance.now() - (this.rumbled ?? 0) < RUMBLE_MS - AIM_MS) return;
    this.rumbled = performance.now();
    const effect = {
      duration: RUMBLE_MS,
      strongMagnitude: Math.min(1, felt / CEILING_NM),
      weakMagnitude: this.isTouch ? 1 : 0,
    };
    this.isTouch = false;
    pad.vibrationActuator.playEffect("dual-rumble", effect).catch(() => {
      this.note = "This gamepad does not rumble.";
    });
  }

  move(x, y) {
    const size = Math.hypot(x, y),
      most = RANGE_RAD;
    this.aim = size > most ? [(x / size) * most, (y / size) * most] : [x, y];
    this.idle = 0;
  }

  // Give the hand back: the spring of the operator's simulated arm returns it to its rest position.
  release(why) {
    if (!this.aim) return;
    this.aim = this.from = null;
    this.pad = undefined;
    this.keys.clear();
    store.live("hand rest");
    this.note = `Hand given back: ${why}.`;
    this.draw();
  }

  // Follow gamepad and keys. Repeat an unchanged aim after REPEAT_MS of simulated time, because the simulator
  // holds the hand if no line arrives. If the page was busy, answers and input of that time may still wait to
  // be read, so little of it counts.
  tick() {
    const now = performance.now(),
      passed = Math.min(now - this.ticked, TICK_MAX_MS);
    this.ticked = now;
    if (!this.aim) return;
    this.followStick();
    this.idle += passed;
    this.silent = this.asked ? this.silent + passed : 0;
    if (this.idle > IDLE_MS && !this.from && !this.keys.size) {
      this.release("2 s without input");
      return;
    }
    const step = (0.05 * AIM_MS) / 1000;
    for (const key of this.keys) {
      const [x, y] = {
        ArrowLeft: [-step, 0],
        ArrowRight: [step, 0],
        ArrowUp: [0, step],
        ArrowDown: [0, -step],
      }[key] ?? [0, 0];
      this.move(this.aim[0] + x, this.aim[1] + y);
    }
    const { speed } = store.pace;
    const repeat = speed > 0 ? REPEAT_MS / Math.max(1, speed) : 0;
    const isMoved = this.aim?.some((value, n) => value !== this.sent?.[n]);
    if (isMoved || this.silent > ANSWER_MS || now - this.sentAt >= repeat) this.sendAim();
  }

  // Send the aim at once. If LINES_MAX lines have no answer yet, send the present aim after an answer.
  sendAim() {
    this.isChanged = true;
    if (this.silent > ANSWER_MS) this.release("the station does not answer");
    else this.send();
  }

  async send() {
    if (!this.aim || !this.isChanged || this.asked >= LINES_MAX) return;
    this.isChanged = false;
    this.asked++;
    this.sent = [...this.aim];
    this.sentAt = performance.now();
    const [x, y] = this.sent;
    const answer = await store.live(`hand aim ${x.toFixed(5)} ${y.toFixed(5)} ${AIM_S}`);
    this.asked--;
    this.silent = 0;
    if (answer.refused && this.aim && !store.isOpen()) this.release("link lost");
    else if (answer.refused && this.aim) {
      this.aim = this.from = null;
      this.note = `The simulator refuses the hand: ${answer.refused}`;
      this.draw();
    }
    this.send();
  }

  // The subsystem that reports a felt torque.
  source_() {
    return store
      .members()
      .find((item) => item.parameters.some((leaf) => leaf.name === "CUR_VALUES.FELT_TORQUE"))?.name;
  }
  position() {
    return store.value(this.source_(), "CUR_VALUES.POSITION");
  }

  draw() {
    const source = this.source_();
    const known = store.values.get(source)?.get("CUR_VALUES.POSITION");
    const position = known?.value ?? [0, 0];
    const felt = store.value(source, "CUR_VALUES.FELT_TORQUE") ?? [0, 0];
    const isFresh = known && store.clock() - known.at < Math.max(600, 3 * known.period);
    const state = store.states.get(source)?.state;
    const owner = this.aim ? null : store.handOwner();
    const isThere = Boolean(source) && store.pace.is_there && !store.barrier() && !owner;
    this.node.hidden = Boolean(store.hello) && !source; // Then housekeeping has the whole tab.
    this.take.disabled = !isThere;
    text(this.take.firstChild, this.aim ? "Give back " : "Take the hand ");
    this.field.classList.toggle("taken", Boolean(this.aim));
    this.field.classList.toggle("idle", state !== "OPERATIONAL");
    show(this.sym, this.aim ? "normal" : isThere ? "standby" : "off", this.aim ? "taken" : "not taken");
    text(
      this.source,
      this.aim
        ? this.pad === undefined
          ? "Your hand"
          : `Your hand, gamepad ${this.pad + 1}`
        : owner
          ? `Hand taken ${owner}`
          : "Scripted hand",
    );
    const why = owner
      ? "It is free again one second after its last movement."
      : store.barrier()
        ? store.barrier()
        : !store.pace.is_there
          ? "this flight has no live port"
          : (this.note ??
            (state === "OPERATIONAL"
              ? "moves the robot"
              : `${source} is ${state ?? "not reported"}: the hand has no effect`));
    text(this.words, why);
    const xy = ([a, b], scale) => [a * scale, -b * scale];
    const [x, y] = xy(position, FIELD / RANGE_RAD);
    for (const circle of [this.ring, this.dot]) {
      put(circle, "cx", x);
      put(circle, "cy", y);
    }
    if (isFresh && this.trace[this.trace.length - 1]?.[0] !== store.clock())
      this.trace.push([store.clock(), x, y]);
    while (
      this.trace.length &&
      (this.trace[0][0] < store.clock() - TRACE_MS || this.trace[0][0] > store.clock())
    )
      this.trace.shift();
    put(
      this.traceLine,
      "d",
      this.trace.map(([, a, b], n) => `${n ? "L" : "M"}${a.toFixed(1)} ${b.toFixed(1)}`).join(""),
    );
    this.drawForce(x, y, xy(felt, 150), Math.hypot(...felt));
    position.slice(0, 2).forEach((value, n) => {
      text(this.cells[n][0], known ? number(value, "rad") : "–");
      text(this.cells[n][1], known ? number(felt[n], "Nm") : "–");
    });
  }

  drawForce(x, y, [fx, fy], size) {
    const length = Math.hypot(fx, fy);
    const isShown = length > 4;
    for (const part of [this.arrow, this.tip, this.arc])
      put(part, "visibility", isShown ? "visible" : "hidden");
    if (!isShown) return;
    const [ux, uy] = [fx / length, fy / length];
    const shaft = Math.max(0, length - 8);
    put(this.arrow, "d", `M${x + ux * 8} ${y + uy * 8}L${x + ux * shaft} ${y + uy * shaft}`);
    const [hx, hy] = [x + ux * length, y + uy * length];
    const left = `${hx - ux * 14 - uy * 7} ${hy - uy * 14 + ux * 7}`;
    const right = `${hx - ux * 14 + uy * 7} ${hy - uy * 14 - ux * 7}`;
    put(this.tip, "d", `M${hx} ${hy}L${left}L${right}z`);
    const share = Math.min(0.999, size / CEILING_NM),
      angle = share * 2 * Math.PI,
      r = 13;
    this.arc.style.stroke = size >= CEILING_NM ? "var(--critical)" : "var(--force)";
    const end = `${x + r * Math.sin(angle)} ${y - r * Math.cos(angle)}`;
    put(this.arc, "d", `M${x} ${y - r}A${r} ${r} 0 ${share > 0.5 ? 1 : 0} 1 ${end}`);
  }
}

const KEYS = [
  ["/", "find a command"],
  ["0 3 4 5 6", "prepare this state of the selected subsystem"],
  ["Alt 1 … 4", "select a subsystem"],
  ["Ctrl Enter", "send the command"],
  ["Esc", "disarm, give the hand back, end the zoom, close these keys"],
  ["H", "take the hand, give it back"],
  ["Arrows, Shift", "move the hand, fine"],
  ["Space", "pause or resume simulated time"],
  [".", "step 0.1 s"],
  ["[ ]", "change the speed of simulated time"],
  ["A", "mark the HIGH events as seen, on this page only"],
  ["E C B", "events, commands, bus"],
  ["V", "change the view of the scene"],
  ["T", "move the robot by the simulator’s truth or by telemetry"],
  ["P", "find a parameter"],
  ["Arrows + -", "in the scene: turn, zoom; in the charts: move, zoom"],
  ["L", "follow the flight again, return to it from the replay"],
  ["?", "show these keys"],
  ["Ctrl Shift S", "STOP ALL"],
];

function keysPanel() {
  const rows = KEYS.map(([keys, words]) =>
    el("tr", {}, el("td", {}, el("kbd", {}, keys)), el("td", { class: "words" }, words)),
  );
  return el(
    "div",
    {},
    el(
      "div",
      { class: "scroll", tabindex: 0, role: "group", "aria-label": "Keys" },
      el("table", {}, tableHead(["Key"], ["What it does"]), el("tbody", {}, ...rows)),
      el("p", { class: "reason" }, "Keys do nothing while a field has the focus."),
    ),
  );
}

class Work extends HTMLElement {
  connectedCallback() {
    const moved = ["State", "Network"]
      .map((name) => [
        name,
        el("div"),
        document.querySelector(name === "State" ? "station-states" : "station-network"),
      ])
      .filter(([, , node]) => node);
    this.hand = new Hand();
    this.table = new Fastest();
    this.form = new CommandForm();
    this.telemetry = new Telemetry();
    this.bus = new Bus();
    this.board = new Board();
    this.keys = keysPanel();
    const panels = [
      ["Operate", el("div", {}, this.hand.node, this.table.node)],
      ["Command", el("div", {}, this.form.node)],
      ["Telemetry", el("div", {}, this.telemetry.node)],
      ["Bus", el("div", {}, this.bus.node)],
      ["On board", el("div", {}, this.board.node)],
      ["Keys", this.keys],
      ...moved.map(([name, panel]) => [name, panel]),
    ];
    this.pages = tabs("work", panels);
    this.append(this.pages.list, ...panels.map(([, panel]) => panel));
    this.keysTab = this.pages.list.querySelector("#work-Keys");
    this.keysTab.hidden = true;
    this.arrange(moved);
    NARROW.addEventListener("change", () => this.arrange(moved));
    store.on("parameter", () => {
      this.pages.open("Telemetry");
      this.telemetry.find.focus();
    });
    store.on("prepare again", () => {
      this.pages.open("Command");
      this.form.title_.focus(); // From here the Tab key goes to fields, Arm and Send.
    });
    store.on("device", (which) => {
      this.pages.open("Bus");
      this.bus.open(which);
    });
    store.on("keys", () => this.showKeys());
    store.on("select hello", () => this.draw());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.hideKeys();
      if (!isPageKey(event)) return;
      if (event.key.toUpperCase() === "B") this.pages.open("Bus");
      if (event.key === "?") this.showKeys();
      if (event.key !== "/") return;
      event.preventDefault();
      this.pages.open("Command");
      this.form.find.focus();
    });
    every(50, () => this.hand.draw());
    every(200, () => this.table.draw());
  }

  // On a narrow page states and network are tabs of this panel, otherwise panels of the left column.
  arrange(moved) {
    const column = document.querySelector("nav");
    for (const [name, panel, node] of moved) {
      (NARROW.matches ? panel : column).append(node);
      this.pages.list.querySelector(`#work-${name}`).hidden = !NARROW.matches;
    }
    if (!NARROW.matches && moved.some(([, panel]) => !panel.hidden)) this.pages.open("Operate");
  }

  // Open the tab Keys, or close it if it is open. `Esc` closes it, too.
  showKeys() {
    const open = this.pages.list.querySelector("[aria-selected=true]");
    if (open === this.keysTab) {
      this.hideKeys();
      return;
    }
    this.before = { name: open.textContent, focus: document.activeElement };
    this.keysTab.hidden = false;
    this.pages.open("Keys");
    this.keys.firstChild.focus();
  }

  // Close the tab Keys. If it is shown, the tab and the focus from before return.
  hideKeys() {
    if (this.keysTab.hidden) return;
    this.keysTab.hidden = true;
    if (this.keysTab.getAttribute("aria-selected") !== "true") return;
    this.pages.open(this.before?.name ?? "Operate");
    this.before?.focus.focus();
  }

  draw() {
    this.hand.draw();
    this.table.draw();
  }
}
customElements.define("station-work", Work);
