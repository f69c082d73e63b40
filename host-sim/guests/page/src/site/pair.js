// @ts-check
// Two peers whose object is shared in the plane or in space: seen from above, and in space from the front as well, beside that.
// What is along one axis the page draws itself.

import { make, move, put } from "./environments.js";

/** @typedef {import("./environments.js").Point} Point */
/** @typedef {import("./environments.js").Place} Place */
/** @typedef {import("./environments.js").Value} Value */
/** @typedef {import("./environments.js").Picture} Picture */
/** @typedef {import("./environments.js").Strip} Strip */

/** What stands behind a column's name for each axis, and what the axis is called. */
export const SUFFIXES = ["", "_y", "_z"];
export const WAYS = ["along", "across", "up"];

/** Axes that are shared in this environment. @param {string} name */
export const axesOf = (name) => ({ pair: 1, plane: 2, space: 3 })[name] ?? 0;

/** A quantity of a peer along each shared axis. @param {Value} value @param {number} axes @param {string} name @param {number} [ago] */
export const along = (value, axes, name, ago = 0) => SUFFIXES.slice(0, axes).map((suffix) => value(`${name}${suffix}`, ago));

/** Half of a picture's width and height, and from the middle of one to that of the next, mm. */
const [HALF_X, HALF_Y, NEXT] = [170, 130, 352];
/** From the middle of the object to a hand, to the left for peer 1, mm. */
const HANDLE = 38;
/** Half of the object, mm. */
const EDGE = 18;

/** @param {SVGElement} to @param {Value} value @param {number} me @param {number} axes @returns {Picture} */
export function peers(to, value, me, axes) {
  // Each picture shows the first axis to the right, and one of the others up.
  const pictures = axes === 3 ? [1, 2] : [1];
  const handle = (/** @type {number} */ n) => (n === 1 ? -HANDLE : HANDLE);
  /** Where something is in a picture. @param {number} picture @param {number[]} at m @returns {Point} */
  const drawn = (picture, at) => [1e3 * (at[0] ?? NaN) + NEXT * picture, -1e3 * (at[pictures[picture] ?? 1] ?? NaN)];
  /** Where the copy of a peer is; of one on another machine, what it has not said of itself is where this one believes it to be.
   * @param {number} n */
  const copy = (n) =>
    along(value, axes, `object_${n}`).map((at, axis) =>
      Number.isFinite(at) || n === me ? at : value(`decoded_${me}${SUFFIXES[axis]}`),
    );
  const parts = pictures.map((axis, picture) => {
    make(to, "rect", { class: "court", x: NEXT * picture - HALF_X, y: -HALF_Y, width: 2 * HALF_X, height: 2 * HALF_Y });
    make(to, "text", { class: "large", x: NEXT * picture, y: HALF_Y - 6 }).textContent =
      axes === 2 ? "from above" : axis === 1 ? "from above: along and across" : "from the front: along and up";
    return [1, 2].map((n) => ({
      copy: make(to, "rect", { class: `p${n}`, x: -EDGE, y: -EDGE, width: 2 * EDGE, height: 2 * EDGE, rx: 2 }),
      arm: make(to, "line", { class: `p${n}` }),
      device: make(to, "circle", { class: `p${n} handle`, r: 6 }),
      pull: make(to, "line", { class: `p${n}` }),
      force: make(to, "line", { class: `p${n} force` }),
      coordination: make(to, "line", { class: `p${n} force told` }),
    }));
  });
  const gap = make(to, "text", { class: "large", x: 0, y: -HALF_Y + 16 });
  const cut = make(to, "text", { class: "large bad", x: 0, y: -HALF_Y + 32 });
  cut.textContent = "✂ line cut: each copy stands alone";
  /** @param {SVGElement} line @param {Point} from @param {Point} to */
  const draw = (line, [x1, y1], [x2, y2]) => {
    const there = Number.isFinite(x1 + y1 + x2 + y2);
    line.toggleAttribute("hidden", !there);
    if (there) put(line, { x1: x1.toFixed(2), y1: y1.toFixed(2), x2: x2.toFixed(2), y2: y2.toFixed(2) });
  };
  return {
    box: `${-HALF_X - 4} ${-HALF_Y - 4} ${2 * HALF_X + 8 + NEXT * (pictures.length - 1)} ${2 * HALF_Y + 8}`,
    flat: false,
    toScene: (at, picture) => {
      const [x, y] = drawn(picture, at);
      return [x + handle(me), y];
    },
    fromScene: ([x, y], at, picture) => {
      const moved = /** @type {Place} */ ([...at]);
      moved[0] = (x - NEXT * picture - handle(me)) / 1e3;
      moved[pictures[picture] ?? 1] = -y / 1e3;
      return moved;
    },
    picture: ([x]) => (axes === 3 && x > NEXT - HALF_X - 6 ? 1 : 0),
    hand: `wanted_${me}`,
    own: () => {
      const [x = NaN, y = 0, z = 0] = along(value, axes, `device_${me}`);
      return [x, y, z];
    },
    draw: (isCut) => {
      for (const [picture, both] of parts.entries()) {
        for (const [index, { copy: square, arm, device, pull, force, coordination }] of both.entries()) {
          const n = index + 1;
          const aside = (/** @type {Point} */ [x, y]) => /** @type {Point} */ ([x + handle(n), y]);
          const at = drawn(picture, copy(n));
          const hand = aside(drawn(picture, along(value, axes, `device_${n}`)));
          move(square, at);
          move(device, hand);
          draw(arm, [at[0] + Math.sign(handle(n)) * EDGE, at[1]], hand);
          draw(pull, hand, aside(drawn(picture, along(value, axes, `wanted_${n}`))));
          // 10 mm a newton.
          const pushed = (/** @type {string} */ name) => {
            const of = along(value, axes, name).map((newton) => Math.max(-12, Math.min(12, newton)));
            return [10 * (of[0] ?? NaN), -10 * (of[pictures[picture] ?? 1] ?? NaN)];
          };
          const [[fx = NaN, fy = NaN], [cx = NaN, cy = NaN]] = [pushed(`hand_${n}`), pushed(`coordination_${n}`)];
          draw(force, hand, [hand[0] + fx, hand[1] + fy]);
          draw(coordination, at, [at[0] + cx, at[1] + cy]);
        }
      }
      const [one, two] = [copy(1), copy(2)];
      const mm = 1e3 * Math.hypot(...one.map((at, axis) => at - (two[axis] ?? NaN)));
      gap.textContent = Number.isFinite(mm) ? `copies apart: ${mm.toFixed(2)} mm` : "";
      cut.toggleAttribute("hidden", !isCut);
    },
    numbers: [],
    help: `Drag your hand with mouse, finger or pen. How far it is from its ring is your force: 5 mm are 1 N. Lines: force of a hand (full) and of the coordination (dashed), 10 mm are 1 N.${
      axes === 3
        ? " In the left picture it goes along and across, in the right one along and up; Page Up and Page Down lift and lower it."
        : ""
    }`,
  };
}

/** What is plotted of two peers: places along each axis, of forces their size where there are several. How far apart the copies are, truly and as this peer
 * believes, and how large a force is, mm and N, the page knows.
 * @param {Value} value @param {number} me @param {{ apart: (ago: number) => number, decoded: (ago: number) => number, force: (name: string, ago: number) => number }} page
 * @param {number} axes @returns {Strip[]} */
export const pairStrips = (value, me, { apart, decoded, force }, axes) => [
  ...WAYS.slice(0, axes).map((way, axis) => ({
    id: axis === 0 ? "position" : `position-${way}`,
    title: axes === 1 ? "Position" : `Position, ${way}`,
    unit: "mm",
    series: [1, 2].map((n) => ({
      name: `copy ${n}`,
      of: (/** @type {number} */ ago) => 1e3 * value(`object_${n}${SUFFIXES[axis]}`, ago),
    })),
  })),
  {
    id: "force",
    title: "Force",
    unit: "N",
    series: [
      ...[1, 2].map((n) => ({ name: `hand ${n}`, of: (/** @type {number} */ ago) => force(`hand_${n}`, ago) })),
      { name: `coordination ${me}`, of: (ago) => force(`coordination_${me}`, ago) },
    ],
  },
  {
    id: "apart",
    title: "Copies apart",
    unit: "mm",
    series: [
      { name: "true", of: apart },
      { name: `as peer ${me} believes`, of: decoded },
    ],
  },
  {
    id: "energy",
    title: "Energy",
    unit: "mJ",
    series: [
      { name: "sent, not received", of: (ago) => 1e3 * value("line", ago) },
      ...[1, 2].map((n) => ({ name: `used up by ${n}`, of: (/** @type {number} */ ago) => 1e3 * value(`kept_${n}`, ago) })),
    ],
  },
];
/** The same of boards, of which the devices are what is always known. @param {Value} value @param {Strip[]} strips @returns {Strip[]} */
export const boardStrips = (value, strips) =>
  strips.map((strip) =>
    strip.id === "position"
      ? {
          ...strip,
          series: ["device", "object"].flatMap((what) =>
            [1, 2].map((n) => ({
              name: `${what === "object" ? "copy" : what} ${n}`,
              of: (/** @type {number} */ ago) => 1e3 * value(`${what}_${n}`, ago),
            })),
          ),
        }
      : strip,
  );
