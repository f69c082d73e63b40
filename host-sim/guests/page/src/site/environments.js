// @ts-check
// Shared environments beside the pair: what each draws, which numbers and plots it shows, and where a pointer is in it. What is in a
// sample, and what does not move, the program says ("hello").
import { text } from "./parts.js";

/** @typedef {(name: string, ago?: number) => number} Value */
/** @typedef {{ id: string, title: string, unit: string, series: { name: string, of: (ago: number) => number }[] }} Strip */
/** @typedef {[number, number]} Point */
/** Along, across and up, m. @typedef {[number, number, number]} Place */
/** What a page needs of an environment: the part of the drawing that is seen, where a hand (m) is in one of its pictures, where it is
 * when a pointer takes it from there to another place of that picture, which picture a place belongs to, the column that shows the own
 * hand first, where the own device is (m), what to draw each frame (of a line that is cut or not), and what to show beside it. Pictures may
 * have drawings of their own instead of the scene's (stages), and a sentence of their own on how it stands, and whether that is bad; some are told
 * the peers' modes, and above which number a mode is a fault, and some replay what was.
 * @typedef {{ box: string, flat: boolean, toScene: (at: Place, picture: number) => Point,
 *   fromScene: (to: Point, at: Place, picture: number) => Place, picture?: (at: Point) => number, hand: string, own: (picture: number) => Place,
 *   draw: (cut: boolean) => void, numbers: [string, () => string][], help: string,
 *   stages?: SVGSVGElement[], slowly?: () => void, status?: () => [string, boolean],
 *   told?: (modes: number[], base: number) => void, replayed?: () => number }} Picture */
/** @typedef {Picture & { strips: Strip[] }} View */

const SVG = "http://www.w3.org/2000/svg";

/** @param {SVGElement} parent @param {string} name @param {Record<string, string | number>} attributes @returns {SVGElement} */
export function make(parent, name, attributes) {
  const made = document.createElementNS(SVG, name);
  put(made, attributes);
  parent.append(made);
  return made;
}

/** @param {SVGElement} to @param {Record<string, string | number>} attributes */
export function put(to, attributes) {
  for (const [name, value] of Object.entries(attributes)) to.setAttribute(name, `${value}`);
}

/** Puts something where it is, or hides what is nowhere. @param {SVGElement} what @param {Point} at */
export function move(what, [x, y]) {
  const there = Number.isFinite(x) && Number.isFinite(y);
  what.toggleAttribute("hidden", !there);
  if (there) what.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})`);
}

/** A ring with a number in it. @param {SVGElement} parent @param {number} n */
function ring(parent, n) {
  const group = make(parent, "g", { class: `p${n}` });
  make(group, "circle", { r: 6 });
  make(group, "text", { y: 2 }).textContent = `${n}`;
  return group;
}

/** @param {number} count */
const all = (count) => Array.from({ length: count }, (_, at) => at + 1);

/** N hands on one object: every copy of it where it is, hands to the left and right. @param {SVGElement} to @param {Value} value @param {number} me @returns {View} */
function hub(to, value, me) {
  const users = all(4);
  const place = (/** @type {number} */ n) => /** @type {Point} */ ([n % 2 ? -40 : 40, n < 3 ? -8 : 20]);
  make(to, "line", { class: "ground", x1: -160, y1: 36, x2: 160, y2: 36 });
  const copies = users.map((n) => make(to, "rect", { class: `p${n}`, x: -20, y: -24, width: 40, height: 60, rx: 2 }));
  const hands = users.map((n) => ring(to, n));
  const pulls = users.map((n) => make(to, "line", { class: `p${n}` }));
  return {
    box: "-160 -50 320 96",
    flat: true,
    toScene: ([x]) => [1e3 * x + place(me)[0], place(me)[1]],
    fromScene: ([x]) => [(x - place(me)[0]) / 1e3, 0, 0],
    hand: `wanted_${me}`,
    own: () => [value(`device_${me}`), 0, 0],
    draw: () => {
      for (const n of users) {
        const [x, y] = place(n);
        const [device, wanted] = [1e3 * value(`device_${n}`) + x, 1e3 * value(`wanted_${n}`) + x];
        const [copy, hand, pull] = [copies[n - 1], hands[n - 1], pulls[n - 1]];
        if (copy) move(copy, [1e3 * value(`object_${n}`), 0]);
        if (hand) move(hand, [device, y]);
        pull?.toggleAttribute("hidden", !Number.isFinite(wanted));
        if (pull && Number.isFinite(wanted)) put(pull, { x1: device, x2: wanted, y1: y, y2: y });
      }
    },
    numbers: [
      ["copies apart, at most (true)", () => `${text(1e3 * value("apart"), 2)} mm`],
      ["hands 1 to 4", () => `${users.map((n) => text(value(`hand_${n}`), 1)).join(", ")} N`],
    ],
    strips: [
      strip("position", "Copies", "mm", users, (n) => [`copy ${n}`, (ago) => 1e3 * value(`object_${n}`, ago)]),
      strip("force", "Hands", "N", users, (n) => [`hand ${n}`, (ago) => value(`hand_${n}`, ago)]),
      strip("apart", "Copies apart", "mm", [1], () => ["at most", (ago) => 1e3 * value("apart", ago)]),
    ],
    help: "Four hands hold one object, each at its own copy, through a hub. Hands 3 and 4 are partners: one carries on, one resists.",
  };
}

/** @param {string} id @param {string} title @param {string} unit @param {number[]} users
 * @param {(n: number) => [string, (ago: number) => number]} of @returns {Strip} */
export const strip = (id, title, unit, users, of) => ({
  id,
  title,
  unit,
  series: users.map((n) => {
    const [name, number] = of(n);
    return { name, of: number };
  }),
});

/** The court from above, its front wall to the right. @param {SVGElement} to @param {Value} value @param {number} me
 * @param {{ size_m: Point, pointer: number }} more @returns {View} */
function squash(to, value, me, { size_m: [long, wide], pointer }) {
  const [users, scale] = [all(4), 30];
  make(to, "rect", { class: "court", width: scale * long, height: scale * wide });
  make(to, "line", { class: "front", x1: scale * long, y1: 0, x2: scale * long, y2: scale * wide });
  const hands = users.map((n) => ring(to, n));
  const turn = make(to, "circle", { class: "turn", r: 10 });
  const ball = make(to, "circle", { class: "ball", r: 3.5 });
  const at = (/** @type {string} */ name) => /** @type {Point} */ ([scale * value(`${name}_x`), scale * value(`${name}_y`)]);
  return {
    box: `-12 -12 ${scale * long + 24} ${scale * wide + 24}`,
    flat: false,
    toScene: ([x, y]) => [(scale * x) / pointer, (scale * y) / pointer],
    fromScene: ([x, y]) => [(x * pointer) / scale, (y * pointer) / scale, 0],
    hand: `hand_${me}_x`,
    own: () => [pointer * value(`hand_${me}_x`), pointer * value(`hand_${me}_y`), 0],
    draw: () => {
      hands.forEach((hand, index) => {
        move(hand, at(`hand_${index + 1}`));
      });
      move(ball, at("ball"));
      move(turn, value("next") > 0 ? at(`hand_${value("next")}`) : [NaN, NaN]);
    },
    numbers: [
      ["points of 1 to 4", () => users.map((n) => text(value(`score_${n}`), 0)).join(", ")],
      ["rally, hits", () => `${text(value("rally"), 0)}, ${text(value("stroke"), 0)}`],
      ["next to hit", () => (value("next") > 0 ? `player ${value("next")}` : "–")],
      ["round trip, which bounds the ball", () => `${text(1e3 * value("round_trip"), 0)} ms`],
    ],
    strips: [
      strip("along", "From the back of the court", "m", [1, 2], (n) =>
        n === 1 ? ["ball", (ago) => value("ball_x", ago)] : ["your hand", (ago) => value(`hand_${me}_x`, ago)],
      ),
      strip("hits", "Hits in the rally", "", [1], () => ["hits", (ago) => value("stroke", ago)]),
    ],
    help: "Drag your hand to the ball: on your turn (the ring) the racket hits what it meets, as hard and as far aside as the hand moves. Serve by moving forward, to the right. Bots play the other hands.",
  };
}

/** A static world: what is solid, two devices, and where each was told that the other is. @param {SVGElement} to @param {Value} value
 * @param {number} me @param {{ corners?: Point[], round?: [number, number, number], strip?: [Point, Point] }[]} more @returns {View} */
function world(to, value, me, more) {
  const scene = (/** @type {Point | Place} */ [x, y]) => /** @type {Point} */ ([1e3 * x, -1e3 * y]);
  for (const { corners, round, strip: band } of more) {
    if (corners?.length)
      make(to, "polygon", { class: "solid", points: corners.map((corner) => scene(corner).join(",")).join(" ") });
    if (round) make(to, "circle", { class: "solid", cx: 1e3 * round[0], cy: -1e3 * round[1], r: 1e3 * round[2] });
    if (band) {
      const [[x1, y1], [x2, y2]] = [scene(band[0]), scene(band[1])];
      make(to, "line", { class: "band", x1, y1, x2, y2 });
    }
  }
  const forces = [1, 2].map((n) => make(to, "line", { class: `p${n} force` }));
  const devices = [1, 2].map((n) => ring(to, n));
  const seen = make(to, "circle", { class: "turn", r: 8 });
  const at = (/** @type {string} */ name, ago = 0) => /** @type {Point} */ ([value(`${name}_x`, ago), value(`${name}_y`, ago)]);
  const size = (/** @type {number} */ n, ago = 0) => Math.hypot(...at(`force_${n}`, ago));
  return {
    box: "-140 -85 280 170",
    flat: false,
    toScene: scene,
    fromScene: ([x, y]) => [x / 1e3, -y / 1e3, 0],
    hand: `wanted_${me}_x`,
    own: () => [...at(`device_${me}`), 0],
    draw: () => {
      for (const n of [1, 2]) {
        const [[x, y], [fx, fy]] = [scene(at(`device_${n}`)), at(`force_${n}`)];
        const [device, force] = [devices[n - 1], forces[n - 1]];
        if (device) move(device, [x, y]);
        if (force && Number.isFinite(x + fx)) put(force, { x1: x, y1: y, x2: x + 10 * fx, y2: y - 10 * fy });
      }
      move(seen, scene(at(`seen_${me}`)));
    },
    numbers: [
      ["force on you", () => `${text(size(me), 2)} N`],
      ["objects known", () => text(value(`felt_${me}`), 0)],
      ["objects touched", () => text(value(`touched_${me}`), 0)],
    ],
    strips: [
      strip("force", "Force of the world", "N", [1, 2], (n) => [`on ${n}`, (ago) => size(n, ago)]),
      strip("position", "Your device", "mm", [1, 2], (n) =>
        n === 1
          ? ["along", (ago) => 1e3 * value(`device_${me}_x`, ago)]
          : ["across", (ago) => 1e3 * value(`device_${me}_y`, ago)],
      ),
    ],
    help: "Push along walls, ball, block and rubber band: what your device has been told of is felt, whatever the network does. The dashed ring is where you were told that the other visitor is. Lines are forces, 10 mm are 1 N.",
  };
}

/** One at a time: the object as each user sees it, and who has it. @param {SVGElement} to @param {Value} value @param {number} me
 * @param {string} name @returns {View} */
function turns(to, value, me, name) {
  const users = all(3);
  const objects = users.map((n) => make(to, "rect", { class: `p${n}`, x: -9, y: -9, width: 18, height: 18, rx: 2 }));
  const grips = users.map((n) => make(to, "line", { class: `p${n}` }));
  const hands = users.map((n) => ring(to, n));
  const at = (/** @type {string} */ what) => /** @type {Point} */ ([1e3 * value(`${what}_x`), -1e3 * value(`${what}_y`)]);
  const state = (/** @type {number} */ n) => ["–", "asks", "has it"][value(`state_${n}`)] ?? "–";
  return {
    box: "-140 -75 280 150",
    flat: false,
    toScene: ([x, y]) => [1e3 * x, -1e3 * y],
    fromScene: ([x, y]) => [x / 1e3, -y / 1e3, 0],
    hand: `hand_${me}_x`,
    own: () => [value(`hand_${me}_x`), value(`hand_${me}_y`), 0],
    draw: () => {
      for (const n of users) {
        const [[x, y], [ox, oy]] = [at(`hand_${n}`), at(`object_${n}`)];
        const [hand, object, grip] = [hands[n - 1], objects[n - 1], grips[n - 1]];
        if (hand) move(hand, [x, y]);
        if (object) move(object, [ox, oy]);
        const held = value(`state_${n}`) > 0;
        grip?.toggleAttribute("hidden", !held);
        grip?.classList.toggle("asks", value(`state_${n}`) === 1);
        if (grip && held && Number.isFinite(x + ox)) put(grip, { x1: x, y1: y, x2: ox, y2: oy });
      }
    },
    numbers: [
      ["who has it", () => (value("owner") > 0 ? `user ${value("owner")}` : "nobody")],
      ["users 1 to 3", () => users.map(state).join(", ")],
      ["version known", () => users.map((n) => text(value(`version_${n}`), 0)).join(", ")],
    ],
    strips: [
      strip("position", "The object, along", "mm", users, (n) => [`as ${n} sees it`, (ago) => 1e3 * value(`object_${n}_x`, ago)]),
      strip("owner", "Who has it", "", [1], () => ["user", (ago) => value("owner", ago)]),
    ],
    help: `Take the object by dragging your hand from it: ${
      name === "lock" ? "a server gives the lock, first come first served" : "the token comes round to who asks"
    }. Who has it carries it along; where you let go it is published. A dashed line is a hand that asks. Bots are the other users.`,
  };
}

/** The view of an environment, drawn into a group; none of two peers.
 * @param {string} name @param {SVGElement} to @param {Value} value @param {number} me @param {any} more @returns {View | undefined} */
export function view(name, to, value, me, more) {
  to.replaceChildren();
  if (name === "hub") return hub(to, value, me);
  if (name === "squash") return squash(to, value, me, more);
  if (name === "world") return world(to, value, me, more ?? []);
  if (name === "lock" || name === "ring") return turns(to, value, me, name);
  return undefined;
}
