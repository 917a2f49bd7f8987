// SPDX-License-Identifier: Apache-2.0
// Box "Now" over the scene: the plan, procedure, command or phase that is under way; hidden if there is none.

import { every } from "./beat.js";
import { store } from "./store.js";
import { el, put, show, text } from "./dom.js";
import { underWay } from "./under_way.js";

const REFRESH_MS = 200;
const SYMBOL = { done: "done", running: "passing", waiting: "informative" };

const severityOf = (subsystem, event) => store.subsystem(subsystem)?.severities?.[event];

export class Now {
  constructor() {
    this.title = el("span", { class: "name what" });
    this.note = el("span", { class: "hint" });
    this.steps = el("div", { class: "steps" });
    this.part = el("i");
    this.bar = el("div", { class: "runs" }, this.part);
    this.node = el(
      "div",
      { class: "hud now", role: "group", "aria-label": "Under way", hidden: true },
      el("div", { class: "line" }, this.title, this.note),
      this.steps,
      this.bar,
    );
    store.on("event command state player hello", () => this.draw());
    every(REFRESH_MS, () => this.draw());
  }

  present() {
    if (!store.hello) return null;
    return underWay({
      time: store.now(),
      events: store.events,
      commands: [...store.commands.values()],
      plans: store.hello.plans ?? [],
      lanes: store.lanes,
      phases: store.replay?.phases ?? [],
      severityOf,
    });
  }

  draw() {
    const found = this.present();
    if (this.node.hidden !== !found) this.node.hidden = !found;
    if (!found) return;
    text(this.title, found.title);
    put(this.node, "title", found.title);
    text(this.note, found.note);
    if (this.steps.childElementCount !== found.steps.length)
      this.steps.replaceChildren(
        ...found.steps.map(() =>
          el("div", {}, el("span"), el("span", { class: "what" }), el("span", { class: "mono" })),
        ),
      );
    found.steps.forEach(({ words, is, time }, n) => {
      const [sign, what, when] = this.steps.children[n].children;
      show(sign, SYMBOL[is], is);
      text(what, words);
      text(when, time);
      this.steps.children[n].classList.toggle("present", is === "running");
    });
    if (this.bar.hidden !== (found.share === null)) this.bar.hidden = found.share === null;
    put(this.part, "style", `width:${((found.share ?? 0) * 100).toFixed(1)}%`);
  }
}
