// SPDX-License-Identifier: Apache-2.0
// Reaction wheels and thrusters on the bodies of the scene. A wheel turns with its share of the largest
// momentum, because the real speed cannot be seen; a thruster has a plume while its valve is open.

import * as THREE from "three";

import { LOOK, shape } from "./body.js";

const TURNS_PER_S = 0.5; // Rotation that is drawn for a wheel at its largest momentum.
const NEAR = 0.9,
  FULL = 0.99; // Shares of the largest momentum.
const LONGEST_S = 0.5; // A longer step of time is a jump of a replay [s].
const UP = new THREE.Vector3(0, 1, 0);

// Box around the shapes of a link, in its frame.
function extent(robot, link, otherwise) {
  const group = new THREE.Group();
  const shapes = (robot.visuals?.[link] ?? robot.links[link] ?? []).filter((about) => !about.stl);
  for (const about of shapes) group.add(shape(about, LOOK.metal));
  const box = new THREE.Box3().setFromObject(group);
  if (!box.isEmpty()) return box;
  return new THREE.Box3().setFromCenterAndSize(
    new THREE.Vector3(),
    new THREE.Vector3(1, 1, 1).multiplyScalar(otherwise),
  );
}

const directed = (group, direction) =>
  group.quaternion.setFromUnitVectors(UP, new THREE.Vector3(...direction).normalize());

function wheelMesh(radius) {
  const group = new THREE.Group();
  const turning = new THREE.Group();
  turning.add(new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, radius * 0.35, 40), LOOK.metal));
  const spoke = new THREE.MeshBasicMaterial({ color: 0x20262d });
  for (let n = 0; n < 3; n++) {
    const bar = new THREE.Mesh(new THREE.BoxGeometry(radius * 0.95, radius * 0.06, radius * 0.16), spoke);
    bar.position.set(radius * 0.475, radius * 0.19, 0);
    const arm = new THREE.Group();
    arm.rotation.y = (n * 2 * Math.PI) / 3;
    arm.add(bar);
    turning.add(arm);
  }
  const look = new THREE.MeshBasicMaterial();
  const rim = new THREE.Mesh(
    new THREE.TorusGeometry(radius * 1.04, radius * 0.05, 8, 48).rotateX(Math.PI / 2),
    look,
  );
  group.add(turning, rim);
  return { group, turning, look };
}

function thrusterMesh(size, plumeLook) {
  const group = new THREE.Group();
  const nozzle = new THREE.Mesh(
    new THREE.CylinderGeometry(size * 0.5, size * 0.18, size, 24, 1).translate(0, size * 0.5, 0),
    LOOK.cap,
  );
  // ConeGeometry has its tip along +y: the wide end is at the mouth of the nozzle.
  const plume = new THREE.Mesh(
    new THREE.ConeGeometry(size * 0.48, size * 3.2, 24, 1, true).translate(0, size * 2.6, 0),
    plumeLook,
  );
  plume.visible = false;
  group.add(nozzle, plume);
  return { group, plume };
}

export class Actuators {
  // bodies: { robot, arm } of the scene; arm.frames are the groups of its links.
  constructor(world, bodies) {
    this.wheels = [];
    this.thrusters = [];
    this.time = null;
    this.plumeLook = new THREE.MeshBasicMaterial({
      transparent: true,
      opacity: 0.6,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    const place = ({ on }) => {
      const at = on.indexOf(".");
      const body = bodies.find(({ robot }) => robot.name === on.slice(0, at));
      const link = on.slice(at + 1);
      return { frame: body?.arm.frames.get(link), box: body && extent(body.robot, link, body.arm.size) };
    };
    const stacked = new Map();
    for (const about of world.wheels ?? []) this.addWheel(about, place(about), stacked);
    for (const about of world.valves ?? []) this.addThruster(about, place(about));
  }

  // A wheel is drawn outside of its link, on the side to which its axis points; wheels with the same axis
  // are drawn side by side along it.
  addWheel(about, { frame, box }, stacked) {
    if (!frame) return;
    const axis = new THREE.Vector3(...about.axis).normalize();
    const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    const radius = 0.3 * ((half.x + half.y + half.z) / 3);
    const reach = Math.abs(axis.x) * half.x + Math.abs(axis.y) * half.y + Math.abs(axis.z) * half.z;
    const key = `${about.on} ${axis.toArray().map((one) => one.toFixed(3))}`;
    const before = stacked.get(key) ?? 0;
    stacked.set(key, before + 1);
    const mesh = wheelMesh(radius);
    directed(mesh.group, axis.toArray());
    mesh.group.userData.device = about.name;
    mesh.group.position
      .copy(box.getCenter(new THREE.Vector3()))
      .addScaledVector(axis, reach + radius * (0.25 + 0.5 * before));
    frame.add(mesh.group);
    this.wheels.push({ ...about, ...mesh, angle: 0, share: 0 });
  }

  // The nozzle points against the force.
  addThruster(about, { frame, box }) {
    if (!frame) return;
    const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    const mesh = thrusterMesh(0.16 * ((half.x + half.y + half.z) / 3), this.plumeLook);
    directed(
      mesh.group,
      about.direction.map((one) => -one),
    );
    mesh.group.position.set(...about.at);
    mesh.group.userData.device = about.device;
    frame.add(mesh.group);
    this.thrusters.push({ ...about, ...mesh, isOpen: false });
  }

  colours(token) {
    this.plumeLook.color.set(token("force"));
    for (const wheel of this.wheels) {
      const share = Math.abs(wheel.share);
      wheel.look.color.set(token(share >= FULL ? "critical" : share > NEAR ? "caution" : "fg2"));
    }
  }

  // Show a row { row, names, time } of the truth. Without a truth wheels stand still, and no thruster fires.
  show(truth, token) {
    const of = (leaf, names, name) => truth?.row?.[leaf]?.[truth.names[names]?.indexOf(name) ?? -1] ?? 0;
    const step = truth && this.time !== null ? truth.time - this.time : 0;
    this.time = truth?.time ?? null;
    for (const wheel of this.wheels) {
      wheel.share = of("WHEEL", "wheels", wheel.name) / wheel.momentum;
      if (Math.abs(step) < LONGEST_S) wheel.angle += 2 * Math.PI * TURNS_PER_S * wheel.share * step;
      wheel.turning.rotation.y = wheel.angle;
    }
    for (const thruster of this.thrusters) {
      thruster.isOpen = of("VALVE", "valves", thruster.name) > 0.5;
      thruster.plume.visible = thruster.isOpen;
    }
    if (this.wheels.length) this.colours(token);
  }

  // Present state of the actuators in words; empty if the world has none.
  words() {
    const firing = this.thrusters.filter(({ isOpen }) => isOpen).map(({ name }) => name);
    const wheels = this.wheels.map(({ name, share }) => `${name} ${(share * 100).toFixed(0)} %`);
    return [
      wheels.length ? `momentum of wheels ${wheels.join(", ")}` : "",
      this.thrusters.length
        ? firing.length
          ? `thrusters ${firing.join(", ")} fire`
          : "no thruster fires"
        : "",
    ]
      .filter(Boolean)
      .join("; ");
  }
}
