// SPDX-License-Identifier: Apache-2.0
// History of reports in typed arrays. An hour of a recording has 180 000 rows; a row becomes an object only
// when it is shown.

// Largest number of rows that are evaluated for a line whose value is computed from several columns.
const POINTS_MOST = 20000;

export class History {
  // tables: tables of a recording. rename: function that gives the name of a leaf in a row. gap: time without
  // reports [s] after which an empty row interrupts the lines.
  constructor(tables, rename, gap) {
    this.columns = tables.map(
      ({ leaves }) => new Map([...leaves].map(([name, parts]) => [rename(name), parts])),
    );
    const count = tables.reduce((sum, { t }) => sum + t.length, 0);
    const table = new Uint8Array(count),
      index = new Uint32Array(count);
    this.merge(tables, table, index);
    let gaps = 0,
      before = NaN;
    for (let n = 0; n < count; n++) {
      const time = tables[table[n]].t[index[n]];
      if (time - before > gap) gaps++;
      before = time;
    }
    this.t = new Float64Array(count + gaps);
    this.table = new Uint8Array(count + gaps);
    this.index = new Int32Array(count + gaps); // Row of the table; -1: an empty row.
    let at = 0;
    for (let n = 0; n < count; n++) {
      const time = tables[table[n]].t[index[n]];
      if (at && time - this.t[at - 1] > gap) {
        this.t[at] = this.t[at - 1] + 0.001;
        this.index[at++] = -1;
      }
      this.t[at] = time;
      this.table[at] = table[n];
      this.index[at++] = index[n];
    }
    this.length = at;
  }

  // Sort the rows of all tables by time: write the number of the table and the row in it to `table` and
  // `index`.
  merge(tables, table, index) {
    const next = tables.map(() => 0);
    for (let n = 0; n < index.length; n++) {
      let first = -1;
      for (let k = 0; k < tables.length; k++)
        if (
          next[k] < tables[k].t.length &&
          (first < 0 || tables[k].t[next[k]] < tables[first].t[next[first]])
        )
          first = k;
      table[n] = first;
      index[n] = next[first]++;
    }
  }

  // Values of a row by their names; null for an empty row.
  row(n) {
    if (n < 0 || n >= this.length || this.index[n] < 0) return null;
    const row = {};
    for (const [name, parts] of this.columns[this.table[n]])
      row[name] = Array.from(parts, (part) => part[this.index[n]]);
    return row;
  }

  // One object for each table, which reads the row `at.index`. Reading a value copies only that value.
  views(at) {
    return this.columns.map((columns) => {
      const view = {};
      for (const [name, parts] of columns) {
        const values = new Array(parts.length);
        Object.defineProperty(view, name, {
          enumerable: true,
          get: () => {
            for (let k = 0; k < parts.length; k++) values[k] = parts[k][at.index];
            return values;
          },
        });
      }
      return view;
    });
  }

  // Values of lines between two times in the format of uPlot. If there are more than two rows for each of
  // `pixels`, only the least and the greatest value in each pixel are returned.
  drawn(lines, range, pixels) {
    const first = Math.max(0, after(this.t, range[0]) - 1),
      end = Math.min(this.length, after(this.t, range[1]) + 1);
    const at = { index: 0 },
      views = this.views(at);
    const stride = lines.some((line) => line.isComputed)
      ? Math.max(1, Math.ceil((end - first) / POINTS_MOST))
      : 1;
    const value = (line, n) => {
      at.index = this.index[n];
      return at.index < 0 ? null : (line.of(views[this.table[n]]) ?? null);
    };
    if (end - first <= 2 * pixels) {
      const rows = Array.from({ length: end - first }, (_, n) => first + n);
      return [rows.map((n) => this.t[n]), ...lines.map((line) => rows.map((n) => value(line, n)))];
    }
    const times = [],
      found = lines.map(() => []);
    const width = (this.t[end - 1] - this.t[first]) / pixels;
    for (let n = first; n < end;) {
      const from = n,
        until = this.t[n] + width;
      const least = lines.map(() => null),
        most = lines.map(() => null);
      let hasGap = false;
      for (; n < end && (this.t[n] < until || n === from); n += stride) {
        hasGap = hasGap || this.index[n] < 0;
        for (let k = 0; k < lines.length; k++) {
          const one = value(lines[k], n);
          if (one === null || Number.isNaN(one)) continue;
          if (least[k] === null || one < least[k]) least[k] = one;
          if (most[k] === null || one > most[k]) most[k] = one;
        }
      }
      const last = Math.min(n, end) - 1;
      times.push(this.t[from], Math.max(this.t[last], this.t[from] + 1e-6));
      for (let k = 0; k < lines.length; k++) found[k].push(least[k], most[k]);
      if (hasGap) {
        times.push(times[times.length - 1] + 1e-6);
        for (const line of found) line.push(null);
      }
    }
    return [times, ...found];
  }
}

// Index of the first number that is greater than a value; the numbers are sorted.
export function after(numbers, value) {
  let low = 0,
    high = numbers.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numbers[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}
