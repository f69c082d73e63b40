// @ts-check
// A bad network: a lane for each of three laws, under the same pushes and the same packets. Each is a drawing of its own, in which a
// pointer takes the hand of all of them, and a sentence on how it went since the start. Above them is each packet of the last two seconds.

import { make, move, put, strip } from "./environments.js";
import { text, write } from "./parts.js";
import { plainly, TOGETHER_MM } from "./status.js";

/** @typedef {import("./environments.js").Value} Value */
/** @typedef {import("./environments.js").View} View */

const LAWS = [
  {
    id: "power",
    name: "power: sends positions",
    why: "Each peer pulls its copy to the position that came last. While packets are missing that position is old, and pulling to it adds energy.",
  },
  {
    id: "wave",
    name: "passive wave: sends waves",
    why: "Each packet carries a piece of motion, which cannot add energy. A lost piece never comes again, so the copies stay apart by it.",
  },
  {
    id: "timed",
    name: "self-timed: sends sums of its waves",
    why: "Each packet carries the sum of everything sent so far. While none comes the line stands still; the next one brings all that was lost.",
  },
];
/** From the middle of the object to a hand, mm. */
const HANDLE = 38;
/** Ticks of which the packets are drawn. */
const LATEST = 2000;

const mm = (/** @type {number} */ far) => `${far.toFixed(far < 100 ? 1 : 0)} mm`;

/** @typedef {{ text: string, short: string, bad: boolean }} State */

/** Draws each packet of the last ticks where it was sent, a lost one short and red. They are the same in every lane that goes on. What it
 * returns draws them, and writes how many there were where that is wanted.
 * @param {HTMLElement} to @param {Value} value */
function packets(to, value) {
  to.className = "packets";
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  put(svg, { viewBox: `0 0 ${LATEST} 20`, preserveAspectRatio: "none", "aria-hidden": "true" });
  const [came, lost] = [make(svg, "path", { class: "came" }), make(svg, "path", { class: "lost" })];
  const caption = document.createElement("figcaption");
  to.append(svg, caption);
  return (counts = false) => {
    const id = LAWS.find(({ id }) => !(value(`fault_${id}`) > 0))?.id ?? "timed";
    const of = (/** @type {string} */ name, ago = 0) => value(`${name}_${id}`, ago);
    const since = (/** @type {string} */ name, /** @type {number} */ ago) => of(name, ago) - of(name, ago + 1);
    let [arrived, missing] = ["", ""];
    for (let ago = 0; ago < LATEST; ago++) {
      // Both peers send in the same tick.
      if (since("sent", ago) !== 2) continue;
      const [both, toOne] = [since("lost", ago), since("lost_1", ago)];
      for (const [row, isLost] of [both > toOne, toOne > 0].entries()) {
        const [x, y] = [LATEST - ago, 11 * row];
        if (isLost) missing += `M${x} ${y + 3}v3`;
        else arrived += `M${x} ${y}v9`;
      }
    }
    to.toggleAttribute("hidden", !Number.isFinite(of("lost_1")));
    put(came, { d: arrived });
    put(lost, { d: missing });
    if (!counts) return;
    write(
      caption,
      "Packets of the last 2 s, the newest at the right end. Upper row: from left to right. Lower row: from right to left. " +
        `A short red mark is a lost packet: ${text(of("lost"), 0)} of ${text(of("sent"), 0)} since the start.`,
    );
  };
}

/** @param {HTMLElement} to @param {Value} value @param {number} me @param {Record<string, string>} faults @returns {View} */
export function laws(to, value, me, faults) {
  to.replaceChildren();
  const part = (/** @type {HTMLElement} */ parent, /** @type {string} */ kind, /** @type {string} */ text) => {
    const made = parent.appendChild(document.createElement(kind));
    made.textContent = text;
    return made;
  };
  const drawPackets = packets(part(to, "figure", ""), value);
  const handle = (/** @type {number} */ n) => (n === 1 ? -HANDLE : HANDLE);
  const lanes = LAWS.map(({ id, name, why }, at) => {
    const lane = part(to, "article", "");
    lane.className = "lane";
    lane.id = `lane-${id}`;
    const words = part(lane, "div", "");
    part(words, "h2", `${at + 1} ${name}`);
    const state = part(words, "p", "–");
    state.className = "state";
    part(words, "p", why).className = "why";
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    put(svg, { viewBox: "-166 -28 332 50", role: "group", "aria-label": `Both copies and both hands under ${name}` });
    lane.append(svg);
    make(svg, "line", { class: "ground", x1: -166, y1: 20, x2: 166, y2: 20 });
    const peers = [1, 2].map((n) => ({
      copy: make(svg, "rect", { class: `p${n}`, x: -18, y: -14, width: 36, height: 34, rx: 2 }),
      device: make(svg, "circle", { class: `p${n}`, r: 6 }),
      push: make(svg, "line", { class: `p${n} push` }),
      pull: make(svg, "line", { class: `p${n}` }),
    }));
    const gap = make(svg, "path", { class: "gap" });
    return { id, lane, state, svg, peers, gap };
  });
  /** @param {string} id @param {number} [ago] */
  const apart = (id, ago = 0) => 1e3 * Math.abs(value(`object_1_${id}`, ago) - value(`object_2_${id}`, ago));
  /** How a lane went since the start, by what the program measured in every tick: a page may be opened late. @param {string} id @returns {State | undefined} */
  function stateOf(id) {
    const name = id === "wave" ? "passive wave" : id === "timed" ? "self-timed" : id;
    const [fault, lasted, worst] = [value(`fault_${id}`), value(`lasted_${id}`), 1e3 * value(`worst_${id}`)];
    if (fault > 0) {
      const text = `✗ stopped after ${lasted.toFixed(1)} s at peer ${value(`faulted_${id}`)}: ${plainly(fault, faults)}`;
      return { text, short: `${name} stopped`, bad: true };
    }
    if (!(lasted > 0 && Number.isFinite(worst))) return undefined;
    if (worst <= TOGETHER_MM) {
      const text = `✓ held together for all ${lasted.toFixed(0)} s since the start: ${mm(worst)} at most`;
      return { text, short: `${name} held`, bad: false };
    }
    const ago = (lasted - value(`worst_at_${id}`)).toFixed(0);
    return {
      text: `✗ came apart: ${mm(worst)} at most, ${ago} s ago. Now ${mm(apart(id))}.`,
      short: `${name} came apart`,
      bad: true,
    };
  }
  /** @type {(State | undefined)[]} */
  let states = [];
  function tell() {
    drawPackets(true);
    states = lanes.map(({ id }) => stateOf(id));
    for (const [at, { lane, state }] of lanes.entries()) {
      const now = states[at];
      write(state, now?.text ?? "–");
      lane.classList.toggle("torn", now?.bad === true);
      lane.classList.toggle("holds", now?.bad === false);
    }
  }
  return {
    box: "-166 -28 332 50",
    flat: true,
    stages: lanes.map(({ svg }) => svg),
    toScene: ([x]) => [1e3 * x + handle(me), 0],
    fromScene: ([x]) => [(x - handle(me)) / 1e3, 0, 0],
    hand: `wanted_${me}`,
    own: (picture) => [value(`device_${me}_${LAWS[picture]?.id ?? "timed"}`), 0, 0],
    draw: () => {
      drawPackets();
      for (const { id, peers, gap } of lanes) {
        for (const [index, { copy, device, push, pull }] of peers.entries()) {
          const n = index + 1;
          const x = 1e3 * value(`device_${n}_${id}`) + handle(n);
          const [newton, wanted] = [value(`push_${n}`), 1e3 * value(`wanted_${n}`) + handle(n)];
          const live = !(value(`fault_${id}`) > 0);
          move(copy, [1e3 * value(`object_${n}_${id}`), 0]);
          move(device, [x, 0]);
          // 10 mm a newton, from outside onto the hand.
          push.toggleAttribute("hidden", !live || !Number.isFinite(x + newton));
          if (Number.isFinite(x + newton)) {
            const from = x - 6 * Math.sign(newton);
            put(push, { x1: (from - 10 * newton).toFixed(2), x2: from.toFixed(2), y1: 0, y2: 0 });
          }
          pull.toggleAttribute("hidden", !live || !Number.isFinite(x + wanted));
          if (Number.isFinite(x + wanted)) put(pull, { x1: x.toFixed(2), x2: wanted.toFixed(2), y1: 0, y2: 0 });
        }
        const [one, two] = [1e3 * value(`object_1_${id}`), 1e3 * value(`object_2_${id}`)];
        if (Number.isFinite(one + two))
          put(gap, { d: `M${one.toFixed(2)} -18v-8M${two.toFixed(2)} -18v-8M${one.toFixed(2)} -22H${two.toFixed(2)}` });
      }
    },
    slowly: tell,
    status: () => {
      const known = states.flatMap((state) => state ?? []);
      return [known.map(({ short }) => short).join(", ") || "starting", known.some(({ bad }) => bad)];
    },
    numbers: [["pushes of hands 1, 2", () => `${text(value("push_1"), 2)}, ${text(value("push_2"), 2)} N`]],
    strips: LAWS.map(({ id, name }, at) =>
      strip(`apart-${id}`, `Copies apart, ${at + 1} ${name}`, "mm", [1], () => ["true", (ago) => apart(id, ago)]),
    ),
    help: "The same two simulated hands push the object from both sides in all three lanes (lines beside a hand: 10 mm are 1 N), and the same packets are lost. A lane's verdict keeps the worst since the start. Drag the ring: your hand holds all three at once.",
  };
}
