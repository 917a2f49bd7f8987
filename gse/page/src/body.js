// SPDX-License-Identifier: Apache-2.0
// Meshes of the robots in the scene and of the shapes of its world.

import * as THREE from "three";

import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";

import { moving, place } from "./kinematics.js";

// Share of the facets of spheres, springs and other shapes with many that are drawn. Without a graphics
// processor it is smaller, because the triangles take most of the time of a picture.
export const FACETS = { share: 1 };
export const facets = (count) => Math.max(3, Math.round(count * FACETS.share));

const matrix = (pose) => new THREE.Matrix4().set(...pose);

function material(colour, roughness, metalness = 0) {
  return new THREE.MeshStandardMaterial({ color: colour, roughness, metalness });
}

// Parts that stand on the floor are cut off below it.
export function cutBelow(level) {
  LOOK.ground.clippingPlanes = LOOK.stand.clippingPlanes = [
    new THREE.Plane(new THREE.Vector3(0, 0, 1), -level),
  ];
}

export const LOOK = {
  shell: material(0xe8e6e0, 0.42),
  housing: material(0x3a4149, 0.6),
  cap: material(0x8a929b, 0.35, 0.7),
  stand: material(0x59636d, 0.8),
  ground: material(0x6f7d8a, 0.85),
  metal: material(0xc4cad0, 0.25, 0.85),
};

// Mesh of a cylinder between two points.
function rod(from, to, wide, narrow, look) {
  const a = new THREE.Vector3(...from),
    b = new THREE.Vector3(...to);
  const along = b.clone().sub(a);
  const mesh = new THREE.Mesh(new THREE.CylinderGeometry(narrow, wide, along.length(), 28), look);
  mesh.position.copy(a).addScaledVector(along, 0.5);
  mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.clone().normalize());
  return mesh;
}

export function shape(about, look) {
  let geometry;
  if (about.kind === "box") geometry = new THREE.BoxGeometry(...about.size);
  else if (about.kind === "cylinder")
    geometry = new THREE.CylinderGeometry(about.radius, about.radius, about.length, facets(96)).rotateX(
      Math.PI / 2,
    );
  else geometry = new THREE.SphereGeometry(about.radius, facets(32), facets(20));
  const mesh = new THREE.Mesh(geometry, look);
  mesh.applyMatrix4(matrix(about.pose));
  return mesh;
}

// Mesh of a <visual> of the URDF: a shape or the triangles of an STL file. `looks` without `stand` are those
// of the ghost, the desired position, which is drawn without colours.
function visual(about, looks) {
  const isGhost = !looks.stand;
  const look =
    about.colour && !isGhost
      ? material(new THREE.Color().setRGB(...about.colour, THREE.SRGBColorSpace), 0.5)
      : looks.shell;
  if (!about.stl) return shape(about, look);
  const octets = Uint8Array.from(atob(about.stl), (letter) => letter.charCodeAt(0));
  const geometry = new STLLoader().parse(octets.buffer);
  geometry.computeVertexNormals(); // Many programs write facets without normals.
  const mesh = new THREE.Mesh(geometry, look);
  mesh.applyMatrix4(matrix(about.pose).scale(new THREE.Vector3(...about.scale)));
  return mesh;
}

// A robot as nested groups; `set` moves its joints. A robot whose URDF has visuals is drawn by them, and a
// link without any by its collision shapes. For other robots, shells follow the links, and a housing
// surrounds each joint.
export class Arm {
  constructor(robot, looks) {
    this.robot = robot;
    this.groups = new Map();
    this.brakes = []; // One for each moving joint, in the order of the joints.
    this.node = new THREE.Group();
    const size = Math.max(0.2, ...robot.joints.map((joint) => Math.hypot(...place(joint.pose))));
    this.size = size;
    const frames = (this.frames = new Map([[robot.root, this.node]])); // Group of each link.
    const wide = size * 0.16;
    const visuals = robot.visuals ?? {};
    const isDrawn = Object.keys(visuals).length > 0;
    for (let round = 0; round < robot.joints.length; round++)
      for (const joint of robot.joints) {
        if (!frames.has(joint.parent) || frames.has(joint.child)) continue;
        const still = new THREE.Group();
        still.applyMatrix4(matrix(joint.pose));
        if (joint.kind !== "fixed") still.userData.joint = `${robot.name}.${joint.name}`;
        const turning = new THREE.Group();
        turning.matrixAutoUpdate = true;
        still.add(turning);
        frames.get(joint.parent).add(still);
        frames.set(joint.child, turning);
        if (joint.kind !== "fixed") this.groups.set(joint.name, { joint, still, turning });
        if (!isDrawn) {
          const names = Object.keys(robot.links);
          const isLast = joint.kind === "fixed" && names.indexOf(joint.child) === names.length - 1;
          this.shell(frames.get(joint.parent), joint, wide, looks, isLast);
          if (joint.kind !== "fixed" && looks.housing) this.housing(turning, joint, wide, looks);
        }
        if (joint.kind !== "fixed" && looks.stand) this.brake(still, joint, wide);
      }
    this.node.matrixAutoUpdate = false;
    for (const [name, shapes] of Object.entries(robot.links))
      if (visuals[name]) for (const about of visuals[name]) frames.get(name)?.add(visual(about, looks));
      else for (const about of shapes) frames.get(name)?.add(shape(about, looks.metal));
    if (looks.stand && !robot.free && !isDrawn) this.stand(robot, wide, looks);
  }

  // Two rings around a housing, which are shown while the brake holds.
  brake(still, joint, wide) {
    const look = new THREE.MeshBasicMaterial({ color: 0xffffff });
    const rings = [-1, 1].map((side) => {
      const ring = new THREE.Mesh(
        new THREE.TorusGeometry(wide * 1.36, wide * 0.12, facets(8), facets(36)),
        look,
      );
      ring.quaternion.setFromUnitVectors(
        new THREE.Vector3(0, 0, 1),
        new THREE.Vector3(...joint.axis).normalize(),
      );
      ring.position.set(...joint.axis).multiplyScalar(side * wide * 1.1);
      ring.visible = false;
      still.add(ring);
      return ring;
    });
    this.brakes.push({ rings, isHeld: null });
  }

  showBrakes(brakes) {
    this.brakes.forEach((brake, n) => {
      const isHeld = brakes ? brakes[n] : null;
      if (isHeld === brake.isHeld) return;
      brake.isHeld = isHeld;
      for (const ring of brake.rings) ring.visible = Boolean(isHeld);
    });
  }

  shell(parent, joint, wide, looks, isLast) {
    const at = place(joint.pose),
      length = Math.hypot(...at);
    if (length < 0.02 || joint.parent === this.robot.root) return;
    const direction = at.map((value) => value / length);
    const point = (d) => direction.map((value) => value * d);
    const end = isLast ? length * 0.84 : length;
    parent.add(rod(point(0), point(end), wide * 0.95, wide * (isLast ? 0.62 : 0.8), looks.shell));
    if (isLast) {
      const nose = new THREE.Mesh(new THREE.SphereGeometry(wide * 0.62, facets(28), facets(16)), looks.shell);
      nose.position.set(...point(end));
      parent.add(nose, rod(point(end), point(length), wide * 0.25, wide * 0.2, looks.metal));
    }
  }

  housing(turning, joint, wide, looks) {
    const axis = joint.axis,
      out = wide * 1.35;
    const at = (d) => axis.map((value) => value * d);
    turning.add(
      rod(at(-out), at(out), wide * 1.28, wide * 1.28, looks.housing),
      rod(at(-out * 1.04), at(out * 1.04), wide * 0.78, wide * 0.78, looks.cap),
      rod(at(-out * 1.06), at(out * 1.06), wide * 0.42, wide * 0.42, looks.housing),
    );
  }

  stand(robot, wide, looks) {
    const first = moving(robot)[0];
    if (!first) return;
    const base = place(first.pose);
    const block = new THREE.Mesh(
      new THREE.CylinderGeometry(wide * 2, wide * 2.7, wide * 4.2, 4, 1)
        .rotateY(Math.PI / 4)
        .rotateX(Math.PI / 2),
      looks.stand,
    );
    block.position.set(base[0], base[1], base[2] - wide * 2.4);
    this.node.add(block);
  }

  // Height of the lowest point of the robot without its stand.
  lowest() {
    const box = new THREE.Box3();
    this.node.traverse((mesh) => {
      if (mesh.isMesh && mesh.material !== LOOK.stand) box.union(new THREE.Box3().setFromObject(mesh, true));
    });
    return box.isEmpty() ? 0 : box.min.z;
  }

  set(positions, base) {
    this.node.matrix.copy(matrix(base));
    this.node.matrixWorldNeedsUpdate = true;
    moving(this.robot).forEach((joint, n) => {
      const { turning } = this.groups.get(joint.name);
      const axis = new THREE.Vector3(...joint.axis);
      if (joint.kind === "prismatic") turning.position.copy(axis).multiplyScalar(positions[n] ?? 0);
      else turning.quaternion.setFromAxisAngle(axis, positions[n] ?? 0);
    });
  }
}
