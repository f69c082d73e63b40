// @ts-check
// The samples that a page has: a row of numbers for every tick of the last two minutes, and which moment of them is shown. Everything that draws
// or writes reads them by `value(name, ago)`, counted from that moment; so that picture, numbers and plots are of one time.

/** @typedef {{ name: string, unit: string, means?: string }} Column */

/** Rows that are kept: 131 s at 1 kHz. A power of two. */
export const KEPT = 131072;
/** What differs by less is not seen: half of the last digit that is written. Units that are not here move nothing that is drawn. */
const SEEN = { m: 1e-6, N: 2e-3, J: 5e-6, "": 0 };
/** Columns that say how the line is, not where anything is: their numbers are written now and then, whatever moves. */
const OF_LINE = /^(live|delay|sent|lost)_/;

export class Samples {
  /** Which number of a row each column is. @type {Map<string, number>} */
  columns = new Map();
  /** Each column and its unit, in order. @type {Map<string, string>} */
  named = new Map();
  /** Ticks that are there: from this one on, to before that one. */
  first = 0;
  next = 0;
  /** Tick of the newest row in which something moved that is seen, and when it came, ms. */
  moved = 0;
  movedAt = 0;
  /** Something has been elsewhere than at zero. */
  touched = false;
  /** Tick of the moment that is shown; none: the newest. @type {number | undefined} */
  #at = undefined;
  /** From which tick on samples are looked at while the moment stands; and where they are, once newer ones have taken their place.
   * @type {{ from: number, numbers?: Float32Array, first: number, next: number } | undefined} */
  #held = undefined;
  #width = 1;
  #numbers = new Float32Array(0);
  /** The row since which nothing has moved, and by how much each of its numbers may change. */
  #rest = new Float32Array(0);
  #seen = new Float32Array(0);

  /** Begins anew with these columns, behind which stands the count of starts. @param {Column[]} columns */
  begin(columns) {
    this.columns = new Map([...columns.map(({ name }) => name), "restarts"].map((name, at) => [name, at]));
    this.named = new Map([...columns.map(({ name, unit }) => /** @type {[string, string]} */ ([name, unit]))]);
    if (!this.named.has("restarts")) this.named.set("restarts", "");
    this.#width = columns.length + 1;
    this.#numbers = new Float32Array(KEPT * this.#width);
    this.#rest = new Float32Array(this.#width).fill(NaN);
    this.touched = false;
    const seen = columns.map(({ name, unit }) =>
      OF_LINE.test(name) ? Infinity : (SEEN[/** @type {keyof typeof SEEN} */ (unit)] ?? Infinity),
    );
    this.#seen = Float32Array.from([...seen, 0]);
    this.first = this.next = 0;
    this.show(undefined);
  }

  /** Forgets all rows: those that follow are of another time. */
  forget() {
    this.first = this.next = 0;
  }

  /** Shows a moment, around which samples from this tick on are looked at; none: the newest. @param {number | undefined} at @param {number} [from] */
  show(at, from = at) {
    this.#at = at;
    if (at === undefined || from === undefined) this.#held = undefined;
    else if (!this.#held?.numbers) this.#held = { from, first: this.first, next: this.next };
  }

  /** Ticks of which there are samples while a moment is shown. @returns {{ first: number, next: number }} */
  get there() {
    return this.#held?.numbers ? this.#held : this;
  }

  /** Rows in a piece of what came. @param {Float32Array} rows */
  count = (rows) => Math.floor(rows.length / this.#width);

  /** Takes rows, from this tick on. What is missing before them is a gap, or, where that is long, the beginning.
   * @param {number} first @param {Float32Array} rows @param {number} now ms @param {boolean} [recorded] it does not matter what moves */
  take(first, rows, now, recorded = false) {
    const gap = first - this.next;
    if (this.next === this.first || gap < 0 || gap >= KEPT) this.first = this.next = first;
    for (; this.next < first; this.next++) this.#row(this.next).fill(NaN);
    const count = this.count(rows);
    const held = this.#held;
    if (held && !held.numbers && this.next + count - KEPT > held.from)
      this.#held = { ...held, numbers: this.#numbers.slice(), first: this.first, next: this.next };
    // In two pieces at the most: what is behind the end of the ring goes to its beginning.
    const fits = Math.min(count, KEPT - (first & (KEPT - 1)));
    this.#numbers.set(rows.subarray(0, fits * this.#width), (first & (KEPT - 1)) * this.#width);
    this.#numbers.set(rows.subarray(fits * this.#width, count * this.#width), 0);
    for (let row = 0; row < (recorded ? 0 : count); row++) {
      const at = row * this.#width;
      if (this.#rests(rows, at)) continue;
      this.touched ||= this.#seen.some((seen, column) => Math.abs(rows[at + column] ?? NaN) > seen);
      this.#rest.set(rows.subarray(at, at + this.#width));
      [this.moved, this.movedAt] = [first + row, now];
    }
    this.next = first + count;
    this.first = Math.max(this.first, this.next - KEPT);
  }

  /** @param {number} tick */
  #row(tick) {
    const at = (tick & (KEPT - 1)) * this.#width;
    return this.#numbers.subarray(at, at + this.#width);
  }

  /** Whether nothing has moved in the row that begins there. @param {Float32Array} rows @param {number} from */
  #rests(rows, from) {
    for (let at = 0; at < this.#width; at++) {
      const now = rows[from + at] ?? NaN;
      const before = this.#rest[at] ?? NaN;
      // No number stays none.
      if (!(Math.abs(now - before) <= (this.#seen[at] ?? 0)) && !(Number.isNaN(now) && Number.isNaN(before))) return false;
    }
    return true;
  }

  /** A column's number at a tick; none where that is not there. @param {string} name @param {number} tick */
  of(name, tick) {
    const { first, next } = this.there;
    if (!(tick >= first && tick < next)) return NaN;
    const numbers = this.#held?.numbers ?? this.#numbers;
    return numbers[(tick & (KEPT - 1)) * this.#width + (this.columns.get(name) ?? NaN)] ?? NaN;
  }

  /** Tick of the moment that is shown. @returns {number} */
  shown = () => this.#at ?? this.next - 1;

  /** Whether what is shown is not the newest. */
  get past() {
    return this.#at !== undefined;
  }

  /** A column's number so many ticks before the moment that is shown; after it, where that is below 0. @param {string} name @param {number} [ago] */
  value = (name, ago = 0) => this.of(name, this.shown() - ago);

  /** The newest number of a column, whatever is shown. @param {string} name */
  newest = (name) => this.#numbers[((this.next - 1) & (KEPT - 1)) * this.#width + (this.columns.get(name) ?? NaN)] ?? NaN;
}
