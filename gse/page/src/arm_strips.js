// SPDX-License-Identifier: Apache-2.0
// The strip charts of a robot: positions and torques of its joints, and the force at its tip. No strip has
// more than four lines.

import { groups, moving } from "./kinematics.js";

export const LINES_MAX = 4;
export const COLOURS = ["measured", "second", "force", "fg1"]; // Colours of the lines of a strip.
const COLUMN_MAX = 3; // Strips of one column.

// Number of columns for a number of strips: two if one column has no room for them.
export const columnsFor = (count) => (count > COLUMN_MAX ? 2 : 1);

// Whether strip `n` is the last one of its column, which has the time axis.
export const isLowest = (n, count) => n + columnsFor(count) >= count;

// Places of labels [px, downwards], in the order of `wanted`, that are at least `least` apart and between
// `top` and `bottom`.
export function apart(wanted, least, top, bottom) {
  const order = [...wanted.keys()].sort((a, b) => wanted[a] - wanted[b]);
  const found = [...wanted];
  let limit = top;
  for (const n of order) {
    found[n] = Math.max(found[n], limit);
    limit = found[n] + least;
  }
  limit = bottom;
  for (const n of order.reverse()) {
    found[n] = Math.min(found[n], limit);
    limit = found[n] - least;
  }
  return found;
}

// The strips with their lines: name, colour, dashed or not, and a function that gives the value in a row of
// housekeeping. `reported`: names of the parameters of the subsystem that moves the robot; forceOf(row): size
// of the force at its tip. A robot without joints has the position of its body instead.
export function stripsOf(robot, reported, forceOf) {
  if (!robot) return [];
  if (!moving(robot).length) {
    return [
      {
        title: "Position of the body",
        unit: "m",
        lines: ["x", "y", "z"].map((name, n) => ({
          name,
          short: name,
          colour: COLOURS[n],
          of: (row) => row.BASE?.[n],
        })),
      },
    ];
  }
  const parts = groups(robot, LINES_MAX);
  const isSmall = moving(robot).length <= 2;
  const torque = reported.includes("CUR_VALUES.EXTERNAL_TORQUE") ? "EXTERNAL_TORQUE" : "TORQUE";
  return [
    ...parts.map((part) => positions(part, isSmall)),
    ...parts.map((part) => torques(part, torque, isSmall)),
    {
      title: "Force at the tip",
      unit: "N",
      lines: [{ name: "from joint torques", colour: "force", of: forceOf, isComputed: true }],
    },
  ];
}

// Positions of a group of joints; of an arm with few joints the desired ones as well.
function positions({ isPrismatic, joints }, isSmall) {
  const desired = isSmall ? joints : [];
  return {
    title: "Joint position",
    unit: isPrismatic ? "m" : "rad",
    lines: [
      ...lines(isSmall ? "POSITION" : "", joints, (row, n) => row["CUR_VALUES.POSITION"]?.[n]),
      ...desired.map((n) => ({
        name: n ? `${n + 1}` : "desired 1",
        colour: "desired",
        dashed: true,
        of: (row) => (row["DES_POSITION"] ?? row["CUR_VALUES.DESIRED"])?.[n],
      })),
    ],
  };
}

// Torques of a group of joints: those of the environment; if the subsystem does not report them, those of the
// joints themselves.
function torques({ isPrismatic, joints }, leaf, isSmall) {
  const isExternal = leaf === "EXTERNAL_TORQUE";
  const kind = isPrismatic ? "force" : "torque";
  const name = isExternal ? "EXTERNAL" : "TORQUE";
  return {
    title: `${isExternal ? "External" : "Joint"} ${kind}`,
    unit: isPrismatic ? "N" : "Nm",
    lines: lines(isSmall ? name : "", joints, (row, n) => row[`CUR_VALUES.${leaf}`]?.[n]),
  };
}

// Lines of joints. Without a `name`, in the strips of an arm with more than two joints, a line has the number
// of its joint only; the title of the strip says what it shows.
const lines = (name, joints, of) =>
  joints.map((n, place) => ({
    name: name ? `${name}.${n + 1}` : `${n + 1}`,
    short: `${n + 1}`,
    colour: COLOURS[place],
    of: (row) => of(row, n),
  }));

// The housekeeping structure that a mission without a robot charts first: of the first member that has one
// with measured values, the display structure if it has some, because a page that is open enables it. A
// replay has only structures that were reported. configurationOf(name): present configuration of a member, or
// undefined; isReported(name, id): whether there are reports of a structure.
export function firstMeasured(members, configurationOf, isReported) {
  const rank = (name, { id, display }) => 2 * isReported(name, id) + display;
  for (const { name, parameters, configurations } of members) {
    const structures = (configurationOf(name) ?? configurations[0])?.structures ?? [];
    const found = [...structures]
      .sort((one, other) => rank(name, other) - rank(name, one))
      .map(({ id, leaves }) => ({
        name,
        id,
        leaves: leaves
          .map((leaf) => parameters.find((one) => one.name === leaf))
          .filter((leaf) => ["FLOAT", "DOUBLE"].includes(leaf?.type)),
      }))
      .find(({ leaves }) => leaves.length);
    if (found) return found;
  }
  return null;
}
