// SPDX-License-Identifier: Apache-2.0
// Reader of the recording of a run; hirosco_gse/recording.py defines its format.

const NONE = -(2 ** 31); // The smallest 32-bit integer stands for "not a number".

class Reader {
  constructor(octets) {
    this.octets = octets;
    this.at = 0;
  }

  take(size) {
    this.at += size;
    if (this.at > this.octets.length) throw new Error("its end is missing");
    return this.octets.subarray(this.at - size, this.at);
  }

  // Numbers of a column. per: a number multiplied by it is an integer, and the column has the differences of
  // these integers in zigzag code; null: the column has 64-bit floating point numbers. Octets of equal
  // significance are together: first the lowest ones of all rows.
  column(rows, per) {
    const found = new Float64Array(rows);
    if (per === null) {
      const planes = this.take(8 * rows),
        octets = new Uint8Array(found.buffer);
      for (let k = 0; k < 8; k++) for (let n = 0; n < rows; n++) octets[8 * n + k] = planes[k * rows + n];
      return found;
    }
    const a = this.take(rows),
      b = this.take(rows),
      c = this.take(rows),
      d = this.take(rows);
    let sum = 0;
    for (let n = 0; n < rows; n++) {
      const coded = a[n] | (b[n] << 8) | (c[n] << 16) | (d[n] << 24);
      sum = (sum + ((coded >>> 1) ^ -(coded & 1))) | 0;
      found[n] = sum === NONE ? NaN : sum / per;
    }
    return found;
  }
}

// Read head and tables of a recording. A table has `t`, the time of each row [s], and `leaves`, a Map of each
// name to the columns of its numbers.
export async function unpack(octets) {
  const stream = new Blob([octets]).stream().pipeThrough(new DecompressionStream("gzip"));
  const reader = new Reader(new Uint8Array(await new Response(stream).arrayBuffer()));
  const size = reader.take(4);
  const head = JSON.parse(
    new TextDecoder().decode(reader.take(size[0] | (size[1] << 8) | (size[2] << 16) | (size[3] << 24))),
  );
  const tables = head.tables.map(({ rows, per, leaves, ...about }) => {
    const t = reader.column(rows, per);
    return {
      ...about,
      t,
      leaves: new Map(leaves.map(([name, pers]) => [name, pers.map((one) => reader.column(rows, one))])),
    };
  });
  return { ...head, tables };
}

export function fromBase64(text) {
  const words = atob(text),
    octets = new Uint8Array(words.length);
  for (let n = 0; n < words.length; n++) octets[n] = words.charCodeAt(n);
  return octets;
}
