// @ts-check
// One window: asks once a frame for what came since, tells where the hand is wanted, draws. No build step and no library; types are
// in comments. What columns, keys, scenes and faults there are, the program says first of all ("hello").

import { view as viewOf } from "./environments.js";
import { laws } from "./laws.js";
import { along, axesOf, peers, SUFFIXES, WAYS } from "./pair.js";

/** @typedef {import("./environments.js").Place} Place */
/** @typedef {import("./environments.js").Point} Point */
/** @typedef {import("./environments.js").Strip} Strip */
/** @typedef {import("./environments.js").View} View */
/** @typedef {{ name: string, unit: string, means: string }} Column */
/** @typedef {{ environments: { name: string, columns: Column[], more: any }[], header_bytes: number, faults: Record<string, string>, fault_base: number, waits: number,
 *   other: string | null, boards: boolean, clicks: { name: string, order: string }[], laws: string[], partners: string[], reach_m: number, period_s: number }} Hello */
/** @typedef {{ stable: boolean | null, text: string, not_judged: string[] }} Finding */
/** @typedef {{ settings: Record<string, string>, changed: [string, string][], one_way_s: number, finding: Finding | null }} Holds */
/** @typedef {{ line: string, text: string, instead: string | null }} Question */
/** @typedef {{ number: number, fault: string | null, told: { name: string, there: boolean, status: string, said: [string, string][] } }} Board */

/** @param {string} id @returns {HTMLElement} */
const element = (id) => {
  const found = document.getElementById(id);
  if (!found) throw new Error(`no #${id}`);
  return found;
};
const input = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (element(id));
const choice = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (element(id));
const still = matchMedia("(prefers-reduced-motion: reduce)");

/** The environment that shows three laws side by side. */
const STORY = "bad-network";
/** Samples that are kept: 16 s. */
const KEPT = 16384;
/** No sample yet: everything that the program has. */
const NOTHING = 0xffffffff;

/** What stands behind the "#" of an address: the keys of a run, each with its role, and behind a "/" the scene that a link carries.
 * @param {string} link */
function carried(link) {
  const [ring = "", ...rest] = link.slice(link.indexOf("#") + 1).split("/");
  try {
    return { ring, order: decodeURIComponent(rest.join("/")) };
  } catch {
    return { ring, order: "" };
  }
}
let { ring, order: first } = carried(location.hash);
// What a role lets a window do the program checks; here it says what to offer.
const roles = ring.split("+").map((key) => key.split("-")[0] ?? "");
const me = roles.includes("hand2") ? 2 : 1;
const hasHand = roles.includes(`hand${me}`);
const operates = roles.includes("operator");
const side = me === 1 ? -38 : 38;

/** @type {Hello | undefined} */
let hello;
/** @type {Holds | undefined} */
let holds;
/** @type {Map<string, number>} */
const columns = new Map();
let width = 1;
let samples = new Float32Array(0);
/** Tick after the newest sample. */
let next = NOTHING;
/** Where the hand is wanted, m, along, across and up; NaN: let go. @type {Place} */
let wanted = [NaN, NaN, NaN];
/** Pointer less hand when it was taken, in the drawing, and in which picture of it. @type {Point} */
let offset = [0, 0];
let picture = 0;
/** Which environment is shown, and what it draws; two peers along one axis are drawn here. */
let kind = -1;
/** Axes along which two peers share what is shown; 0: something else is shown. */
let axes = 1;
let cut = false;
/** @type {View} */
let shown;
let restarts = 0;
let frames = 0;
let asked = 0;
let waiting = false;
/** @type {WebSocket | undefined} */
let socket;

/** A column's value. @param {string} name @param {number} [ago] ticks */
const value = (name, ago = 0) => samples[((next - 1 - ago) & (KEPT - 1)) * width + (columns.get(name) ?? NaN)] ?? NaN;

// --- the line to the program ---

function connect() {
  socket = new WebSocket(`ws://${location.host}/ws/${ring}`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => (typeof data === "string" ? told(JSON.parse(data)) : take(data));
  socket.onclose = ({ wasClean }) => {
    letGo();
    hello = undefined;
    const why = wasClean
      ? "closed: another window took this hand, or the program has ended; reload to try again"
      : "no connection";
    say(`${why}${wasClean ? "" : ": is the program running?"}`, true);
    if (!wasClean) setTimeout(connect, 1000);
  };
}

/** @param {{ hello?: Hello, holds?: Holds, refused?: string, ask?: Question, boards?: Board[] }} message */
function told(message) {
  if (message.boards) {
    message.boards.forEach(showBoard);
    return;
  }
  if (message.hello) greeted(message.hello);
  if (message.holds) show(message.holds);
  if (message.refused !== undefined) element("refused").textContent = message.refused;
  if (message.ask) question(message.ask);
  if (!message.hello) answered(message);
}

/** @param {Hello} greeting */
function greeted(greeting) {
  hello = greeting;
  fill(
    choice("environment"),
    greeting.environments.map(({ name }) => name),
  );
  showKind(0);
  [next, waiting] = [NOTHING, false];
  for (const part of document.querySelectorAll("[data-here]"))
    part.toggleAttribute("hidden", greeting.other !== null || greeting.boards);
  for (const part of document.querySelectorAll("[data-play], [data-verdict]")) part.toggleAttribute("hidden", greeting.boards);
  element("boards").hidden = !greeting.boards;
  hand.toggleAttribute("hidden", !hasHand || greeting.boards);
  element("apart-name").textContent = greeting.other === null ? "copies apart (true)" : "copies apart (as last told)";
  fill(choice("law"), greeting.laws);
  fill(choice("partner"), greeting.partners);
  element("clicks").replaceChildren(
    ...greeting.clicks.map(({ name, order }) => {
      const button = document.createElement("button");
      [button.type, button.textContent] = ["button", name];
      button.addEventListener("click", () => ask(order));
      return button;
    }),
  );
  for (const control of document.querySelectorAll("[data-operator], [data-operator] :is(button, input, select)"))
    control.toggleAttribute("disabled", !operates);
  if (first) follow(first);
  first = "";
}

/** Shows another environment: nothing of the one before is kept. @param {number} number */
function showKind(number) {
  const environment = hello?.environments[number];
  if (!environment) return;
  kind = number;
  scene.append(hand);
  columns.clear();
  for (const [at, { name }] of environment.columns.entries()) columns.set(name, at);
  // A sample is what the columns say, and behind them the count of starts.
  columns.set("restarts", environment.columns.length);
  width = environment.columns.length + 1;
  samples = new Float32Array(KEPT * width).fill(NaN);
  paused = undefined;
  element("pause").setAttribute("aria-pressed", "false");
  picture = 0;
  letGo();
  lags.length = 0;
  const group = /** @type {SVGElement} */ (/** @type {unknown} */ (element("other")));
  axes = axesOf(environment.name);
  const other = viewOf(environment.name, group, value, me, environment.more);
  const several = axes > 1 ? { ...peers(group, value, me, axes), strips: pairStrips(axes) } : undefined;
  const story = environment.name === STORY ? laws(element("lanes"), value, me, hello?.faults ?? {}) : undefined;
  document.body.classList.toggle("story", Boolean(story));
  element("story").textContent = story ? "Back to one object" : "Three laws, one bad network";
  shown = other ?? several ?? story ?? (hello?.boards ? { ...pair, strips: BOARD_STRIPS } : pair);
  element("pair").toggleAttribute("hidden", axes !== 1);
  element("pair-numbers").hidden = axes === 0;
  element("help").textContent = `${shown.help} ${KEYS}`;
  scene.setAttribute("viewBox", shown.box);
  shown.stages?.forEach(takePointers);
  if (shown.stages) [picture] = [shown.stages.length - 1];
  (shown.stages?.at(-1) ?? scene).append(hand);
  element("more-numbers").replaceChildren(
    ...shown.numbers.map(([name]) => {
      const part = document.createElement("div");
      const [term, number] = ["dt", "dd"].map((kind) => part.appendChild(document.createElement(kind)));
      if (term && number) [term.textContent, number.textContent] = [name, "–"];
      return part;
    }),
  );
  for (const part of document.querySelectorAll("[data-verdict]"))
    part.toggleAttribute("hidden", Boolean(axes === 0 || hello?.boards));
  if (document.activeElement !== choice("environment")) choice("environment").selectedIndex = number;
  buildStrips(shown.strips);
}

/** @param {HTMLSelectElement} select @param {string[]} names */
const fill = (select, names) => select.replaceChildren(...names.map((name) => new Option(name)));

/** @param {ArrayBuffer} bytes */
function take(bytes) {
  waiting = false;
  if (!hello) return;
  const view = new DataView(bytes);
  const first = view.getUint32(0, true);
  const rows = new Float32Array(bytes, hello.header_bytes);
  const count = rows.length / width;
  if (view.getUint8(18) !== kind) showKind(view.getUint8(18));
  else if (first !== next) samples.fill(NaN);
  for (let row = 0; row < count; row++) {
    samples.set(rows.subarray(row * width, (row + 1) * width), ((first + row) & (KEPT - 1)) * width);
  }
  next = first + count;
  if (value("restarts") !== restarts) {
    restarts = value("restarts");
    letGo();
  }
  const late = [view.getUint32(4, true), view.getUint32(8, true) / 1000];
  element("late").textContent = `${late[0]}, ${late[1]?.toFixed(1)} ms`;
  report(
    [view.getUint8(12), view.getUint8(13)],
    [view.getUint8(14), view.getUint8(15)],
    view.getUint8(16) !== 0,
    view.getUint8(17),
  );
}

/** @param {number[]} modes @param {number[]} people @param {boolean} isCut @param {number} partner */
function report(modes, people, isCut, partner) {
  cut = isCut;
  const { faults = {}, fault_base = 100, partners = [], waits, other = null, boards = false } = hello ?? {};
  const fault = modes.findIndex((mode) => mode > fault_base);
  const there = people[2 - me];
  element("cut").setAttribute("aria-pressed", `${cut}`);
  element("cut").textContent = cut ? "Join the cable" : "Cut the cable";
  element("cut-mark").toggleAttribute("hidden", !cut);
  const select = choice("partner");
  if (document.activeElement !== select) select.selectedIndex = partner;
  if (boards) sayBoards(modes);
  else if (fault >= 0) say(`peer ${fault + 1} stopped: ${faults[(modes[fault] ?? 0) - fault_base]}. Press Start.`, true);
  else if (modes.some((mode) => mode === waits)) say(`waiting for ${other}`, true);
  else if (modes.includes(0)) say("stopped: motors are off. Press Start.", true);
  else if (cut) say("the cable is cut", true);
  else if (shown.status) say(...shown.status());
  else if (!hasHand) say(operates ? "you are the operator" : "you watch", false);
  else if (other !== null) say(`${other} has the other hand`, false);
  else if (there) say("another person has the other hand", false);
  else if (axes > 0) say(`the partner has the other hand: ${partners[partner]}`, false);
  else say("the program has the other hands", false);
}

function askForMore() {
  // One question at a time: a slow line makes fewer pictures, not a queue of them.
  if (!hello || socket?.readyState !== WebSocket.OPEN || (waiting && performance.now() - asked < 1000)) return;
  const bytes = new DataView(new ArrayBuffer(20));
  bytes.setUint32(0, next, true);
  for (const [axis, at] of wanted.entries()) bytes.setFloat32(4 + 4 * axis, hasHand ? at : NaN, true);
  bytes.setUint32(16, restarts, true);
  socket.send(bytes);
  [waiting, asked] = [true, performance.now()];
}

/** @param {string} text @param {boolean} bad */
function say(text, bad) {
  const status = element("status");
  if (status.textContent !== text) status.textContent = text;
  status.classList.toggle("bad", bad);
}

// --- the scene ---

const scene = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (element("scene")));
const hand = element("hand");
for (let mm = -120; mm <= 120; mm += 20) {
  const tick = document.createElementNS("http://www.w3.org/2000/svg", "path");
  tick.setAttribute("d", `M${mm} 32v${mm % 60 === 0 ? 4 : 2}`);
  element("ticks").append(tick);
}

/** @param {string} id @param {number} metres */
const move = (id, metres) => {
  if (Number.isFinite(metres)) element(id).setAttribute("transform", `translate(${(1e3 * metres).toFixed(3)} 0)`);
};

/** An arrow of 10 mm a newton. @param {number} x @param {number} y @param {number} newton */
const arrow = (x, y, newton) => {
  const length = 10 * Math.max(-12, Math.min(12, newton));
  if (!(Math.abs(length) > 0.3)) return "";
  const head = Math.sign(length) * Math.min(4, Math.abs(length));
  return `M${x} ${y - 1}h${length - head}v-2l${head} 3l${-head} 3v-2h${head - length}z`;
};

function drawScene() {
  for (const n of [1, 2]) {
    const x = n === 1 ? -38 : 38;
    for (const [part, name] of [
      ["copy", "object"],
      ["device", "device"],
    ]) {
      element(`${part}${n}`).toggleAttribute("hidden", !Number.isFinite(value(`${name}_${n}`)));
    }
    const device = 1e3 * value(`device_${n}`);
    const to = 1e3 * value(`wanted_${n}`) + x;
    move(`copy${n}`, value(`object_${n}`));
    move(`device${n}`, value(`device_${n}`));
    const [line, end] = element(`pull${n}`).children;
    element(`pull${n}`).toggleAttribute("hidden", !Number.isFinite(to));
    if (Number.isFinite(to) && Number.isFinite(device)) {
      line?.setAttribute("x1", `${device + x}`);
      line?.setAttribute("x2", `${to}`);
      end?.setAttribute("cx", `${to}`);
    }
    element(`arrow${n}`).setAttribute("d", arrow(device + x, n === 1 ? -20 : -12, value(`hand_${n}`)));
    element(`spring${n}`).setAttribute("d", arrow(1e3 * value(`object_${n}`), n === 1 ? 20 : 27, value(`coordination_${n}`)));
  }
  const [one, two] = [1e3 * value("object_1"), 1e3 * value("object_2")];
  if (Number.isFinite(one - two)) {
    element("gap").lastElementChild?.setAttribute("d", `M${one} -16v-14M${two} -16v-14M${one} -28H${two}`);
    element("gap-mm").textContent = Math.abs(one - two).toFixed(2);
  }
}

/** The ring of the own hand: where it is wanted, or where the device is. */
function drawHand() {
  const [x, y] = shown.toScene(holding() ? wanted : shown.own(picture), picture);
  if (!Number.isFinite(x + y)) return;
  hand.setAttribute("cx", `${x}`);
  hand.setAttribute("cy", `${y}`);
}

const holding = () => Number.isFinite(wanted[0]);

/** Where a pointer is in a drawing. @param {SVGSVGElement} stage @param {PointerEvent} event @returns {Point} */
const pointed = (stage, event) => {
  const matrix = stage.getScreenCTM();
  return matrix ? [(event.clientX - matrix.e) / matrix.a, (event.clientY - matrix.f) / matrix.d] : [NaN, NaN];
};
function letGo() {
  wanted = [NaN, NaN, NaN];
  moved = undefined;
}

/** From pointer to picture, ms: what the last moves took from their event to the frame that draws the hand on its way. */
const lags = /** @type {number[]} */ ([]);
/** A move that is waited for: when it was, and where the hand was then. @type {[number, number] | undefined} */
let moved;

/** @param {number} now ms */
function measureLag(now) {
  if (!moved || !(Math.abs(value(shown.hand) - moved[1]) > 0)) return;
  lags.push(now - moved[0]);
  if (lags.length > 1000) lags.shift();
  moved = undefined;
}

/** The time within which this share of the last moves was drawn, ms. @param {number} share */
const lag = (share) => lags.toSorted((a, b) => a - b)[Math.floor(share * (lags.length - 1))] ?? NaN;
hand.toggleAttribute("hidden", !hasHand);
/** Takes the hand by what points into this drawing. @param {SVGSVGElement} stage */
function takePointers(stage) {
  stage.addEventListener("pointerdown", (event) => {
    if (!event.isPrimary || event.button !== 0 || !hasHand || hello?.boards) return;
    // A hand that is put elsewhere loses its focus, and lets go.
    if (hand.parentNode !== stage) stage.append(hand);
    stage.setPointerCapture(event.pointerId);
    hand.focus({ preventScroll: true });
    const [x, y] = pointed(stage, event);
    picture = shown.stages?.indexOf(stage) ?? shown.picture?.([x, y]) ?? 0;
    wanted = shown.own(picture);
    const at = shown.toScene(wanted, picture);
    offset = [x - at[0], y - at[1]];
    event.preventDefault();
  });
  stage.addEventListener("pointermove", (event) => {
    if (!stage.hasPointerCapture(event.pointerId) || !holding()) return;
    const [x, y] = pointed(stage, event);
    wanted = shown.fromScene([x - offset[0], y - offset[1]], wanted, picture);
    const was = value(shown.hand);
    if (Number.isFinite(was)) moved ??= [event.timeStamp, was];
  });
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) stage.addEventListener(kind, letGo);
}
takePointers(scene);
hand.addEventListener("blur", letGo);
document.addEventListener("visibilitychange", () => {
  letGo();
  askForMore();
});
hand.addEventListener("keydown", (event) => {
  const reach = shown.flat ? (hello?.reach_m ?? 0) : 0.2;
  // Where there is only along, up is forward.
  const forward = shown.fromScene([0, -1], [0, 0, 0], 0)[1];
  const up = shown.flat ? [0.002, 0, 0] : [0, 0.002 * Math.sign(forward), 0];
  const lift = [0, 0, axes === 3 ? 0.002 : 0];
  const steps = {
    ArrowLeft: [-0.002, 0, 0],
    ArrowRight: [0.002, 0, 0],
    ArrowUp: up,
    ArrowDown: up.map((part) => -part),
    ...(axes === 3 ? { PageUp: lift, PageDown: lift.map((part) => -part) } : {}),
  };
  const step = steps[/** @type {keyof typeof steps} */ (event.key)];
  const inside = (/** @type {number} */ at) => Math.max(-reach, Math.min(reach, at));
  if (step) {
    const [x, y, z] = holding() ? wanted : shown.own(picture);
    const far = event.shiftKey ? 5 : 1;
    wanted = [inside(x + far * (step[0] ?? 0)), inside(y + far * (step[1] ?? 0)), inside(z + far * (step[2] ?? 0))];
  } else if (event.key === "Home") wanted = [0, 0, 0];
  else if (event.key === "Escape") letGo();
  else return;
  event.preventDefault();
});

// --- numbers ---

/** Mean over the last ticks. @param {(ago: number) => number} of @param {number} [ticks] */
function mean(of, ticks = 200) {
  let sum = 0;
  for (let ago = 0; ago < ticks; ago++) sum += of(ago);
  return sum / ticks;
}
/** Distance of two places, mm. @param {string} one @param {string} other @param {number} ago */
const distance = (one, other, ago) => {
  // Plots ask for thousands a frame.
  if (axes === 1) return 1e3 * Math.abs(value(one, ago) - value(other, ago));
  const to = along(value, axes, other, ago);
  return 1e3 * Math.hypot(...along(value, axes, one, ago).map((at, axis) => at - (to[axis] ?? NaN)));
};
const apart = (/** @type {number} */ ago) => distance("object_1", "object_2", ago);
const decoded = (/** @type {number} */ ago) => distance(`object_${me}`, `decoded_${me}`, ago);
/** A force: along one axis with its sign, else its size. @param {string} name @param {number} ago */
const force = (name, ago) => (axes === 1 ? value(name, ago) : Math.hypot(...along(value, axes, name, ago)));

function writeNumbers() {
  const text = (/** @type {number} */ number, /** @type {number} */ digits) =>
    Number.isFinite(number) ? number.toFixed(digits) : "–";
  /** @param {string} id @param {number} digits @param {...number} numbers */
  const write = (id, digits, ...numbers) => {
    element(id).textContent = numbers.map((number) => text(number, digits)).join(", ");
  };
  const both = (/** @type {string} */ name, ticks = 200) => [1, 2].map((n) => mean((ago) => value(`${name}_${n}`, ago), ticks));
  const forces = (/** @type {string} */ name) => [1, 2].map((n) => mean((ago) => force(`${name}_${n}`, ago)));
  write("lag", 0, lag(0.5), lag(0.95));
  shown.slowly?.();
  if (axes === 0) {
    shown.numbers.forEach(([, of], at) => {
      const number = element("more-numbers").children[at]?.lastElementChild;
      if (number) number.textContent = of();
    });
    hand.setAttribute(
      "aria-valuetext",
      shown
        .own(picture)
        .slice(0, shown.flat ? 1 : 2)
        .map((at) => `${(1e3 * at).toFixed(0)} millimetres`)
        .join(", "),
    );
    return;
  }
  write("true", 3, mean(apart));
  write("decoded", 3, mean(decoded));
  write("forces", 2, ...forces("hand"));
  write("coordination", 2, ...forces("coordination"));
  write("line", 2, 1e3 * value("line"));
  write("kept", 2, 1e3 * value("kept_1"), 1e3 * value("kept_2"));
  write("trip", 1, 1e3 * (value("delay_1") + value("delay_2")));
  write("live", 0, ...both("live", 1000).map((share) => 100 * share));
  const at = 1e3 * value(`device_${me}`);
  if (Number.isFinite(at)) {
    hand.setAttribute("aria-valuenow", at.toFixed(0));
    const places = along(value, axes, `device_${me}`).map((at) => `${(1e3 * at).toFixed(0)} millimetres`);
    hand.setAttribute("aria-valuetext", `${places.join(", ")}, ${force(`hand_${me}`, 0).toFixed(1)} newtons`);
  }
}

// --- plots ---

/** What is plotted of two peers: places along each axis, of forces their size where there are several.
 * @param {number} axes @returns {Strip[]} */
const pairStrips = (axes) => [
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
      { name: "in the line", of: (ago) => 1e3 * value("line", ago) },
      ...[1, 2].map((n) => ({ name: `kept by peer ${n}`, of: (/** @type {number} */ ago) => 1e3 * value(`kept_${n}`, ago) })),
    ],
  },
];
/** Of boards the devices are what is always known. @type {Strip[]} */
const BOARD_STRIPS = pairStrips(1).map((strip) =>
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
/** Ticks that a strip shows. */
let span = 4000;
/** The samples as they were when the plots were paused, and the tick after them. @type {{ samples: Float32Array<ArrayBuffer>, next: number } | undefined} */
let paused;
/** Where the cursor is, as a share of the width. */
let cursor = NaN;
/** @type {Map<string, [number, number]>} what each strip shows, which shrinks slowly */
const ranges = new Map();

/** Draws or exports from what was there at the pause. @template T @param {() => T} work @returns {T} */
function withShown(work) {
  if (!paused) return work();
  const now = { samples, next };
  ({ samples, next } = paused);
  try {
    return work();
  } finally {
    ({ samples, next } = now);
  }
}

/** @param {Strip[]} strips */
function buildStrips(strips) {
  element("strips").replaceChildren();
  ranges.clear();
  strips.forEach(buildStrip);
}

/** @param {Strip} strip */
function buildStrip({ id, title, unit, series }) {
  const [figure, caption, canvas] = ["figure", "figcaption", "canvas"].map((kind) => document.createElement(kind));
  if (!figure || !caption || !canvas) return;
  caption.append(`${title}, ${unit}: `);
  series.forEach(({ name }, at) => {
    const legend = document.createElement("b");
    [legend.className, legend.textContent] = [`c${at + 1}`, `${["━", "┅", "•", "╌"][at]} ${name} `];
    caption.append(legend);
  });
  canvas.id = id;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${title} over the last seconds; arrow keys move a cursor`);
  const at = (/** @type {PointerEvent} */ event) => (cursor = event.offsetX / canvas.clientWidth);
  canvas.addEventListener("pointermove", at);
  canvas.addEventListener("pointerdown", at);
  canvas.addEventListener("pointerleave", () => (cursor = NaN));
  canvas.addEventListener("blur", () => (cursor = NaN));
  canvas.addEventListener("keydown", ({ key }) => {
    const step = { ArrowLeft: -0.01, ArrowRight: 0.01 }[key];
    if (step) cursor = Math.max(0, Math.min(1, (Number.isFinite(cursor) ? cursor : 1) + step));
  });
  figure.append(caption, canvas);
  element("strips").append(figure);
}

/** Lowest and highest of a series in each of so many columns, the last sample of the column before included: nothing of 1 ms is lost.
 * @param {(ago: number) => number} of @param {number} pixels @returns {[number, number][]} */
function extremes(of, pixels) {
  let last = NaN;
  return Array.from({ length: pixels }, (_, x) => {
    let [low, high] = [last, last];
    const end = Math.floor(((pixels - x - 1) * span) / pixels);
    for (let ago = Math.floor(((pixels - x) * span) / pixels); ago > end; ago--) {
      last = of(ago - 1);
      if (!(low <= last)) low = last;
      if (!(high >= last)) high = last;
    }
    return [low, high];
  });
}

/** A custom property is no colour yet (`light-dark(…)` stays as it is written); what an element has of it is. @param {number} at */
const colour = (at) => getComputedStyle(element("strips").querySelector(`.c${at + 1}`) ?? element("strips")).color;

/** @param {Strip} strip */
function draw({ id, series }) {
  const canvas = /** @type {HTMLCanvasElement} */ (element(id));
  const context = canvas.getContext("2d");
  if (!context) return;
  const ratio = devicePixelRatio || 1;
  const [wide, high] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  const lines = series.map(({ of }) => extremes(of, wide));
  const all = lines.flat(2).filter(Number.isFinite);
  const before = ranges.get(id) ?? [0, 0];
  const least = Math.min(0, 0.95 * before[0], ...minmax(all));
  const most = Math.max(1e-3, 0.95 * before[1], ...minmax(all));
  ranges.set(id, [least, most]);
  const y = (/** @type {number} */ number) => high - 2 * ratio - ((number - least) / (most - least)) * (high - 4 * ratio);
  context.clearRect(0, 0, wide, high);
  context.fillStyle = getComputedStyle(canvas).borderTopColor;
  context.fillRect(0, y(0), wide, ratio);
  lines.forEach((line, at) => {
    context.fillStyle = colour(at);
    line.forEach(([low, top], x) => {
      if (low <= top) context.fillRect(x, y(top), ratio, Math.max(1.5 * ratio, y(low) - y(top)));
    });
  });
  context.fillStyle = getComputedStyle(canvas).color;
  context.font = `${12 * ratio}px system-ui`;
  context.fillText(most.toPrecision(3), 4 * ratio, 12 * ratio);
  if (least < 0) context.fillText(least.toPrecision(3), 4 * ratio, high - 4 * ratio);
  if (Number.isFinite(cursor)) context.fillRect(cursor * wide, 0, ratio, high);
}

/** @param {number[]} numbers @returns {number[]} */
function minmax(numbers) {
  if (numbers.length === 0) return [];
  let [least, most] = [Infinity, -Infinity];
  for (const number of numbers) {
    least = Math.min(least, number);
    most = Math.max(most, number);
  }
  return [least, most];
}

function writeCursor() {
  const ago = Math.round((1 - cursor) * span);
  element("cursor").textContent = Number.isFinite(cursor)
    ? `${(-1e-3 * ago).toFixed(3)} s: ${shown.strips
        .map(({ unit, series }) => series.map(({ name, of }) => `${name} ${of(ago).toFixed(2)} ${unit}`).join(", "))
        .join("; ")}`
    : "";
}

/** @param {number} factor */
const zoom = (factor) => {
  span = Math.max(250, Math.min(16000, span * factor));
  element("span").textContent = `${span / 1000} s`;
};
element("closer").addEventListener("click", () => zoom(0.5));
element("farther").addEventListener("click", () => zoom(2));
element("pause").addEventListener("click", () => {
  paused = paused ? undefined : { samples: samples.slice(), next };
  element("pause").setAttribute("aria-pressed", `${Boolean(paused)}`);
});

/** Hands a file to the person. @param {string} name @param {Blob} blob */
function download(name, blob) {
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(blob), name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Every column of what is shown, a row a tick. */
function asCsv() {
  const own = hello?.environments[kind]?.columns ?? [];
  const counted = own.some(({ name }) => name === "restarts");
  const names = [...own, ...(counted ? [] : [{ name: "restarts", unit: "" }])].map(({ name, unit }) =>
    unit ? `${name}_${unit.toLowerCase()}` : name,
  );
  const rows = [["time_s", ...names].join(",")];
  for (let ago = span; ago > 0; ago--) {
    const numbers = [...columns.keys()].map((name) => value(name, ago - 1));
    // What was not there yet is no row; what is no number is empty.
    if (Number.isFinite(value("restarts", ago - 1))) {
      const time = ((next - ago) * (hello?.period_s ?? 0)).toFixed(3);
      rows.push([time, ...numbers.map((number) => (Number.isFinite(number) ? `${number}` : ""))].join(","));
    }
  }
  return `${rows.join("\n")}\n`;
}

/** The strips, one below the other. */
function asSvg() {
  const [wide, high, pixels] = [900, 150, 900];
  const strips = shown.strips.map(({ title, unit, series, id }, row) => {
    const [least, most] = ranges.get(id) ?? [0, 1];
    const y = (/** @type {number} */ number) =>
      (row * (high + 30) + 24 + high - ((number - least) / (most - least)) * high).toFixed(2);
    const paths = series.map(({ of }, at) => {
      const points = extremes(of, pixels).map(([low, top], x) => (low <= top ? `M${x} ${y(low)}V${y(top)}` : ""));
      return `<path d="${points.join("")}" stroke="${colour(at)}" stroke-width="1.5" stroke-linecap="round"/>`;
    });
    const names = series.map(({ name }, at) => `<tspan fill="${colour(at)}"> ${name} </tspan>`).join("");
    const top = row * (high + 30) + 16;
    return `<text x="0" y="${top}">${title}, ${unit} (${least.toPrecision(3)} to ${most.toPrecision(3)}), ${span / 1000} s:${names}</text>${paths.join("")}`;
  });
  const size = `width="${wide}" height="${shown.strips.length * (high + 30)}"`;
  return `<svg xmlns="http://www.w3.org/2000/svg" ${size} font-family="sans-serif" font-size="12">${strips.join("")}</svg>\n`;
}

element("csv").addEventListener("click", () => download("play.csv", new Blob([withShown(asCsv)], { type: "text/csv" })));
element("svg").addEventListener("click", () => download("play.svg", new Blob([withShown(asSvg)], { type: "image/svg+xml" })));
element("png").addEventListener("click", () => {
  const canvases = shown.strips.map(({ id }) => /** @type {HTMLCanvasElement} */ (element(id)));
  const whole = document.createElement("canvas");
  [whole.width, whole.height] = [canvases[0]?.width ?? 1, canvases.reduce((sum, { height }) => sum + height + 4, 0)];
  const context = whole.getContext("2d");
  if (!context) return;
  context.fillStyle = getComputedStyle(document.body).backgroundColor;
  context.fillRect(0, 0, whole.width, whole.height);
  let top = 0;
  for (const canvas of canvases) {
    context.drawImage(canvas, 0, top);
    top += canvas.height + 4;
  }
  whole.toBlob((blob) => blob && download("play.png", blob));
});

// --- settings ---

/** Orders that wait for the answer to the one before, by the control that gives them: of one control the newest counts.
 * @type {Map<string, string>} */
const pending = new Map();
let judging = false;

/** @param {string} order @param {string} [from] */
function ask(order, from = order) {
  element("refused").textContent = "";
  element("question").hidden = true;
  pending.set(from, order);
  sendNext();
}

function sendNext() {
  const first = pending.entries().next().value;
  if (judging || !first || socket?.readyState !== WebSocket.OPEN) return;
  pending.delete(first[0]);
  judging = true;
  socket.send(first[1]);
}

/** The answer to an order is what holds with a verdict, a question, or a refusal. @param {{ holds?: Holds }} message */
function answered({ holds: now }) {
  if (now && !now.finding) return;
  judging = false;
  sendNext();
}

/** @param {string} command */
const command = (command) => {
  if (socket?.readyState === WebSocket.OPEN) socket.send(command);
};

/** A control: the key it stands for, how its number becomes the range's, and how it is read.
 * @typedef {{ key: string, unit: string, to: (value: number) => number, from: (value: number) => number, digits: number }} Control */
const plain = (/** @type {number} */ scale) => ({
  to: (/** @type {number} */ x) => x * scale,
  from: (/** @type {number} */ x) => x / scale,
});
const decades = { to: Math.log10, from: (/** @type {number} */ x) => Number((10 ** x).toPrecision(3)) };
/** @type {Record<string, Control>} */
const CONTROLS = {
  delay: { key: "one way", unit: "ms", ...plain(1e3), digits: 0 },
  jitter: { key: "network.jitter_s", unit: "ms", ...plain(1e3), digits: 0 },
  loss: { key: "network.loss", unit: "%", ...plain(100), digits: 0 },
  burst: { key: "network.loss_burst_packets", unit: "packets", ...plain(1), digits: 0 },
  "lanes-loss": { key: "network.loss", unit: "%", ...plain(100), digits: 0 },
  "lanes-burst": { key: "network.loss_burst_packets", unit: "packets", ...plain(1), digits: 0 },
  stiffness: { key: "coordination.stiffness_n_per_m", unit: "N/m", ...decades, digits: 0 },
  impedance: { key: "coordination.wave_impedance_n_s_per_m", unit: "N·s/m", ...decades, digits: 1 },
  mass: { key: "object.mass_kg", unit: "kg", ...decades, digits: 3 },
};

/** What a range orders. @param {string} id @param {number} number in the key's unit */
function order(id, number) {
  const { key } = /** @type {Control} */ (CONTROLS[id]);
  if (id === "delay") return `set network.one_way_delay_packets=0 network.extra_delay_s=${number}`;
  if (id === "jitter") return `set network.jitter=${number > 0 ? "uniform" : "none"} ${key}=${number}`;
  return `set ${key}=${number}`;
}

/** @param {string} id @param {number} number */
function read(id, number) {
  const { to, unit, digits } = /** @type {Control} */ (CONTROLS[id]);
  const shown = unit === "ms" || unit === "%" ? to(number) : number;
  const text = element(id).nextElementSibling;
  if (text) text.textContent = `${shown.toFixed(digits)} ${unit}`;
  input(id).setAttribute("aria-valuetext", `${shown.toFixed(digits)} ${unit}`);
}

for (const [id, { from }] of Object.entries(CONTROLS)) {
  input(id).addEventListener("input", () => {
    const number = from(Number(input(id).value));
    read(id, number);
    ask(order(id, number), id);
  });
}
choice("environment").addEventListener("change", () => ask(`show ${choice("environment").value}`, "environment"));
choice("law").addEventListener("change", () => ask(`law ${choice("law").value}`, "law"));
input("one-sided").addEventListener("change", () => ask(`set contact.one_sided=${input("one-sided").checked}`, "one-sided"));
element("controls").addEventListener("submit", (event) => event.preventDefault());
choice("partner").addEventListener("change", () => command(`partner ${choice("partner").value}`));
element("stop").addEventListener("click", () => command("stop"));
element("start").addEventListener("click", () => command("start"));
element("again").addEventListener("click", () => command("start"));
element("story").addEventListener("click", () => ask(`show ${shown.stages ? "pair" : STORY}`, "environment"));
element("let-go").addEventListener("click", letGo);
element("cut").addEventListener("click", () => command(element("cut").getAttribute("aria-pressed") === "true" ? "join" : "cut"));

/** @param {Holds} now */
function show(now) {
  holds = now;
  for (const [id, { key, to }] of Object.entries(CONTROLS)) {
    const number = id === "delay" ? now.one_way_s : Number(now.settings[key]);
    if (pending.has(id) || !Number.isFinite(number)) continue;
    input(id).value = `${to(number)}`;
    read(id, number);
  }
  choice("law").value = (now.settings["coordination.comm"] ?? "").replaceAll('"', "");
  input("one-sided").checked = now.settings["contact.one_sided"] === "true";
  const verdict = element("verdict");
  const text = now.finding?.text ?? "judging";
  if (verdict.textContent !== text) verdict.textContent = text;
  verdict.classList.toggle("bad", now.finding?.stable === false);
  if (now.finding) element("not-judged").textContent = `Not judged: ${now.finding.not_judged.join("; ")}.`;
}

/** @param {Question} question */
function question({ line, text, instead }) {
  element("question-text").textContent = `This was not set: ${text}.`;
  element("question").hidden = false;
  const better = element("instead");
  better.hidden = instead === null || line.startsWith("file");
  better.textContent = `Set ${instead} as well`;
  const answer = (/** @type {string | undefined} */ order) => () => {
    element("question").hidden = true;
    if (order) ask(order);
  };
  better.onclick = answer(`${line} ${instead}`);
  element("anyway").textContent = "Set it anyway";
  element("anyway").onclick = answer(`anyway ${line}`);
  element("leave").onclick = answer(undefined);
  element("leave").focus({ preventScroll: true });
}

// --- boards ---

/** What is said to a board is a command, and a person confirms what turns its motors on. @param {number} number @param {string} line */
const toBoard = (number, line) => command(`board ${number} ${line}`);

/** @param {number} number */
function confirmArm(number) {
  element("question-text").textContent =
    `Arming turns the motors of board ${number} on. Is everybody clear of it, and the emergency stop in reach?`;
  element("question").hidden = false;
  element("instead").hidden = true;
  element("anyway").textContent = `Arm board ${number}`;
  element("anyway").onclick = () => {
    element("question").hidden = true;
    toBoard(number, "arm");
  };
  element("leave").onclick = () => (element("question").hidden = true);
  element("leave").focus({ preventScroll: true });
}

/** The card of a board, made when it is first heard of. @param {number} number */
function card(number) {
  const there = document.getElementById(`board${number}`);
  if (there) return there;
  const card = document.createElement("article");
  card.id = `board${number}`;
  const parts = ["h2", "p", "p", "div", "ul"].map((kind) => card.appendChild(document.createElement(kind)));
  for (const [at, name] of ["name", "status", "fault", "row", "said"].entries()) if (parts[at]) parts[at].className = name;
  /** @type {[string, () => void][]} */
  const buttons = [
    [`Arm board ${number}`, () => confirmArm(number)],
    ["Clear the fault", () => toBoard(number, "clear")],
    ["Check joint 1 (moves it)", () => toBoard(number, "check 1")],
    ["Check joint 2 (moves it)", () => toBoard(number, "check 2")],
  ];
  for (const [text, press] of buttons) {
    const button = document.createElement("button");
    [button.type, button.textContent, button.disabled] = ["button", text, !operates];
    button.addEventListener("click", press);
    parts[3]?.append(button);
  }
  element("boards").append(card);
  return card;
}

/** @param {Board} board */
function showBoard({ number, fault, told: { name, there, status, said } }) {
  const of = card(number);
  const write = (/** @type {string} */ part, /** @type {string} */ text) => {
    const place = of.querySelector(`.${part}`);
    if (place && place.textContent !== text) place.textContent = text;
  };
  write("name", name);
  write("status", there ? status : `not there: ${status}`);
  write("fault", fault ? `Stopped: ${fault}. When the cause is gone, clear the fault, then arm.` : "");
  const lines = said.map(([line, answer]) => {
    const item = document.createElement("li");
    item.textContent = `${line}: ${answer}`;
    return item;
  });
  of.querySelector(".said")?.replaceChildren(...lines);
}

/** @param {number[]} modes */
function sayBoards(modes) {
  const { fault_base = 100, waits } = hello ?? {};
  const which = (/** @type {(mode: number) => boolean} */ is) =>
    modes.flatMap((mode, at) => (document.getElementById(`board${at + 1}`) && is(mode) ? [at + 1] : [])).join(" and ");
  const [faulted, armed, away] = [
    which((mode) => mode > fault_base),
    which((mode) => mode === 1),
    which((mode) => mode === waits),
  ];
  if (faulted) say(`fault at board ${faulted}: its motors are off`, true);
  else if (armed) say(`the motors of board ${armed} are on; they go off when the operator's page is hidden or closed`, true);
  else if (away) say(`nothing is heard of board ${away}`, true);
  else say("all motors are off", false);
}

/** A scene file of what is not as usual. */
function asToml() {
  /** @type {Map<string, string[]>} */
  const tables = new Map();
  for (const [key, text] of holds?.changed ?? []) {
    const dot = key.lastIndexOf(".");
    const table = key.slice(0, dot);
    tables.set(table, [...(tables.get(table) ?? []), `${key.slice(dot + 1)} = ${text}`]);
  }
  const parts = [...tables].map(([table, lines]) => `[${table}]\n${lines.join("\n")}\n`);
  return `# A scene of host-sim play; host-sim cooperate --scene runs it too.\n\n${parts.join("\n")}`;
}
element("save").addEventListener("click", () => download("scene.toml", new Blob([asToml()], { type: "application/toml" })));
input("open").addEventListener("change", async () => {
  const file = input("open").files?.[0];
  if (file) ask(`file ${await file.text()}`, "file");
  input("open").value = "";
});
/** A link to this scene, for any run: it has no key. */
function asLink() {
  const keys = (holds?.changed ?? []).map(([key, text]) => `${key}=${text.replaceAll('"', "")}`).join(" ");
  return `${location.origin}/#/${encodeURIComponent(`scene default ${keys}`.trim())}`;
}

/** Asks for the scene that a link carries, and for nothing else that a page can order. @param {string} order */
function follow(order) {
  if (/^scene [\w.-]+( [\w.]+=\S+)*$/.test(order)) ask(order);
  else element("refused").textContent = "this link carries no scene";
}

element("link").addEventListener("click", async () => {
  const link = asLink();
  input("paste").value = link;
  input("paste").select();
  await navigator.clipboard?.writeText(link).catch(() => undefined);
});
element("paste-form").addEventListener("submit", (event) => {
  event.preventDefault();
  follow(carried(input("paste").value.trim()).order);
});
addEventListener("hashchange", () => {
  const { ring: other, order } = carried(location.hash);
  if (other && other !== ring) location.reload();
  else if (order) follow(order);
});

/** The pair, which everything above is about. @type {View} */
const pair = {
  box: "-160 -50 320 96",
  flat: true,
  toScene: ([x]) => [1e3 * x + side, 9],
  fromScene: ([x]) => [(x - side) / 1e3, 0, 0],
  hand: `wanted_${me}`,
  own: () => [value(`device_${me}`), 0, 0],
  draw: drawScene,
  numbers: [],
  strips: pairStrips(1),
  help: "Drag your hand with mouse, finger or pen. How far it is from its ring is your force: 5 mm are 1 N. Arrows: force of a hand (filled) and of the coordination (hollow), 10 mm are 1 N.",
};
const KEYS = "Keys: arrows move it by 2 mm, with Shift by 10; Home takes it to the middle, Escape lets go.";

// --- once a frame ---

let slow = 0;
/** @param {number} now ms */
function frame(now) {
  requestAnimationFrame(frame);
  askForMore();
  if (!hello || !shown) return;
  frames += 1;
  measureLag(now);
  shown.draw(cut);
  drawHand();
  slow += 1;
  if (slow % 12 === 0) writeNumbers();
  if (slow % (still.matches ? 30 : 2) === 0) {
    withShown(() => {
      shown.strips.forEach(draw);
      writeCursor();
    });
  }
}

const own = [...(hasHand ? [`hand ${me}`] : []), ...(operates ? ["operator"] : [])];
element("who").textContent = `– ${own.join(", ") || "watching"}`;
element("stop").toggleAttribute("disabled", own.length === 0);
input("paste").value = ring ? "" : location.href;
const environment = () => hello?.environments[kind]?.name;
Object.assign(window, { page: { value, environment, frames: () => frames, asCsv, asSvg, asToml, asLink, lag, command } });
if (ring) connect();
else say("this address names no run: paste it under “Open link” in a page that host-sim play has given you", true);
requestAnimationFrame(frame);
