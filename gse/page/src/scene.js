// SPDX-License-Identifier: Apache-2.0
// The robot in its world, moved by telemetry. Geometry comes from the world of the mission; z is up.

import * as THREE from "three";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";

import { Arm, LOOK, shape } from "./body.js";
import { store } from "./store.js";
import { el, number, text } from "./dom.js";
import { moving, place, placed, poses, tipForce, tipOf } from "./kinematics.js";

const FORCE_SCALE = 0.0024; // Metres per newton.
const FORCE_LEAST = 0.5;
const GHOST_M = 0.002,
  GHOST_RAD = (0.5 * Math.PI) / 180;
const TRACE_S = 6;
const STALE_PERIODS = 3,
  STALE_MS = 350;
const SOFTWARE_MS = 100; // Between two pictures that a processor draws: the rest of the page stays quick.
const NEAR = 0.1; // Share of the range that counts as near a limit.
const token = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

const VIEWS = { Iso: [0.62, -0.98, 0.36], Side: [0, -1.25, 0.05], Tool: [1.05, -0.42, 0.25] };

function coil(from, to, turns = 13, radius = 0.011) {
  const points = [];
  for (let n = 0; n <= turns * 16; n++) {
    const share = n / (turns * 16),
      angle = share * turns * 2 * Math.PI;
    points.push(
      new THREE.Vector3(
        from[0] + (to[0] - from[0]) * share + radius * Math.cos(angle),
        from[1] + radius * Math.sin(angle),
        from[2] + (to[2] - from[2]) * share,
      ),
    );
  }
  return new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), turns * 20, 0.0018, 6);
}

class Scene extends HTMLElement {
  connectedCallback() {
    this.canvas = el("canvas", { tabindex: 0, role: "img", "aria-label": "The robot" });
    this.views = el(
      "div",
      { class: "hud tr choice", role: "group", "aria-label": "View" },
      ...[...Object.keys(VIEWS), "Fit"].map((name) =>
        el("button", { "aria-pressed": String(name === "Iso"), onclick: () => this.view(name) }, name),
      ),
    );
    this.rate = el("div", { class: "hud tl name" }, "Telemetry");
    this.sourceButtons = Object.fromEntries(
      [
        ["telemetry", "Telemetry"],
        ["truth", "Simulator’s truth"],
      ].map(([name, words]) => [
        name,
        el("button", { onclick: () => (store.replay ?? this).use(name) }, words),
      ]),
    );
    this.sources = el(
      "div",
      { class: "hud tl choice", role: "group", "aria-label": "What moves the robot", hidden: true },
      ...Object.values(this.sourceButtons),
    );
    this.values = {
      x: el("span", { class: "value" }),
      z: el("span", { class: "value" }),
      force: el("span", { class: "value force" }),
    };
    const line = (name, value, unit) => [
      el("span", { class: "name", style: "font-weight:500" }, name),
      value,
      el("span", { class: "hint" }, unit),
    ];
    this.hud = el(
      "div",
      { class: "hud bl" },
      ...line("Tip x", this.values.x, "mm"),
      ...line("Tip z", this.values.z, "mm"),
      ...line("Force", this.values.force, "N"),
    );
    this.forceLabel = el("div", { class: "label force", "aria-hidden": "true", hidden: true });
    this.ghostLabel = el(
      "div",
      { class: "label ghost", "aria-hidden": "true", hidden: true },
      "desired position",
    );
    this.veil = el("div", { class: "veil", hidden: true }, el("span"));
    const key = (colour, words) =>
      el(
        "span",
        { class: "hint", style: "margin-right:10px" },
        el("i", { class: "key", style: `background:var(--${colour})` }),
        words,
      );
    this.append(
      this.canvas,
      this.rate,
      this.sources,
      this.views,
      this.hud,
      el(
        "div",
        { class: "hud br" },
        key("force", "force, 2.4 mm/N"),
        key("measured", `trace ${TRACE_S} s`),
        el(
          "span",
          { class: "hint rings", style: "margin-right:10px", hidden: true },
          "white ring: brake holds",
        ),
        el("span", { class: "hint" }, "grid 50 mm"),
      ),
      this.forceLabel,
      this.ghostLabel,
      this.veil,
    );
    this.joints = [];
    this.trace = [];
    try {
      this.start();
    } catch {
      this.canvas.hidden = true;
      this.veil.hidden = false;
      text(this.veil.firstChild, "This browser draws no 3D: values and curves only");
      store.on("film", ({ row }) => this.tell(row));
      return;
    }
    store.on("hello", () => {
      this.build();
      this.mark("telemetry");
    });
    store.on("pace", () => this.offer());
    store.on("other-source", () => {
      const from = store.replay ?? this;
      const other = this.sourceButtons[from.which === "truth" ? "telemetry" : "truth"];
      if (!this.sources.hidden && !other.disabled) other.click();
    });
    store.on("housekeeping", (message) => {
      if (this.which !== "truth") this.take(message);
    });
    store.on("truth", (message) => {
      if (this.which === "truth") this.take({ ...message, subsystem: this.source });
    });
    store.on("theme", () => this.colours());
    store.on("link", () => this.dim());
    store.on("film", (instant) => this.project(instant));
    setInterval(() => this.dim(), STALE_MS);
    document.addEventListener("keydown", (event) => {
      if (event.key.toUpperCase() !== "V" || event.target.closest("input, select, textarea") || event.ctrlKey)
        return;
      const names = [...this.views.children].map((button) => button.textContent);
      this.view(names[(names.indexOf(this.viewName) + 1) % names.length]);
    });
    setInterval(() => this.describe(), 5000);
  }

  start() {
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    const gl = this.renderer.getContext();
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    const isSoftware = /swiftshader|llvmpipe|software/i.test(
      info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "",
    );
    this.renderer.setPixelRatio(isSoftware ? 1 : Math.min(2, devicePixelRatio));
    this.renderer.shadowMap.enabled = !isSoftware;
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.world = new THREE.Scene();
    if (isSoftware) {
      // Reflections of a room would take seconds to compute.
      for (const name of Object.keys(LOOK))
        LOOK[name] = new THREE.MeshLambertMaterial({ color: LOOK[name].color });
      this.world.add(new THREE.HemisphereLight(0xffffff, 0x8a8f96, 2));
    } else {
      const room = new THREE.PMREMGenerator(this.renderer);
      this.world.environment = room.fromScene(new RoomEnvironment(), 0.04).texture;
      this.world.environmentIntensity = 0.55;
    }
    const light = new THREE.DirectionalLight(0xffffff, 1.7);
    light.position.set(-0.3, -0.9, 1.4);
    light.castShadow = true;
    light.shadow.mapSize.set(2048, 2048);
    Object.assign(light.shadow.camera, { left: -0.8, right: 0.8, top: 0.8, bottom: -0.8, far: 4 });
    this.world.add(light);
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01, 30);
    this.camera.up.set(0, 0, 1);
    this.target = new THREE.Vector3(0.2, 0, 0.05);
    this.orbit();
    new ResizeObserver(() => this.resize()).observe(this);
    this.view("Iso");
    let drawn = 0;
    const frame = (now) => {
      requestAnimationFrame(frame);
      if (isSoftware && now - drawn < SOFTWARE_MS) return;
      drawn = now;
      this.frame();
    };
    requestAnimationFrame(frame);
  }

  orbit() {
    let from = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointerup", () => {
      from = null;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!from) return;
      const arm = this.camera.position.clone().sub(this.target);
      const length = arm.length();
      const turn = Math.atan2(arm.y, arm.x) - (event.clientX - from[0]) * 0.006;
      const rise = Math.max(
        -0.3,
        Math.min(1.5, Math.asin(arm.z / length) + (event.clientY - from[1]) * 0.006),
      );
      from = [event.clientX, event.clientY];
      this.camera.position
        .set(Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise))
        .multiplyScalar(length)
        .add(this.target);
      this.isChanged = true;
    });
    this.canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.camera.position
          .sub(this.target)
          .multiplyScalar(Math.exp(event.deltaY * 0.001))
          .add(this.target);
        this.isChanged = true;
      },
      { passive: false },
    );
  }

  view(name) {
    this.viewName = name;
    for (const button of this.views.children)
      button.setAttribute("aria-pressed", String(button.textContent === name));
    const reach = this.reach ?? 0.47;
    if (name === "Fit") {
      const direction = this.camera.position.clone().sub(this.target).normalize();
      this.camera.position.copy(this.target).addScaledVector(direction, reach * 3.1);
    } else {
      this.camera.position
        .set(...VIEWS[name])
        .multiplyScalar(reach / 0.47)
        .add(this.target);
    }
    this.isChanged = true;
  }

  build() {
    if (this.content) this.world.remove(this.content);
    this.content = new THREE.Group();
    this.world.add(this.content);
    const world = store.hello.world;
    this.last = this.joints = this.drawn = this.before = this.robot = this.base = null;
    this.trace = [];
    this.source = store.members().find((item) => store.drives(item))?.name;
    if (!world?.robots.length) return;
    const driven = Object.values(world.drives);
    this.robot =
      world.robots.find((robot) => driven.some((joint) => joint.startsWith(`${robot.name}.`))) ??
      world.robots[0];
    this.bodies = world.robots.map((robot) => ({ robot, arm: new Arm(robot, LOOK) }));
    this.arm = this.bodies.find(({ robot }) => robot === this.robot).arm;
    for (const { robot, arm } of this.bodies) {
      const { positions, base } = placed(robot);
      arm.set(positions, base);
      this.content.add(arm.node);
    }
    this.touches = [];
    this.addFixtures(Object.values(world.fixtures).flat());
    this.springs = world.springs.map((about) => {
      const mesh = new THREE.Mesh(undefined, LOOK.metal);
      this.content.add(mesh);
      return { ...about, mesh, shown: "" };
    });
    this.reach = Math.max(
      0.3,
      this.robot.joints.reduce((sum, joint) => sum + Math.hypot(...place(joint.pose)), 0),
    );
    this.target.set(this.reach * 0.42, 0, this.reach * 0.1);
    if (this.robot.free || world.robots.length > 1) this.frameAll();
    this.floor = new THREE.GridHelper(
      Math.ceil((this.reach * 4) / 0.05) * 0.05,
      Math.ceil((this.reach * 4) / 0.05),
    );
    this.floor.rotateX(Math.PI / 2);
    this.floor.position.set(0.2, 0, this.level);
    this.floor.visible = !this.robot.free;
    this.content.add(this.floor);
    this.addGhost();
    this.addForce();
    this.addLimits();
    this.line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
    this.content.add(this.line);
    this.content.traverse((node) => {
      if (node.isMesh && node !== this.shaft && node !== this.point)
        node.castShadow = node.receiveShadow = true;
    });
    this.colours();
    this.pose(placed(this.robot).positions);
    this.view(this.viewName);
    this.dim();
  }

  // The camera looks at all robots as they start.
  frameAll() {
    const box = new THREE.Box3();
    this.content.updateMatrixWorld(true);
    for (const { arm } of this.bodies) box.expandByObject(arm.node);
    const size = box.getSize(new THREE.Vector3());
    this.reach = Math.max(0.3, size.length() * 0.75);
    box.getCenter(this.target);
  }

  // Where the robot of the scene is by a row of telemetry or truth.
  where(robot, row) {
    return placed(
      robot,
      row,
      store.replay?.which === "truth" ? store.replay.names : null,
      robot === this.robot,
    );
  }

  tipAt(row) {
    const { positions, base } = this.where(this.robot, row);
    return place(poses(this.robot, positions, base).links.get(tipOf(this.robot)));
  }

  // What a fixture has below the floor, the lowest face of its boxes, is not drawn.
  addFixtures(shapes) {
    const bottoms = shapes
      .filter((about) => about.kind === "box")
      .map((about) => place(about.pose)[2] - about.size[2] / 2);
    this.level = Math.min(0, ...bottoms);
    this.renderer.localClippingEnabled = true;
    LOOK.ground.clippingPlanes = [new THREE.Plane(new THREE.Vector3(0, 0, 1), -this.level)];
    for (const about of shapes) this.content.add(shape(about, LOOK.ground));
  }

  addGhost() {
    this.ghostLook = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.2, depthWrite: false });
    this.ghostEdge = new THREE.LineBasicMaterial();
    const looks = {
      shell: this.ghostLook,
      housing: this.ghostLook,
      cap: this.ghostLook,
      metal: this.ghostLook,
    };
    this.ghost = new Arm(this.robot, looks);
    const meshes = [];
    this.ghost.node.traverse((node) => {
      if (node.isMesh) meshes.push(node);
    });
    for (const mesh of meshes)
      mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry, 50), this.ghostEdge));
    this.ghost.node.visible = false;
    this.content.add(this.ghost.node);
  }

  addForce() {
    this.forceLook = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true });
    this.shaft = new THREE.Mesh(
      new THREE.CylinderGeometry(0.0042, 0.0042, 1, 12).translate(0, 0.5, 0),
      this.forceLook,
    );
    this.point = new THREE.Mesh(
      new THREE.ConeGeometry(0.011, 0.024, 16).translate(0, 0.012, 0),
      this.forceLook,
    );
    this.shaft.renderOrder = this.point.renderOrder = 9;
    this.content.add(this.shaft, this.point);
  }

  // An arc of the range of each joint, with its present place.
  addLimits() {
    this.arcs = moving(this.robot)
      .filter((joint) => joint.kind === "revolute" && joint.lower !== null && joint.upper - joint.lower < 6)
      .map((joint) => {
        const group = this.arm.groups.get(joint.name).still;
        const axis = new THREE.Vector3(...joint.axis);
        const outward = Math.abs(axis.x) > 0.9 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(1, 0, 0);
        const radius = this.arm.size * 0.3;
        const at = (angle, distance) =>
          outward
            .clone()
            .applyAxisAngle(axis, angle)
            .multiplyScalar(distance)
            .addScaledVector(axis, this.arm.size * 0.2);
        const points = [];
        for (let n = 0; n <= 48; n++)
          points.push(at(joint.lower + ((joint.upper - joint.lower) * n) / 48, radius));
        const look = new THREE.LineBasicMaterial();
        points.unshift(at(joint.lower, radius * 0.86));
        points.push(at(joint.upper, radius * 0.86));
        const pointer = new THREE.Mesh(
          new THREE.ConeGeometry(radius * 0.1, radius * 0.22, 3),
          new THREE.MeshBasicMaterial(),
        );
        group.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), look), pointer);
        const n = moving(this.robot).indexOf(joint);
        return {
          joint,
          look,
          pointer,
          axis,
          n,
          at: (angle) => at(angle, radius * 0.86),
          out: (angle) => at(angle, 1).sub(at(angle, 0)),
        };
      });
  }

  colours() {
    if (!this.content || !this.robot) return;
    const isLight = document.documentElement.dataset.theme === "light";
    this.forceLook.color.set(token("force"));
    this.ghostLook.color.set(token("desired"));
    this.ghostEdge.color.set(token("desired"));
    this.line.material.color.set(token("measured"));
    for (const arrow of this.touches) arrow.setColor(token("force"));
    this.floor.material.color.set(isLight ? 0xb5c0ca : 0x2c3742);
    this.floor.material.vertexColors = false;
    this.floor.material.needsUpdate = true;
    LOOK.ground.color.set(isLight ? 0xb9c0c6 : 0x6f7d8a);
    this.isChanged = true;
  }

  // Numbers of the tip without a picture.
  tell(row) {
    const robot = (this.robot = store.hello.world?.robots[0]);
    this.joints = robot && row ? this.where(robot, row).positions : [];
    if (!robot || !row) return;
    const tip = this.tipAt(row),
      force = tipForce(robot, row, this.joints, this.where(robot, row).base);
    text(this.values.x, number(tip[0] * 1000, "mm"));
    text(this.values.z, number(tip[2] * 1000, "mm"));
    text(this.values.force, force ? number(force.size, "N") : "–");
  }

  // The instant of a replay: the pose, and what the tip has done before it.
  project({ time, row }) {
    if (!this.robot) return;
    this.veil.hidden = Boolean(row);
    text(this.veil.firstChild, "no position in the record at this instant");
    this.rate.hidden = true;
    this.sources.hidden = false;
    for (const [name, button] of Object.entries(this.sourceButtons)) {
      button.setAttribute("aria-pressed", String(name === store.replay.which));
      button.disabled = !store.replay[name]?.t.length;
    }
    this.classList.toggle("truth", store.replay.which === "truth");
    if (!row) return;
    const before = this.trace[this.trace.length - 1]?.[0] ?? -1;
    if (time < before || time > before + 0.5)
      this.trace = store.replay.before(TRACE_S).map(([t, one]) => [t, ...this.tipAt(one)]);
    const { positions } = this.where(this.robot, row);
    this.before = positions;
    this.last = { time, values: row, positions, at: 0, period: 1 };
    this.shownTime = time;
    this.pose(positions);
  }

  // Beside a flight with a live port the simulator's truth can move the robot, marked as such.
  offer() {
    if (store.replay) return;
    this.sources.classList.add("below");
    this.sources.hidden = !store.pace.is_there;
    if (!store.pace.is_there && this.which === "truth") this.mark("telemetry");
  }

  async use(which) {
    const answer = await store.ask({ do: "watch", truth: which === "truth" });
    if (!answer.refused) this.mark(which);
  }

  mark(which) {
    if (store.replay) return;
    this.which = which;
    this.classList.toggle("truth", which === "truth");
    for (const [name, button] of Object.entries(this.sourceButtons))
      button.setAttribute("aria-pressed", String(name === which));
    if (this.last) this.last = { ...this.last, time: this.last.time - 1 }; // The other source may be a little behind.
    this.trace = [];
  }

  // What is drawn of a link or a report that has ended is marked as past; a force is not drawn at all then.
  dim() {
    if (!this.robot || store.replay) return;
    const isStale =
      Boolean(this.last) &&
      !store.pace.is_paused &&
      performance.now() - this.last.at > STALE_PERIODS * Math.max(STALE_MS, this.last.period);
    this.veil.hidden = store.link.is_live && !isStale;
    text(
      this.veil.firstChild,
      `${store.link.is_live ? `${this.source} reports no position` : store.link.text}; last seen ${(this.last?.time ?? store.time).toFixed(3)} s`,
    );
    if (isStale === this.isStale) return;
    this.isStale = isStale;
    if (this.drawn) this.pose(this.drawn);
  }

  take(message) {
    if (message.subsystem !== this.source || !message.values["CUR_VALUES.POSITION"] || !this.robot) return;
    if (this.last && message.time < this.last.time && message.time > this.last.time - 60) return;
    const period = this.last
      ? Math.min(0.3, Math.max(0.01, message.time - this.last.time)) / (store.pace.speed || 1)
      : 0.05;
    if (period < 0.2)
      text(
        this.rate,
        `${this.which === "truth" ? "Simulator’s truth" : "Telemetry"} ${Math.round(1 / (period * (store.pace.speed || 1)))} Hz`,
      );
    this.before = this.drawn ?? message.values["CUR_VALUES.POSITION"];
    this.last = {
      time: message.time,
      values: message.values,
      positions: message.values["CUR_VALUES.POSITION"],
      at: performance.now(),
      period: Math.min(300, period * 1000),
    };
  }

  frame() {
    if (this.last && this.robot) {
      const share = Math.min(1, (performance.now() - this.last.at) / this.last.period);
      const goal = this.last.positions;
      const now = goal.map(
        (value, n) => (this.before[n] ?? value) + (value - (this.before[n] ?? value)) * share,
      );
      if (
        !this.drawn ||
        now.some((value, n) => Math.abs(value - this.drawn[n]) > 1e-5) ||
        this.shownTime !== this.last.time
      ) {
        this.pose(now);
        this.shownTime = this.last.time;
      }
    }
    if (this.isChanged) {
      this.isChanged = false;
      this.camera.lookAt(this.target);
      this.camera.updateMatrixWorld();
      this.renderer.render(this.world, this.camera);
      this.labels();
    }
  }

  pose(positions) {
    this.drawn = this.joints = positions;
    const values = this.last?.values ?? {};
    for (const { robot, arm } of this.bodies) {
      const found = this.where(robot, values);
      arm.set(robot === this.robot ? positions : found.positions, found.base);
      arm.showBrakes(found.brakes);
      this.querySelector(".rings").hidden = !found.brakes?.length;
      if (robot === this.robot) this.follow(found.base);
    }
    const tip = place(poses(this.robot, positions, this.base).links.get(tipOf(this.robot)));
    this.tip = tip;
    text(this.values.x, number(tip[0] * 1000, "mm"));
    text(this.values.z, number(tip[2] * 1000, "mm"));
    this.drawForce(values, tip);
    this.drawTouches(values);
    this.drawGhost(values);
    this.drawLimits(positions);
    this.drawSprings(tip);
    this.trace.push([store.time, ...tip]);
    while (this.trace.length > 2 && this.trace[0][0] < store.time - TRACE_S) this.trace.shift();
    this.line.geometry.dispose();
    this.line.geometry = new THREE.BufferGeometry().setFromPoints(
      this.trace.map(([, ...point]) => new THREE.Vector3(...point)),
    );
    this.isChanged = true;
  }

  // The camera stays with a robot whose base is free.
  follow(base) {
    if (this.robot.free && this.base) {
      const moved = new THREE.Vector3(...place(base)).sub(new THREE.Vector3(...place(this.base)));
      this.camera.position.add(moved);
      this.target.add(moved);
    }
    this.base = base;
  }

  // Where the truth has several contacts or springs, each of their forces at its place.
  drawTouches(values) {
    const found = [...(values.CONTACTS ?? []), ...(values.SPRING ?? [])];
    for (let n = 0; n < Math.max(found.length / 6, this.touches.length); n++) {
      const at = new THREE.Vector3(...found.slice(6 * n, 6 * n + 3)),
        force = new THREE.Vector3(...found.slice(6 * n + 3, 6 * n + 6));
      if (!this.touches[n]) {
        this.touches[n] = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), at, 1, token("force"));
        this.content.add(this.touches[n]);
      }
      const arrow = this.touches[n],
        size = found.length > 6 * n ? force.length() : 0;
      arrow.visible = size >= FORCE_LEAST;
      if (!arrow.visible) continue;
      arrow.position.copy(at);
      arrow.setDirection(force.normalize());
      arrow.setLength(Math.max(0.03, size * FORCE_SCALE));
    }
  }

  drawForce(values, tip) {
    const found = this.isStale ? null : tipForce(this.robot, values, this.last?.positions, this.base);
    this.force = found?.size ?? 0;
    text(this.values.force, found ? number(this.force, "N") : "–");
    const isShown = this.force >= FORCE_LEAST;
    this.shaft.visible = this.point.visible = isShown;
    this.forceLabel.hidden = !isShown;
    if (!isShown) return;
    const direction = new THREE.Vector3(...found.force).normalize();
    const length = this.force * FORCE_SCALE;
    this.forceVector = found.force;
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction);
    this.shaft.position.set(...tip);
    this.shaft.quaternion.copy(turn);
    this.shaft.scale.set(1, Math.max(0.001, length), 1);
    this.point.position.set(...tip).addScaledVector(direction, length);
    this.point.quaternion.copy(turn);
    text(this.forceLabel, `${this.force.toFixed(1)} N`);
    this.forceEnd = this.point.position.clone().addScaledVector(direction, 0.02);
  }

  // Compares values of one report: what is drawn is one period behind.
  drawGhost(values) {
    const desired = values["DES_POSITION"] ?? values["CUR_VALUES.DESIRED"],
      positions = this.last?.positions;
    this.ghost.node.visible = false;
    this.ghostLabel.hidden = true;
    const state = store.states.get(this.source)?.state;
    if (this.isStale || !desired || desired.length < moving(this.robot).length || state !== "OPERATIONAL")
      return;
    const tipAt = (joints) => place(poses(this.robot, joints, this.base).links.get(tipOf(this.robot)));
    const there = tipAt(desired),
      here = tipAt(positions);
    const isFar =
      Math.hypot(...there.map((value, n) => value - here[n])) > GHOST_M ||
      desired.some((value, n) => Math.abs(value - positions[n]) > GHOST_RAD);
    if (!isFar) return;
    this.ghost.set(desired, this.base);
    this.ghost.node.visible = true;
    this.ghostEnd = new THREE.Vector3(...there);
    this.ghostLabel.hidden = false;
  }

  drawLimits(positions) {
    for (const { joint, look, pointer, at, out, n } of this.arcs) {
      const range = joint.upper - joint.lower,
        value = positions[n];
      const rest = Math.min(value - joint.lower, joint.upper - value) / range;
      const colour = token(rest < 0 ? "critical" : rest < NEAR ? "caution" : "fg2");
      look.color.set(colour);
      pointer.material.color.set(rest < NEAR ? colour : token("fg0"));
      pointer.position.copy(at(value));
      pointer.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), out(value).normalize());
    }
  }

  // Telemetry does not say whether the spring hangs on the tip: it does if the tip pulls near and above its hook.
  drawSprings(tip) {
    for (const spring of this.springs) {
      const { hook } = spring,
        anchor = [hook[0], hook[1], hook[2] - spring.length[0]];
      const hooked = this.last?.values.HOOKED?.[0];
      const isPulled =
        hooked !== undefined
          ? hooked > 0.5
          : this.force > 3 &&
            (this.forceVector?.[2] ?? 0) < 0 &&
            tip[2] > hook[2] - 0.01 &&
            Math.hypot(tip[0] - hook[0], tip[1] - hook[1]) < 0.06;
      const top = isPulled ? tip : hook;
      const shown = top.map((value) => value.toFixed(3)).join();
      if (spring.shown === shown) continue;
      spring.shown = shown;
      spring.mesh.geometry?.dispose();
      spring.mesh.geometry = coil(anchor, top);
    }
  }

  labels() {
    const put = (label, point, below = 0) => {
      if (label.hidden || !point) return;
      const flat = point.clone().project(this.camera);
      const x = ((flat.x + 1) / 2) * this.clientWidth + 10,
        y = ((1 - flat.y) / 2) * this.clientHeight - 11 + below;
      label.style.transform = `translate(${Math.max(0, Math.min(this.clientWidth - 110, x)).toFixed(0)}px, ${Math.max(0, Math.min(this.clientHeight - 24, y)).toFixed(0)}px)`;
    };
    put(this.forceLabel, this.forceEnd);
    put(this.ghostLabel, this.ghostEnd, 24);
  }

  resize() {
    const width = this.clientWidth,
      height = this.clientHeight;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.isChanged = true;
  }

  describe() {
    if (!this.tip) return;
    this.canvas.setAttribute(
      "aria-label",
      `The robot: tip at x ${(this.tip[0] * 1000).toFixed(0)} mm, z ${(this.tip[2] * 1000).toFixed(0)} mm, force ${this.force.toFixed(1)} N`,
    );
  }
}
customElements.define("station-scene", Scene);
