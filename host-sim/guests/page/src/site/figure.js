// @ts-check
// A plot: series over time with axes, numbers, units and a legend, drawn with a pen that is a canvas or text of an SVG. Series differ by colour and by
// how they are dashed; a peak of one tick is drawn whatever the dashes.

/** @typedef {{ title: string, unit: string, series: { name: string }[] }} Of */
/** @typedef {[low: number, high: number]} Extremes */
/** What a pen can draw; a mark is a vertical line of this width at x from y to y.
 * @typedef {{ line: (x1: number, y1: number, x2: number, y2: number, colour: string) => void, marks: (marks: [number, number, number][], colour: string, width: number) => void,
 *   text: (text: string, x: number, y: number, colour: string, anchor: "start" | "middle" | "end", bold?: boolean) => void }} Pen */
/** @typedef {{ ink: string, faint: string, series: string[] }} Colours */

/** Dashes of each series: pixels on, off, on, off. */
export const DASHES = [
  [1, 0],
  [9, 5],
  [2, 4],
  [9, 3, 2, 3],
];
/** Room for numbers beside and below a plot, and for a letter's half above it, pixels. */
const [BESIDE, BELOW, ABOVE] = [64, 18, 7];
/** Size of letters, pixels. */
const LETTER = 11;
/** Least that a plot shows from bottom to top, of a unit; of others 1. */
const LEAST = { mm: 0.1, N: 0.1, mJ: 0.1, m: 0.1 };

/** The next of 1, 2, 5, 10, … @param {number} number */
function round(number) {
  const power = 10 ** Math.floor(Math.log10(number));
  return power * (number / power <= 1 ? 1 : number / power <= 2 ? 2 : number / power <= 5 ? 5 : 10);
}

/** Round numbers from one number to another, about so many, and how each is written. @param {number} from @param {number} to @param {number} about */
export function ticks(from, to, about) {
  const step = round((to - from) / about);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const write = (/** @type {number} */ number) =>
    Math.max(Math.abs(from), Math.abs(to)) >= 1e6
      ? number.toExponential(1)
      : (number === 0 ? 0 : number).toFixed(digits).replace("-", "−");
  const first = Math.ceil(from / step - 1e-9);
  const count = Math.floor(to / step + 1e-9) - first + 1;
  const numbers = Array.from({ length: Math.max(0, count) }, (_, at) => (first + at) * step);
  return { step, numbers, write };
}

/** Bottom and top of a plot: round, with 0 in it, wide enough for what is there; after a peak it shrinks slowly.
 * @param {number[]} numbers @param {[number, number] | undefined} before @param {string} unit @returns {{ raw: [number, number], range: [number, number] }} */
export function range(numbers, before, unit) {
  let [least, most] = [Math.min(0, 0.95 * (before?.[0] ?? 0)), Math.max(0, 0.95 * (before?.[1] ?? 0))];
  for (const number of numbers) {
    if (number < least) least = number;
    if (number > most) most = number;
  }
  const wide = Math.max(most - least, LEAST[/** @type {keyof typeof LEAST} */ (unit)] ?? 1);
  const step = round(wide / 4);
  // A fiftieth of a step beyond an end is drawn outside it.
  const [low, high] = [Math.floor(least / step + 0.02) * step, Math.ceil(most / step - 0.02) * step];
  return { raw: [least, most], range: [low, Math.max(high, low + 2 * step)] };
}

/** Where the plot itself is in a box of this size. @param {number} wide @param {number} high @param {number} [above] */
export const inside = (wide, high, above = ABOVE) => ({
  x: BESIDE,
  y: above,
  wide: Math.max(1, wide - BESIDE - 10),
  high: Math.max(1, high - above - BELOW),
});

/** Draws axes, and each series by its extremes in every pixel.
 * @param {Pen} pen @param {Of} of @param {Extremes[][]} lines @param {[number, number]} range
 * @param {{ from: number, to: number, now: boolean, phase: number }} time s at both ends; whether it is counted from now; pixels that went by before the first
 * @param {ReturnType<typeof inside>} place @param {Colours} colours */
export function draw(pen, { unit, series }, lines, [least, most], time, place, colours) {
  const { x: left, y: top, wide, high } = place;
  const y = (/** @type {number} */ number) => top + high - ((number - least) / (most - least)) * high;
  const across = ticks(least, most, Math.max(2, Math.min(5, high / 22)));
  for (const [at, number] of across.numbers.entries()) {
    pen.line(left, y(number), left + wide, y(number), number === 0 ? colours.ink : colours.faint);
    const last = at === across.numbers.length - 1;
    pen.text(across.write(number) + (last && unit ? ` ${unit}` : ""), left - 4, y(number) + 4, colours.ink, "end");
  }
  const x = (/** @type {number} */ at) => left + ((at - time.from) / (time.to - time.from)) * wide;
  const along = ticks(time.from, time.to, Math.max(2, Math.min(8, wide / 70)));
  for (const at of along.numbers) {
    pen.line(x(at), top + high, x(at), top + high + 4, colours.ink);
    const text = time.now && at === 0 ? "now" : `${along.write(at)} s`;
    pen.text(text, x(at), top + high + BELOW - 3, colours.ink, x(at) > left + wide - 12 ? "end" : "middle");
  }
  for (const [which, line] of lines.entries()) {
    const dashes = DASHES[which % DASHES.length] ?? [1, 0];
    const drawn = dashes.flatMap((length, part) => Array.from({ length }, () => part % 2 === 0));
    const on = (/** @type {number} */ pixel) => drawn[(((pixel + time.phase) % drawn.length) + drawn.length) % drawn.length];
    /** @type {[number, number, number][]} */
    const marks = [];
    const step = wide / line.length;
    for (const [pixel, [low, high]] of line.entries()) {
      if (!(low <= high)) continue;
      const [from, to] = [y(high), y(low)];
      if (to - from > 3 || on(Math.floor(pixel * step))) marks.push([left + (pixel + 0.5) * step, from - 0.8, to + 0.8]);
    }
    pen.marks(marks, colours.series[which % colours.series.length] ?? colours.ink, step);
  }
  if (series.length === 0) pen.text("nothing to show", left + wide / 2, top + high / 2, colours.ink, "middle");
}

/** A legend in a line: for each series as it is drawn, and its name. Gives where it ends. @param {Pen} pen @param {Of} of @param {number} x @param {number} y
 * @param {Colours} colours @param {(text: string) => number} wide */
export function legend(pen, { series }, x, y, colours, wide) {
  let at = x;
  for (const [which, { name }] of series.entries()) {
    const [colour, dashes] = [colours.series[which] ?? colours.ink, DASHES[which % DASHES.length] ?? [1, 0]];
    /** @type {[number, number, number][]} */
    const marks = [];
    const drawn = dashes.flatMap((length, part) => Array.from({ length }, () => part % 2 === 0));
    for (let pixel = 0; pixel < 28; pixel++) if (drawn[pixel % drawn.length]) marks.push([at + pixel + 0.5, y - 5, y - 3]);
    pen.marks(marks, colour, 1);
    pen.text(name, at + 33, y, colours.ink, "start");
    at += 33 + wide(name) + 16;
  }
  return at;
}

/** A pen for a canvas. @param {CanvasRenderingContext2D} context @returns {Pen} */
export const canvasPen = (context) => ({
  line: (x1, y1, x2, y2, colour) => {
    context.fillStyle = colour;
    context.fillRect(Math.min(x1, x2), Math.min(y1, y2), Math.max(1, Math.abs(x2 - x1)), Math.max(1, Math.abs(y2 - y1)));
  },
  marks: (marks, colour, width) => {
    context.fillStyle = colour;
    for (const [x, from, to] of marks) context.fillRect(x - width / 2, from, width, to - from);
  },
  text: (text, x, y, colour, anchor, bold = false) => {
    context.fillStyle = colour;
    context.font = `${bold ? "600 " : ""}${LETTER}px system-ui, sans-serif`;
    context.textAlign = anchor === "middle" ? "center" : anchor;
    context.fillText(text, x, y);
  },
});

/** A pen for the text of an SVG, which it adds to this list. @param {string[]} parts @returns {Pen} */
export const svgPen = (parts) => ({
  line: (x1, y1, x2, y2, colour) => {
    parts.push(
      `<line x1="${x1.toFixed(2)}" y1="${y1.toFixed(2)}" x2="${x2.toFixed(2)}" y2="${y2.toFixed(2)}" stroke="${colour}"/>`,
    );
  },
  marks: (marks, colour, width) => {
    const path = marks.map(([x, from, to]) => `M${x.toFixed(2)} ${from.toFixed(2)}V${to.toFixed(2)}`).join("");
    parts.push(`<path d="${path}" stroke="${colour}" stroke-width="${width}"/>`);
  },
  text: (text, x, y, colour, anchor, bold = false) => {
    const safe = text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
    parts.push(
      `<text x="${x.toFixed(2)}" y="${y.toFixed(2)}" fill="${colour}" text-anchor="${anchor}"${bold ? ' font-weight="600"' : ""}>${safe}</text>`,
    );
  },
});
