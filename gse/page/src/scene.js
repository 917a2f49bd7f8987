// SPDX-License-Identifier: Apache-2.0
// 3D view of the robots in their world, moved by telemetry or by the truth of the simulator. Geometry comes
// from the world of the mission; z is up.

import * as THREE from "three";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";

import { Actuators } from "./actuators.js";
import { beat } from "./beat.js";
import { Arm, cutBelow, FACETS, LOOK, shape } from "./body.js";
import { SceneMarks, token, TRACE_S, TRUTH } from "./scene_marks.js";
import { store } from "./store.js";
import { el, isPageKey, number, put, text } from "./dom.js";
import { Corners } from "./scene_corners.js";
import { orbit } from "./orbit.js";
import { LEAST_MS } from "./pace.js";
import { picking } from "./pick.js";
import { Now } from "./now.js";
import { isSoftware, Pictures } from "./picture.js";
import { leadOf, moving, place, placedByTelemetry, placedByTruth, poses } from "./kinematics.js";
import { tipForce, tipOf } from "./kinematics.js";
import { LiveTruth, notReported, reportedBase } from "./truth.js";

const STALE_PERIODS = 3,
  STALE_MS = 200; // Age at which the last report is stale, at least; then a veil covers the scene.

// Positions of the camera relative to the middle of an arm with this reach.
const REACH_M = 0.47;
const VIEWS = { Iso: [0.62, -0.98, 0.36], Side: [0, -1.25, 0.05], Tool: [1.05, -0.42, 0.25] };

const LEAST_ASPECT = 1.15; // In a narrower scene the camera shows the same width as in one of this aspect.

class Scene extends SceneMarks {
  connectedCallback() {
    this.canvas = el("canvas", { tabindex: 0, role: "img", "aria-label": "The robot" });
    this.views = el(
      "div",
      { class: "hud tr choice", role: "group", "aria-label": "View" },
      ...[...Object.keys(VIEWS), "Fit"].map((name) =>
        el("button", { "aria-pressed": String(name === "Iso"), onclick: () => this.view(name) }, name),
      ),
    );
    this.sourceButtons = Object.fromEntries(
      Object.entries({ telemetry: "Telemetry", truth: "Truth" }).map(([name, words]) => [
        name,
        el("button", { "data-source": name, onclick: () => (store.replay ?? this).use(name) }, words),
      ]),
    );
    this.sourceButtons.truth.title = "The true state of the simulator (T)";
    this.sourceButtons.truth.hidden = true;
    this.truthMark = el("div", { class: "hud tl below name", hidden: true }, TRUTH);
    this.sources = el(
      "div",
      { class: "hud tl choice", role: "group", "aria-label": "What moves the robot" },
      ...Object.values(this.sourceButtons),
    );
    this.supplement = el("div", { class: "hud tl lacking hint", hidden: true });
    this.corners = new Corners();
    this.values = this.corners.values;
    this.forceLabel = el("div", { class: "label force", "aria-hidden": "true", hidden: true });
    this.ghostLabel = el(
      "div",
      { class: "label ghost", "aria-hidden": "true", hidden: true },
      "desired position",
    );
    this.veil = el("div", { class: "veil", hidden: true }, el("span"));
    this.append(
      this.canvas,
      new Now().node,
      this.sources,
      this.truthMark,
      this.supplement,
      this.views,
      this.corners.numbers,
      this.corners.legend,
      this.forceLabel,
      this.ghostLabel,
      this.veil,
      (this.none = el("p", { class: "none" })),
    );
    this.joints = [];
    this.trace = [];
    this.extent = { width: 0, height: 0 }; // Stored, because reading it makes the browser compute the layout.
    try {
      this.start();
    } catch {
      this.canvas.hidden = true;
      this.veil.hidden = false;
      text(this.veil.firstChild, "This browser cannot draw the 3D view: only values and curves are shown");
      store.on("film", ({ row }) => this.tell(row));
      return;
    }
    store.on("hello", () => {
      this.isWatching = false; // A new connection: the station sends the truth only after a new request.
      this.build();
      this.mark("telemetry");
      if (!store.replay) this.watch();
    });
    store.on("pace", () => this.offer());
    store.on("other-source", () => {
      const from = store.replay ?? this;
      const other = this.sourceButtons[from.which === "truth" ? "telemetry" : "truth"];
      if (!other.hidden && !other.disabled) other.click();
    });
    store.on("housekeeping", (message) => {
      if (this.which !== "truth") this.take(message);
    });
    store.on("truth", (message) => {
      this.truth?.take(message);
      if (this.which === "truth") this.take({ ...message, subsystem: this.source });
    });
    store.on("theme", () => this.colours());
    store.on("link", () => this.dim());
    store.on("film", (instant) => this.project(instant));
    setInterval(() => this.dim(), STALE_MS);
    document.addEventListener("keydown", (event) => {
      if (event.key.toUpperCase() !== "V" || !isPageKey(event)) return;
      const names = [...this.views.children].map((button) => button.textContent);
      this.view(names[(names.indexOf(this.viewName) + 1) % names.length]);
    });
    setInterval(() => this.describe(), 5000);
  }

  start() {
    const isComputed = isSoftware();
    this.renderer = new THREE.WebGLRenderer({
      canvas: isComputed ? document.createElement("canvas") : this.canvas,
      antialias: !isComputed,
      alpha: true,
    });
    this.renderer.setPixelRatio(isComputed ? 1 : Math.min(2, devicePixelRatio));
    this.renderer.shadowMap.enabled = !isComputed;
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.world = new THREE.Scene();
    if (isComputed) {
      FACETS.share = 0.5;
      // Without a graphics processor the reflections of a room would take seconds to compute.
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
    orbit(this.canvas, this.camera, this.target, () => this.change(), picking(this));
    new ResizeObserver(() => this.resize()).observe(this);
    this.view("Iso");
    if (isComputed) this.computePictures();
    else this.renderer.setAnimationLoop(() => this.frame());
  }

  // Without a graphics processor a picture begins when something has changed.
  computePictures() {
    this.pictures = new Pictures(
      this.canvas,
      this.renderer.getContext(),
      (scale, isResting) => this.frame(scale, isResting),
      () => {
        this.labels();
        beat();
      },
    );
    store.on("hello housekeeping truth film theme link", () => this.pictures.wake());
  }

  // The scene looks different from now on.
  change() {
    this.isChanged = true;
    this.pictures?.wake();
  }

  view(name) {
    this.viewName = name;
    for (const button of this.views.children)
      button.setAttribute("aria-pressed", String(button.textContent === name));
    const reach = this.reach ?? REACH_M;
    if (name === "Fit") {
      const direction = this.camera.position.clone().sub(this.target).normalize();
      this.camera.position.copy(this.target).addScaledVector(direction, reach * 3.1);
    } else {
      this.camera.position
        .set(...(name === "Iso" ? (this.iso ?? VIEWS.Iso) : VIEWS[name]))
        .multiplyScalar(reach / REACH_M)
        .add(this.target);
    }
    this.change();
  }

  build() {
    if (this.content) this.world.remove(this.content);
    this.content = new THREE.Group();
    this.world.add(this.content);
    const world = store.hello.world;
    this.last = this.joints = this.drawn = this.before = this.robot = this.base = null;
    this.trace = [];
    this.source = store.members().find((item) => store.drives(item))?.name;
    this.classList.toggle("empty", !world?.robots.length); // Then the scene says why nothing is drawn.
    const problem = store.hello.world_problem;
    text(
      this.none,
      problem ? `The world cannot be drawn: ${problem}` : "This mission has no robot that can be drawn.",
    );
    if (!world?.robots.length) return;
    this.robot = leadOf(world);
    this.bodies = world.robots.map((robot) => ({ robot, arm: new Arm(robot, LOOK) }));
    this.arm = this.bodies.find(({ robot }) => robot === this.robot).arm;
    for (const { robot, arm } of this.bodies) {
      const { positions, base } = placedByTruth(robot, null, {});
      arm.set(positions, base);
      this.content.add(arm.node);
    }
    this.truth = new LiveTruth();
    this.actuators = new Actuators(world, this.bodies);
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
    const isSpatial = moving(this.robot).length > 2;
    const least = isSpatial ? this.reach * 0.6 : 0.3;
    if (this.robot.free || world.robots.length > 1 || isSpatial) this.frameAll(least);
    this.iso = this.robot.free && isSpatial ? this.besideArm() : VIEWS.Iso;
    this.corners.fit(this.robot);
    this.floor = new THREE.GridHelper(
      Math.ceil((this.reach * 4) / 0.05) * 0.05,
      Math.ceil((this.reach * 4) / 0.05),
    );
    this.floor.rotateX(Math.PI / 2);
    this.floor.position.set(0.2, 0, this.level);
    this.floor.visible = !this.robot.free;
    this.floor.material.vertexColors = false; // All lines have the colour of the theme.
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
    this.pose(placedByTruth(this.robot, null, {}).positions);
    this.view(this.viewName);
    this.dim();
  }

  // Set the distance of the camera so that it shows all robots in their initial poses, and at least a reach
  // of `least` [m].
  frameAll(least) {
    const box = new THREE.Box3();
    this.content.updateMatrixWorld(true);
    for (const { arm } of this.bodies) box.expandByObject(arm.node);
    const size = box.getSize(new THREE.Vector3());
    this.reach = Math.max(least, size.length() * 0.75);
    box.getCenter(this.target);
  }

  // Returns one of eight views around the vertical axis: it shows the arm of a free robot from its side, with
  // its first joint in front of the base.
  besideArm() {
    const { positions, base } = placedByTruth(this.robot, null, {});
    const { links } = poses(this.robot, positions, base);
    const at = (link) => new THREE.Vector3(...place(links.get(link)));
    const first = at(moving(this.robot)[0].child),
      mount = first.clone().sub(at(this.robot.root)),
      arm = at(tipOf(this.robot)).sub(first);
    const [x, y, z] = VIEWS.Iso;
    const seen = (view) => {
      const direction = new THREE.Vector3(...view).normalize();
      return direction.dot(mount) < 0 ? -1 : direction.cross(arm).length();
    };
    const views = [x, -x].flatMap((one) =>
      [y, -y].flatMap((other) => [
        [one, other, z],
        [other, one, z],
      ]),
    );
    return views.reduce((best, view) => (seen(view) > seen(best) ? view : best));
  }

  // The simulator's truth { row, names, time } at an instant of a replay, in a flight the present one; null
  // if there is none.
  truthAt(time) {
    return store.replay ? store.replay.truthAt(time) : (this.truth?.now() ?? null);
  }

  // Joint positions, base and brakes of a robot in a row of telemetry or truth. Values that telemetry does
  // not contain are taken from the truth.
  where(robot, row, truth) {
    const { replay } = store;
    if ((replay ?? this).which !== "truth")
      return placedByTelemetry(robot, row, robot === this.robot, reportedBase(), truth);
    if (replay) return placedByTruth(robot, row, replay.names);
    const BASE = truth?.row.BASE;
    return placedByTruth(robot, BASE ? { ...row, BASE } : row, truth?.names ?? {});
  }

  tipAt(row, time) {
    // In a replay of the truth the row itself is the truth. A search for each of the 150 points of the trace
    // would take too long.
    const truth = store.replay?.which === "truth" ? null : this.truthAt(time);
    const { positions, base } = this.where(this.robot, row, truth);
    return place(poses(this.robot, positions, base).links.get(tipOf(this.robot)));
  }

  // Draw the fixtures. The floor is below the lowest face of their boxes and the lowest part of the robots in
  // their initial poses; what is below the floor, the foot of a stand or of a fixture, is cut off.
  addFixtures(shapes) {
    const bottoms = shapes
      .filter((about) => about.kind === "box")
      .map((about) => place(about.pose)[2] - about.size[2] / 2);
    this.content.updateMatrixWorld(true);
    for (const { robot, arm } of this.bodies) if (!robot.free) bottoms.push(arm.lowest());
    this.level = Math.min(0, ...bottoms);
    this.renderer.localClippingEnabled = true;
    cutBelow(this.level);
    this.fixtures = shapes.map((about) => shape(about, LOOK.ground));
    for (const mesh of this.fixtures) this.content.add(mesh);
  }

  colours() {
    if (!this.content || !this.robot) return;
    this.forceLook.color.set(token("force"));
    this.ghostLook.color.set(token("desired"));
    this.ghostEdge.color.set(token("desired"));
    this.line.material.color.set(token("measured"));
    for (const arrow of this.touches) arrow.setColor(token("force"));
    this.actuators.colours(token);
    this.floor.material.color.set(token("grid"));
    LOOK.ground.color.set(token("ground"));
    LOOK.housing.color.set(token("housing"));
    this.change();
  }

  // Show the numbers of the tip in a browser that cannot draw the scene.
  tell(row) {
    const robot = (this.robot = leadOf(store.hello.world));
    if (!robot || !row) return;
    const { positions, base } = this.where(robot, row, this.truthAt(store.time));
    this.joints = positions;
    const tip = this.tipAt(row, store.time),
      force = tipForce(robot, row, positions, base);
    this.tellTip(tip);
    text(this.values.force, force ? number(force.size, "N") : "–");
  }

  // Show an instant of a replay: the pose, and the trace of the tip before this instant.
  project({ time, row }) {
    if (!this.robot) return;
    this.veil.hidden = Boolean(row);
    text(this.veil.firstChild, "no position in the record at this instant");
    for (const [name, button] of Object.entries(this.sourceButtons)) {
      button.setAttribute("aria-pressed", String(name === store.replay.which));
      button.hidden = false;
      button.disabled = !store.replay[name]?.t.length;
      if (button.disabled) put(button, "title", `The recording has no position of the robot in the ${name}`);
    }
    this.tellTruth(store.replay.which === "truth");
    if (!row) return;
    const before = this.trace[this.trace.length - 1]?.[0] ?? -1;
    if (time < before || time > before + 0.5)
      this.trace = store.replay.before(TRACE_S).map(([t, one]) => [t, ...this.tipAt(one, t)]);
    const { positions } = this.where(this.robot, row, this.truthAt(time));
    this.before = positions;
    this.last = { time, values: row, positions, at: 0, period: 1 };
    this.shownTime = time;
    this.tellLacking();
    this.pose(positions);
  }

  // In a flight with a live port the user may let the simulator's truth move the robot; the scene then says
  // so.
  offer() {
    if (store.replay) return;
    this.sourceButtons.truth.hidden = !store.pace.is_there;
    if (!store.pace.is_there && this.which === "truth") this.mark("telemetry");
    this.watch();
  }

  // Ask for the truth while it moves the robot, or anything that telemetry does not contain. Returns whether
  // the station has refused it.
  async watch(which = this.which) {
    const isWanted = store.pace.is_there && (which === "truth" || this.lacking.length > 0);
    this.tellLacking();
    if (isWanted === Boolean(this.isWatching)) return false;
    this.isWatching = isWanted;
    return Boolean((await store.ask({ do: "watch", truth: isWanted })).refused);
  }

  async use(which) {
    if (!(await this.watch(which))) this.mark(which);
  }

  // Say which parts of the scene telemetry does not contain, and what moves them instead.
  tellLacking() {
    const { replay } = store;
    this.lacking =
      store.hello?.world?.robots.length && this.robot ? notReported(store.hello.world, this.robot) : [];
    this.supplement.hidden = !this.lacking.length || (replay ?? this).which === "truth";
    if (this.supplement.hidden) return;
    const hasTruth = replay ? Boolean(replay.truth) : store.pace.is_there;
    const words = this.lacking.join(", ");
    text(this.supplement, `${words}: ${hasTruth ? "simulator’s truth" : "not in the telemetry"}`);
    this.supplement.classList.toggle("partly", hasTruth);
  }

  mark(which) {
    if (store.replay) return;
    this.which = which;
    this.tellTruth(which === "truth");
    text(this.sourceButtons.telemetry, "Telemetry");
    for (const [name, button] of Object.entries(this.sourceButtons))
      button.setAttribute("aria-pressed", String(name === which));
    // `take` drops older messages. The new source may be slightly behind, so accept it from 1 s before the
    // last message.
    if (this.last) this.last = this.source ? { ...this.last, time: this.last.time - 1 } : null;
    this.trace = [];
    this.tellLacking();
  }

  // Cover the scene with a veil while there is no link or no new report; the force is then not drawn.
  dim() {
    if (!this.robot || store.replay) return;
    const isStale =
      Boolean(this.last) &&
      store.clock() - this.last.seen > STALE_PERIODS * Math.max(STALE_MS, this.last.period);
    this.veil.hidden = store.link.is_live && !isStale;
    const why = store.link.is_live ? `${this.source} reports no position` : store.link.text;
    text(this.veil.firstChild, `${why}; last seen ${(this.last?.time ?? store.time).toFixed(3)} s`);
    if (isStale === this.isStale) return;
    this.isStale = isStale;
    if (!this.drawn) return;
    this.pose(this.drawn);
    this.tellPose();
    this.change();
  }

  take(message) {
    if (message.subsystem !== this.source || !message.values["CUR_VALUES.POSITION"] || !this.robot) return;
    // Drop a report that is older than the last one; a time that is far behind is that of a new flight.
    if (this.last && message.time < this.last.time && message.time > this.last.time - 60) return;
    // Reports of different intervals would make the movement uneven.
    if (store.isSlower(this.source, message.structure, this.last?.structure)) return;
    const period = this.last
      ? Math.min(0.3, Math.max(0.01, message.time - this.last.time)) / (store.pace.speed || 1)
      : 0.05;
    this.before = this.drawn ?? [];
    this.last = {
      time: message.time,
      values: message.values,
      structure: message.structure,
      positions: this.where(this.robot, message.values, this.truth.last).positions,
      at: performance.now(),
      seen: store.clock(),
      period: Math.min(300, period * 1000),
    };
    this.remember(message.time, this.tipAt(message.values, message.time));
    const span = message.time - this.trace[0][0];
    const rate = span > 0.3 ? ` ${Math.round((this.trace.length - 1) / span)} Hz` : "";
    const isTruth = this.which === "truth";
    text(isTruth ? this.truthMark : this.sourceButtons.telemetry, `${isTruth ? TRUTH : "Telemetry"}${rate}`);
    if (!isTruth) this.tellSlow();
  }

  // Within a period, move the robot from its positions in the report before the last one to those in the last
  // report. A picture without a graphics processor is visible later, so it shows the positions of a later
  // time: those of the last report, if there is no time for another picture before the next report.
  move() {
    if (!this.last) {
      if (this.truth.isNew) this.pose(this.drawn);
      if (this.truth.isNew) this.pictures?.wake();
      return;
    }
    const { at, period } = this.last;
    const passed = performance.now() - at + (this.pictures ? LEAST_MS : 0);
    const share = this.pictures && period < 2 * LEAST_MS ? 1 : Math.min(1, passed / period);
    const now = this.last.positions.map(
      (value, n) => (this.before[n] ?? value) + (value - (this.before[n] ?? value)) * share,
    );
    if (
      !this.drawn ||
      now.some((value, n) => Math.abs(value - this.drawn[n]) > 1e-5) ||
      this.shownTime !== this.last.time ||
      this.truth.isNew
    ) {
      this.pose(now);
      this.shownTime = this.last.time;
    }
    if (share < 1 || this.truth.isNew) this.pictures?.wake();
  }

  // Draw the scene if it has changed; true if it was drawn. scale: share of the pixels of each axis, without
  // a graphics processor; isForced: draw it even if it has not changed.
  frame(scale, isForced = false) {
    if (this.robot) this.move();
    if (!this.isChanged && !isForced) {
      this.tellPose();
      return false;
    }
    this.isChanged = false;
    if (scale && scale !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(scale);
    this.camera.lookAt(this.target);
    this.camera.updateMatrixWorld();
    this.renderer.render(this.world, this.camera);
    if (!this.pictures) this.labels();
    return true;
  }

  pose(positions) {
    this.drawn = this.joints = positions;
    const values = this.last?.values ?? {},
      truth = this.truthAt(store.time);
    let hasBrakes = false;
    for (const { robot, arm } of this.bodies) {
      const found = this.where(robot, values, truth);
      arm.set(robot === this.robot ? positions : found.positions, found.base);
      arm.showBrakes(found.brakes);
      hasBrakes ||= Boolean(found.brakes?.some((brake) => brake !== null));
      if (robot === this.robot) this.follow(found.base);
    }
    this.corners.rings.hidden = !hasBrakes;
    this.actuators.show(truth, token);
    const tip = place(poses(this.robot, positions, this.base).links.get(tipOf(this.robot)));
    this.tip = tip;
    this.drawForce(values, tip);
    this.drawTouches(values);
    this.drawGhost(values);
    this.drawLimits(positions);
    this.drawSprings(tip);
    this.drawTrace(tip);
    this.compare(this.look(values, truth));
  }

  // Move the camera with a robot that flies freely.
  follow(base) {
    if (this.robot.free && this.base) {
      const moved = new THREE.Vector3(...place(base)).sub(new THREE.Vector3(...place(this.base)));
      this.camera.position.add(moved);
      this.target.add(moved);
    }
    this.base = base;
  }

  resize() {
    const width = this.clientWidth,
      height = this.clientHeight;
    if (!width || !height) return;
    this.extent = { width, height };
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.zoom = Math.min(1, this.camera.aspect / LEAST_ASPECT);
    this.camera.updateProjectionMatrix();
    this.change();
  }
}
customElements.define("station-scene", Scene);
