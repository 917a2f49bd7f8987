// SPDX-License-Identifier: Apache-2.0
// Forward kinematics of a robot, and the force at its tip, which is computed from the external torques of its
// joints.

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export function multiply(a, b) {
  const found = new Array(16);
  for (let row = 0; row < 4; row++)
    for (let column = 0; column < 4; column++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * row + k] * b[4 * k + column];
      found[4 * row + column] = sum;
    }
  return found;
}

export function motion(joint, value) {
  const [x, y, z] = joint.axis;
  if (joint.kind === "fixed") return IDENTITY;
  if (joint.kind === "prismatic")
    return [1, 0, 0, x * value, 0, 1, 0, y * value, 0, 0, 1, z * value, 0, 0, 0, 1];
  const c = Math.cos(value),
    s = Math.sin(value),
    k = 1 - c;
  return [
    c + x * x * k,
    x * y * k - z * s,
    x * z * k + y * s,
    0,
    y * x * k + z * s,
    c + y * y * k,
    y * z * k - x * s,
    0,
    z * x * k - y * s,
    z * y * k + x * s,
    c + z * z * k,
    0,
    0,
    0,
    0,
    1,
  ];
}

export const moving = (robot) => robot.joints.filter((joint) => joint.kind !== "fixed");

// Numbers of the moving joints of a robot in groups of at most `most` joints of one kind, revolute or
// prismatic.
export function groups(robot, most) {
  const found = [];
  for (const [n, joint] of moving(robot).entries()) {
    const isPrismatic = joint.kind === "prismatic";
    let group = found.find((one) => one.isPrismatic === isPrismatic && one.joints.length < most);
    if (!group) found.push((group = { isPrismatic, joints: [] }));
    group.joints.push(n);
  }
  return found;
}

// The robot that the subsystems of a flight move: the first with a drive, otherwise the first.
export function leadOf(world) {
  const driven = Object.values(world?.drives ?? {});
  return (
    world?.robots.find((robot) => driven.some((joint) => joint.startsWith(`${robot.name}.`))) ??
    world?.robots[0]
  );
}

// The moving joints of the robot that one of these devices drives; none if there is no such robot.
export function jointsOf(world, devices) {
  const driven = devices.map((device) => world?.drives[device]).find(Boolean);
  const robot = world?.robots.find(({ name }) => driven?.startsWith(`${name}.`));
  return robot ? moving(robot) : [];
}

const SLIDING = { rad: "m", "rad/s": "m/s", Nm: "N" }; // Unit of a revolute joint -> unit of a prismatic one.

// Unit of number `n` of a list. In a list with a number for each joint, a unit like "rad or m" is the first
// one for a revolute joint, and the second one for a prismatic joint. Other pairs, such as "rad or Nm" of a
// command whose meaning depends on the mode of the drive, remain.
export function unitAt({ unit, count }, n, joints) {
  const [turning, sliding] = unit.split(" or ");
  if (!sliding || SLIDING[turning] !== sliding || count !== joints.length) return unit;
  return joints[n].kind === "prismatic" ? sliding : turning;
}

// Pose of a body (4 x 4, row by row) from its position x, y, z and its attitude, the quaternion w, x, y, z.
export function poseOf([px, py, pz, w, x, y, z]) {
  return [
    1 - 2 * (y * y + z * z),
    2 * (x * y - w * z),
    2 * (x * z + w * y),
    px,
    2 * (x * y + w * z),
    1 - 2 * (x * x + z * z),
    2 * (y * z - w * x),
    py,
    2 * (x * z - w * y),
    2 * (y * z + w * x),
    1 - 2 * (x * x + y * y),
    pz,
    0,
    0,
    0,
    1,
  ];
}

// Poses between those of two reports, which contain positions and attitudes as above, one body after the
// other. `share`: share of the time between the reports that has passed. An attitude turns by the shorter
// way: q and -q are the same attitude.
export function posesBetween(from, to, share) {
  const found = [];
  for (let n = 0; n + 7 <= to.length; n += 7) {
    const a = from.slice(n, n + 7),
      b = to.slice(n, n + 7);
    const isOpposite = a.slice(3).reduce((sum, value, k) => sum + value * b[3 + k], 0) < 0;
    const mean = b.map((value, k) => a[k] + ((k > 2 && isOpposite ? -value : value) - a[k]) * share);
    const length = Math.hypot(...mean.slice(3));
    found.push(...mean.map((value, k) => (k > 2 ? value / length : value)));
  }
  return found;
}

// Whether a drive of CiA 402 controls its motor, which releases its holding brake: operation enabled, quick
// stop active or fault reaction active.
export const controlsMotor = (statusword) =>
  (statusword & 0x6f) === 0x27 || (statusword & 0x6f) === 0x07 || (statusword & 0x4f) === 0x0f;

// Configuration of a robot in a row of the truth, which contains all robots, in the order of `names`:
// positions of its moving joints, pose of its root, and for each joint whether its brake holds (null:
// unknown).
export function placedByTruth(robot, row, names) {
  const joints = moving(robot);
  const pick = (values, wanted, known, width = 1) => {
    const at = known?.indexOf(wanted) ?? -1;
    return values && at >= 0 ? values.slice(width * at, width * at + width) : null;
  };
  const each = (values, n) => pick(values, `${robot.name}.${joints[n].name}`, names.joints)?.[0];
  const base = pick(row?.BASE, robot.name, names.bases, 7);
  return {
    positions: joints.map(
      (joint, n) => each(row?.["CUR_VALUES.POSITION"], n) ?? robot.start[joint.name] ?? 0,
    ),
    base: base ? poseOf(base) : (robot.at ?? IDENTITY),
    brakes: row?.BRAKE ? joints.map((_, n) => (each(row.BRAKE, n) ?? 0) > 0.5) : null,
  };
}

// Configuration of a robot in a row of telemetry. The row contains only the joints of the lead robot, which
// the subsystem moves. `base` is the pose of its base that telemetry reports, x, y, z and w, x, y, z. Values
// that telemetry does not contain are taken from the truth, or from the start if there is no truth. `truth`
// has the members row and names, or is null.
export function placedByTelemetry(robot, row, isLead, base, truth) {
  const known = placedByTruth(robot, truth?.row, truth?.names ?? {});
  if (!isLead) return { ...known, brakes: null };
  const words = row?.["CUR_VALUES.STATUSWORD"];
  const isBraked = (joint) => robot.braked?.includes(joint.name);
  return {
    positions: row?.["CUR_VALUES.POSITION"] ?? known.positions,
    base: base ? poseOf(base) : known.base,
    brakes:
      words?.length >= moving(robot).length
        ? moving(robot).map((joint, n) => (isBraked(joint) ? !controlsMotor(words[n]) : null))
        : null,
  };
}

// Pose of each link, and of the fixed part of each joint, by name.
export function poses(robot, positions, base = robot.at ?? IDENTITY) {
  const values = new Map(moving(robot).map((joint, n) => [joint.name, positions[n] ?? 0]));
  const links = new Map([[robot.root, base]]);
  const joints = new Map();
  for (let round = 0; round < robot.joints.length; round++)
    for (const joint of robot.joints) {
      if (!links.has(joint.parent) || links.has(joint.child)) continue;
      const at = multiply(links.get(joint.parent), joint.pose);
      joints.set(joint.name, at);
      links.set(joint.child, multiply(at, motion(joint, values.get(joint.name) ?? 0)));
    }
  return { links, joints };
}

export const place = (pose) => [pose[3], pose[7], pose[11]];

export function tipOf(robot) {
  const parents = new Set(robot.joints.map((joint) => joint.parent));
  return (
    Object.keys(robot.links)
      .filter((name) => !parents.has(name))
      .pop() ?? robot.root
  );
}

const turned = (pose, vector) =>
  vector && [0, 1, 2].map((row) => vector.reduce((sum, value, k) => sum + pose[4 * row + k] * value, 0));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// Jacobian of the position of the tip: one column for each moving joint.
function jacobian(robot, found, tip) {
  return moving(robot).map((joint) => {
    const pose = found.joints.get(joint.name);
    const [x, y, z] = joint.axis;
    const axis = [0, 1, 2].map((row) => pose[4 * row] * x + pose[4 * row + 1] * y + pose[4 * row + 2] * z);
    return joint.kind === "prismatic"
      ? axis
      : cross(
          axis,
          tip.map((value, n) => value - place(pose)[n]),
        );
  });
}

// Force at the tip. If the row contains a force, of the truth or reported by the subsystem in the axes of the
// base, it is this force. Otherwise it is the least-squares solution of J^T F = torque with a small damping,
// which gives the smallest force where the torques do not determine a direction.
export function tipForce(robot, row, positions = row["CUR_VALUES.POSITION"], base = undefined) {
  const torque = row["CUR_VALUES.EXTERNAL_TORQUE"];
  if (!robot || !positions) return null;
  const found = poses(robot, positions, base);
  const tip = place(found.links.get(tipOf(robot)));
  const known = row.FORCE ?? turned(found.links.get(robot.root), row["CUR_VALUES.TOOL_FORCE"]);
  if (known) return { force: known, at: tip, size: Math.hypot(...known) };
  if (!torque) return null;
  const columns = jacobian(robot, found, tip);
  const matrix = [0, 1, 2].map((i) =>
    [0, 1, 2].map((j) => columns.reduce((sum, column) => sum + column[i] * column[j], i === j ? 1e-6 : 0)),
  );
  const right = [0, 1, 2].map((i) =>
    columns.reduce((sum, column, n) => sum + column[i] * (torque[n] ?? 0), 0),
  );
  const determinant = dot(matrix[0], cross(matrix[1], matrix[2]));
  const solve = (n) => {
    const changed = matrix.map((line, i) => line.map((value, j) => (j === n ? right[i] : value)));
    return dot(changed[0], cross(changed[1], changed[2])) / determinant;
  };
  const force = [solve(0), solve(1), solve(2)];
  return { force, at: tip, size: Math.hypot(...force) };
}
