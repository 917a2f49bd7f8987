// SPDX-License-Identifier: Apache-2.0
// Marks in the scene: the force at the tip, contact forces, the desired position, ranges of the joints,
// springs, and their labels. The class Scene extends this class and supplies the robot and its values.

import * as THREE from "three";

import { Arm, facets } from "./body.js";
import { store } from "./store.js";
import { number, put, text } from "./dom.js";
import { moving, place, poses, tipForce, tipOf } from "./kinematics.js";

const FORCE_SCALE = 0.0024; // Length of an arrow for each newton [m/N].
const FORCE_LEAST = 0.5; // Smallest force that is drawn [N].
// The desired position is drawn where it differs from the measured one by more than this.
const GHOST_M = 0.002,
  GHOST_RAD = (0.5 * Math.PI) / 180;
const NEAR = 0.1; // Share of the range that counts as near a limit.
export const TRUTH = "Simulator’s truth";
export const TRACE_S = 6; // Length of the trace of the tip.
const LOOK_LEAST = 1e-4; // Smallest difference that is drawn [m, rad].
const GAP_S = 1; // Time without reports that interrupts the trace.
const tokens = new Map(); // Name -> colour in the present theme; reading a style would cause a layout.
store.on("theme", () => tokens.clear());
export function token(name) {
  const known = tokens.get(name);
  if (known) return known;
  const colour = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  tokens.set(name, colour);
  return colour;
}

function coil(from, to, turns = 13, radius = 0.011) {
  const points = [],
    count = turns * facets(12);
  for (let n = 0; n <= count; n++) {
    const share = n / count,
      angle = share * turns * 2 * Math.PI;
    points.push(
      new THREE.Vector3(
        from[0] + (to[0] - from[0]) * share + radius * Math.cos(angle),
        from[1] + radius * Math.sin(angle),
        from[2] + (to[2] - from[2]) * share,
      ),
    );
  }
  return new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), count, 0.0018, facets(5));
}

export class SceneMarks extends HTMLElement {
  tellTip(tip) {
    for (const [n, name] of ["x", "y", "z"].entries()) text(this.values[name], number(tip[n] * 1000, "mm"));
  }

  describe() {
    if (!this.tip) return;
    const [x, y, z] = this.tip.map((value) => `${(value * 1000).toFixed(0)} mm`);
    const { isArm, isPlanar } = this.corners;
    const at = `at x ${x}${isPlanar ? "" : `, y ${y}`}, z ${z}`;
    const robot = isArm ? `The robot: tip ${at}, force ${this.force.toFixed(1)} N` : `The body ${at}`;
    put(this.canvas, "aria-label", [robot, this.actuators.words()].filter(Boolean).join("; "));
  }

  // Mark the scene while the truth moves the robot.
  tellTruth(is) {
    this.classList.toggle("truth", is);
    this.truthMark.hidden = !is;
    if (!is) text(this.truthMark, TRUTH);
  }

  // Say that no structure of the configuration reports the robot fast enough for the picture.
  tellSlow() {
    const isSlow = Boolean(store.configuration(this.source)) && !store.display(this.source);
    this.truthMark.hidden = !isSlow;
    if (isSlow) text(this.truthMark, "no display structure");
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

  // Draw the range of each limited revolute joint as an arc with a pointer at its present position. The ends
  // of an arc of a full turn would coincide, so a range of 6 rad or more is not drawn.
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

  // Draw the force of each contact and each spring of the truth at its point of application.
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
    this.isForceKnown = Boolean(found);
    const isShown = (this.shaft.visible = this.point.visible = this.force >= FORCE_LEAST);
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
    this.forceEnd = this.point.position.clone().addScaledVector(direction, 0.02);
  }

  // Draw the desired position where it differs visibly. Both positions are from the same report, because the
  // drawn position lags by one period.
  drawGhost(values) {
    const desired = values["DES_POSITION"] ?? values["CUR_VALUES.DESIRED"],
      positions = this.last?.positions;
    this.ghost.node.visible = false;
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

  // Telemetry does not report whether the spring is hooked to the tip. It is drawn hooked if the tip is close
  // to the hook, above it, and the force pulls it down.
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

  // What the scene shows, as numbers: angles in rad, lengths in m. A trace that grows or fades has another
  // oldest point.
  look(values, truth) {
    const bodies = this.bodies.flatMap(({ arm }) => [
      ...arm.node.matrix.elements,
      ...[...arm.groups.values()].flatMap(({ turning }) => [
        ...turning.position,
        ...turning.quaternion.toArray(),
      ]),
      ...arm.brakes.map(({ isHeld }) => (isHeld === null ? 2 : Number(isHeld))),
    ]);
    const force = this.shaft.visible ? this.forceVector : [];
    const touches = [...(values.CONTACTS ?? []), ...(values.SPRING ?? [])];
    const ghost = this.ghost.node.visible ? this.ghostEnd.toArray() : [];
    const drives = store.hello.world.wheels?.length || store.hello.world.valves?.length;
    return [
      ...bodies,
      ...(this.trace[0]?.slice(1) ?? []),
      ...[...force, ...touches].map((value) => value * FORCE_SCALE),
      ...ghost,
      drives && truth ? truth.time : 0,
      [...this.springs.map(({ shown }) => shown), force.length, touches.length, ghost.length].join(),
    ];
  }

  // Note whether the scene differs from that of the last picture; noise of the telemetry is no difference.
  compare(look) {
    const isSame = look.every((value, n) => {
      const before = this.looked?.[n];
      return value === before || Math.abs(value - before) < LOOK_LEAST;
    });
    if (isSame && !store.replay) return;
    this.looked = look;
    this.isChanged = true;
  }

  // Write the numbers of the pose. Without a graphics processor this waits for the picture: the browser then
  // computes the layout once for both.
  tellPose() {
    if (!this.drawn) return;
    this.tellTip(this.tip);
    text(this.values.force, this.isForceKnown ? number(this.force, "N") : "–");
    text(this.forceLabel, `${this.force.toFixed(1)} N`);
    this.forceLabel.hidden = !this.shaft.visible;
    this.ghostLabel.hidden = !this.ghost.node.visible;
  }

  labels() {
    this.tellPose();
    const { width, height } = this.extent;
    const put = (label, point, below = 0) => {
      if (label.hidden || !point) return;
      const flat = point.clone().project(this.camera);
      const x = ((flat.x + 1) / 2) * width + 10,
        y = ((1 - flat.y) / 2) * height - 11 + below;
      const within = (value, end) => `${Math.max(0, Math.min(end, value)).toFixed(0)}px`;
      const left = within(x, width - 110);
      label.style.transform = `translate(${left}, ${within(y, height - 24)})`;
    };
    put(this.forceLabel, this.forceEnd);
    put(this.ghostLabel, this.ghostEnd, 24);
  }

  // Add a place to the trace of a flight, also while the page is in the background and draws no pictures. The
  // trace begins anew after a gap in the reports.
  remember(time, tip) {
    const before = this.trace[this.trace.length - 1]?.[0] ?? time;
    if (!store.replay && time - before > GAP_S) this.trace = [];
    this.trace.push([time, ...tip]);
    while (this.trace.length > 2 && this.trace[0][0] < time - TRACE_S) this.trace.shift();
  }

  // In a flight the robot is drawn one period behind the last report, whose position is therefore left out.
  drawTrace(tip) {
    if (store.replay) this.remember(store.time, tip);
    const points = store.replay ? this.trace : [...this.trace.slice(0, -1), [store.time, ...tip]];
    this.line.geometry.dispose();
    this.line.geometry = new THREE.BufferGeometry().setFromPoints(
      points.map(([, ...point]) => new THREE.Vector3(...point)),
    );
  }
}
