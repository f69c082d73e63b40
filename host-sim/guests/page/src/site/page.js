// @ts-check
// One window: asks once a frame for what came since, tells where the hand is wanted, draws. No build step and no library; types are
// in comments. What columns, keys, scenes and faults there are, the program says first of all ("hello").

import { view as viewOf } from "./environments.js";
import { join, showJoin, showPeople } from "./join.js";
import { quantities } from "./numbers.js";
import { along, axesOf, boardStrips, pairStrips, peers } from "./pair.js";
import { choice, drawing, element, input, text, write } from "./parts.js";
import { fitStages, may, touched as byTouch } from "./phone.js";
import { download, Plots } from "./plots.js";
import { Samples } from "./samples.js";
import { pairScene } from "./scene.js";
import { settings } from "./settings.js";
import { plainly, sentence } from "./status.js";
import { pictures, story } from "./stories.js";
import { Timeline } from "./timeline.js";

/** @typedef {import("./environments.js").Place} Place */
/** @typedef {import("./environments.js").Point} Point */
/** @typedef {import("./environments.js").Strip} Strip */
/** @typedef {import("./environments.js").View} View */
/** @typedef {{ name: string, unit: string, means: string }} Column */
/** @typedef {{ environments: { name: string, story: boolean, columns: Column[], more: any }[], header_bytes: number, faults: Record<string, string>, fault_base: number, waits: number, alone: number,
 *   other: string | null, boards: boolean, clicks: { name: string, order: string }[], laws: string[], partners: string[], reach_m: number, period_s: number, recording?: Recorded }} Hello */
/** A recording: of how many ticks, from which time on, s, when that was, how far the copies were apart in each part of it, which columns it has
 * beside those of its environment, the tick at which it opens, and what happened.
 * @typedef {{ file: string, who: string, kind: number, ticks: number, start_s: number, unix_s: number, told: boolean, overview_mm: number[], columns: Column[],
 *   begin: number, marks: import("./timeline.js").Mark[], left_out: string | null }} Recorded */
/** @typedef {import("./settings.js").Holds} Holds */
/** @typedef {import("./settings.js").Question} Question */
/** @typedef {{ number: number, fault: string | null, told: { name: string, there: boolean, status: string, said: [string, string][] } }} Board */

/** The line to a partner elsewhere: the path or the round trip in words, what the line can hold, whether that is nothing, and whether this end is kept from arming by it.
 * @typedef {{ says: string, holds: string, bad: boolean, held: boolean }} Path */

const still = matchMedia("(prefers-reduced-motion: reduce)");

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
/** Whether this program has all that is shown, so that it can be set. */
const here = () => hello?.other === null && !hello.boards;
let { ring, order: first } = carried(location.hash);
// What a role lets a window do the program checks; here it says what to offer.
const roles = ring.split("+").map((key) => key.split("-")[0] ?? "");
const me = roles.includes("hand2") ? 2 : 1;
const hasHand = roles.includes(`hand${me}`);
const operates = roles.includes("operator");

/** @type {Hello | undefined} */
let hello;
const samples = new Samples();
/** Tick that is asked for next. */
let next = NOTHING;
/** What is drawn in the scene has changed though no sample has. */
let stale = true;
/** The newest of what was said of peers and people; another one is said. */
let standing = "";
/** Ticks that were late, and the worst of them. */
let late = "–";
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

/** A column's value, so many ticks before the moment that is shown. @param {string} name @param {number} [ago] */
const value = samples.value;
const period = () => hello?.period_s ?? 1e-3;
const timeline = new Timeline({
  samples,
  period,
  packet: () => Number(holds()?.settings["timing.ticks_per_packet"] ?? 1),
  span: () => plots.span,
  wake,
});
const plots = new Plots({
  samples,
  period,
  start: () => hello?.recording?.start_s ?? 0,
  whole: () => timeline.whole(),
  title: headings,
  file: () => hello?.recording?.file.replace(/\.mcap$/, "") || "play",
  seek: (tick) => timeline.seek(tick),
  key: timeline.key,
});

// --- the line to the program ---

/** @type {ReturnType<typeof join> | undefined} */
let line;
/** Why there is no line, and what is said of a Stop since which nothing has come. */
let [gone, unheard] = ["connecting", ""];
const sayGone = () => say(unheard ? `${unheard}. ${gone}` : gone, true);
const connect = () =>
  join(ring, {
    opened: (now) => {
      socket = now;
    },
    hear: (data) => {
      unheard = "";
      if (typeof data === "string") told(JSON.parse(data));
      else take(data);
    },
    lost: (why) => {
      letGo();
      hello = undefined;
      gone = why;
      sayGone();
    },
  });

/** @param {{ hello?: Hello, holds?: Holds, refused?: string, ask?: Question, boards?: Board[], join?: Parameters<typeof showJoin>[0], path?: Path }} message */
function told(message) {
  if (message.boards) {
    message.boards.forEach(showBoard);
    return;
  }
  if (message.join) {
    showJoin(message.join);
    return;
  }
  if (message.path) {
    showPath(message.path);
    return;
  }
  stale = true;
  if (message.hello) greeted(message.hello);
  if (message.holds) show(message.holds);
  if (message.refused !== undefined) element("refused").textContent = message.refused;
  if (message.ask) question(message.ask);
  if (!message.hello) answered(message);
}

/** Which way the line goes to the other home, how good it is, and what it can hold. @param {Path} path */
function showPath({ says, holds, bad, held }) {
  keptFromArming = held;
  const path = element("path");
  path.hidden = false;
  path.classList.toggle("bad", bad);
  write(path, holds ? `${says}; ${holds}` : says);
}

/** This end does not arm over so long a line. */
let keptFromArming = false;

/** @param {Hello} greeting */
function greeted(greeting) {
  hello = greeting;
  fill(
    choice("environment"),
    greeting.environments.filter(({ story }) => !story).map(({ name }) => name),
  );
  showKind(greeting.recording?.kind ?? 0);
  [next, waiting] = [NOTHING, false];
  for (const part of document.querySelectorAll("[data-here]"))
    part.toggleAttribute("hidden", greeting.other !== null || greeting.boards);
  for (const part of document.querySelectorAll("[data-play], [data-verdict]")) part.toggleAttribute("hidden", greeting.boards);
  element("boards").hidden = !greeting.boards;
  document.body.classList.toggle("recording", Boolean(greeting.recording));
  if (greeting.recording) opened(greeting.recording);
  hand.toggleAttribute("hidden", !hasHand || greeting.boards);
  element("apart-name").textContent =
    greeting.other === null && !greeting.recording?.told ? "copies apart" : "copies apart (as last told)";
  fill(choice("law"), greeting.laws);
  fill(choice("partner"), greeting.partners);
  element("clicks").replaceChildren(
    ...greeting.clicks.map(({ name, order }) => {
      const button = document.createElement("button");
      [button.type, button.textContent, button.title] = ["button", name, order];
      button.addEventListener("click", () => ask(order));
      return button;
    }),
  );
  for (const control of document.querySelectorAll("[data-operator], [data-operator] :is(button, input, select)"))
    control.toggleAttribute("disabled", !operates);
  if (first) follow(first);
  first = "";
}

/** Shows a recording, whose ticks are asked for as they are looked at. @param {Recorded} recording */
function opened(recording) {
  const { ticks, start_s, overview_mm, begin, marks } = recording;
  element("who").textContent = "– recorded";
  const ask = (/** @type {number} */ from, /** @type {number} */ count) => {
    const bytes = new DataView(new ArrayBuffer(8));
    bytes.setUint32(0, from, true);
    bytes.setUint32(4, count, true);
    socket?.send(bytes);
  };
  timeline.open({ ticks, start_s, overview_mm, begin, marks, ask });
}

/** Says whose recording it is, and which motors were off at the moment that is shown. @param {Recorded} recording */
function sayRecorded(recording) {
  const { file, who, left_out } = recording;
  const off = [1, 2].flatMap((peer) => {
    const fault = value(`fault_${peer}`);
    if (fault > 0) return [`peer ${peer} has stopped: ${plainly(fault, hello?.faults ?? {})}`];
    return value(`mode_${peer}`) === 0 ? [`the motors of peer ${peer} are off`] : [];
  });
  const whose = `${file}, of ${who}, ${dateOf(recording)}`;
  say([...off, whose, ...(left_out ? [left_out] : [])].join("; "), off.length > 0);
}

/** When a recording was begun. @param {Recorded} recording */
const dateOf = ({ unix_s }) => `${new Date(1e3 * unix_s).toISOString().slice(0, 16).replace("T", " ")} UTC`;

/** Shows another environment: nothing of the one before is kept. @param {number} number */
function showKind(number) {
  const environment = hello?.environments[number];
  if (!environment) return;
  kind = number;
  scene.append(hand);
  timeline.now();
  samples.begin([...environment.columns, ...(hello?.recording?.columns ?? [])]);
  stale = true;
  picture = 0;
  letGo();
  lags.length = 0;
  const group = drawing("other");
  axes = axesOf(environment.name);
  const other = viewOf(environment.name, group, value, me, environment.more);
  const several = axes > 1 ? { ...peers(group, value, me, axes), strips: stripsOf(axes) } : undefined;
  const told = story(environment.name, value, { me, faults: hello?.faults ?? {}, holds, past: () => timeline.past });
  if (!told) atWork = environment.name;
  shown = other ?? several ?? told ?? (hello?.boards ? { ...pair, strips: boardStrips(value, stripsOf(1)) } : pair);
  element("pair").toggleAttribute("hidden", axes !== 1);
  element("pair-numbers").hidden = axes === 0;
  // What only peers with a law have is there while they are.
  for (const part of document.querySelectorAll("[data-peers]"))
    part.toggleAttribute("hidden", (axes === 0 && environment.name !== "hub") || !here());
  element("help").textContent = byTouch.matches ? shown.help : `${shown.help} ${KEYS}`;
  scene.setAttribute("viewBox", shown.box);
  shown.stages?.forEach(takePointers);
  if (shown.stages) [picture] = [shown.stages.length - 1];
  (shown.stages?.at(-1) ?? scene).append(hand);
  fitStages(shown.stages ?? [scene], shown.flat && !shown.stages);
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
  if (document.activeElement !== choice("environment")) choice("environment").value = environment.name;
  plots.show(shown.strips);
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
  if (hello.recording) {
    // What does not go on from what is there is of another time.
    if (first !== samples.next) samples.forget();
    samples.take(first, rows, 0, true);
    stale = true;
    timeline.came();
    wake();
    return;
  }
  if (view.getUint8(18) !== kind) showKind(view.getUint8(18));
  samples.take(first, rows, performance.now());
  document.body.classList.toggle("untouched", !samples.touched && !hello.boards);
  next = samples.next;
  if (samples.moved >= first) wake();
  if (samples.newest("restarts") !== restarts) {
    restarts = samples.newest("restarts");
    letGo();
  }
  late = `${view.getUint32(4, true)}, ${(view.getUint32(8, true) / 1000).toFixed(1)} ms`;
  const now = new Uint8Array(bytes, 12, 8).join();
  if (now !== standing) stale = true;
  // How it stands is read from what is shown, which is not what is, while that is the past.
  else if (timeline.past) return;
  standing = now;
  report(
    [view.getUint8(12), view.getUint8(13)],
    [view.getUint8(14), view.getUint8(15)],
    view.getUint8(16) !== 0,
    view.getUint8(17),
  );
}

/** A peer has stopped itself: what is shown is its last moment. */
let stopped = false;

/** @param {number[]} modes @param {number[]} people @param {boolean} isCut @param {number} partner */
function report(modes, people, isCut, partner) {
  cut = isCut;
  const { faults = {}, fault_base = 100, partners = [], waits, other = null, boards = false } = hello ?? {};
  const far = Number(other?.match(/^peer ([12])/)?.[1] ?? 0);
  showPeople(people, hasHand ? me : 0, far);
  if (element("cut").getAttribute("aria-pressed") !== `${cut}`) {
    element("cut").setAttribute("aria-pressed", `${cut}`);
    element("cut").textContent = cut ? "Join the cable" : "Cut the cable";
  }
  const select = choice("partner");
  if (document.activeElement !== select) select.selectedIndex = partner;
  if (boards) {
    sayBoards(modes);
    return;
  }
  shown.told?.(modes, fault_base);
  const fault = modes.findIndex((mode) => mode > fault_base);
  stopped = fault >= 0;
  const hands = !hasHand
    ? operates
      ? "you are the operator"
      : "you watch"
    : other !== null
      ? `${other} has the other hand`
      : people[2 - me]
        ? "another person has the other hand"
        : axes > 0
          ? `the partner has the other hand: ${partners[partner]}`
          : "the program has the other hands";
  const [now, bad] = sentence({
    fault: fault < 0 ? undefined : { peer: fault + 1, why: plainly((modes[fault] ?? 0) - fault_base, faults) },
    waits: !modes.some((mode) => mode === waits)
      ? undefined
      : keptFromArming
        ? "a better line: this scene is unstable on it"
        : `${other}`,
    off: [1, 2].filter((peer) => modes[peer - 1] === 0),
    far,
    cut,
    told: timeline.past ? undefined : shown.status?.(),
    apart: axes > 0 && !timeline.past ? apart(0) : NaN,
    live: axes > 0 && !timeline.past ? measured.live() : [NaN, NaN],
    hands,
  });
  say(now, bad);
  // What stopped a peer, with the names of its keys; and a state that the verdict does not show.
  const seen =
    fault >= 0
      ? `Peer ${fault + 1} stopped: ${faults[(modes[fault] ?? 0) - fault_base] ?? "a fault"}.`
      : bad && axes > 0 && element("verdict").textContent?.startsWith("stable")
        ? `Seen now: ${now}. The verdict is about the settings, and leaves out what was not judged.`
        : "";
  write(element("seen"), seen);
}

/** Asks for what came since, and says where the hand is wanted. @param {boolean} [hidden] even of a page that is not seen */
function askForMore(hidden = false) {
  // One question at a time: a slow line makes fewer pictures, not a queue of them. Who does not look does not ask: motors of boards go off by that.
  if (
    (document.hidden && !hidden) ||
    !hello ||
    hello.recording ||
    socket?.readyState !== WebSocket.OPEN ||
    (waiting && performance.now() - asked < 1000)
  )
    return;
  const bytes = new DataView(new ArrayBuffer(20));
  bytes.setUint32(0, next, true);
  for (const [axis, at] of wanted.entries()) bytes.setFloat32(4 + 4 * axis, hasHand ? at : NaN, true);
  bytes.setUint32(16, restarts, true);
  socket.send(bytes);
  [waiting, asked] = [true, performance.now()];
  line?.asks();
}

/** @param {string} text @param {boolean} bad */
function say(text, bad) {
  const status = element("status");
  write(status, text);
  status.classList.toggle("bad", bad);
}

// --- the scene ---

const scene = drawing("scene");
const hand = element("hand");
/** Where the lens of the workshop stands. */
const GLASS = { x: -75, y: -66, width: 150, height: 38, most: 200 };
const both = pairScene(drawing("pair"), value, GLASS);

/** The ring of the own hand: where it is wanted, or where the device is. */
function drawHand() {
  const [x, y] = shown.toScene(holding() && !timeline.past ? wanted : shown.own(picture), picture);
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
  if (!moved || !(Math.abs(samples.newest(shown.hand) - moved[1]) > 0)) return;
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
    // What is taken is taken now.
    timeline.now();
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
    const was = samples.newest(shown.hand);
    if (Number.isFinite(was)) moved ??= [event.timeStamp, was];
  });
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) stage.addEventListener(kind, letGo);
}
takePointers(scene);
hand.addEventListener("blur", letGo);
document.addEventListener("visibilitychange", () => {
  letGo();
  askForMore(true);
  wake();
});
hand.addEventListener("keydown", (event) => {
  if (event.key !== "Tab") timeline.now();
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

const measured = quantities(
  value,
  me,
  () => axes,
  () => timeline.past || stopped,
);
const { apart, decoded, force } = measured;
element("pair-numbers").replaceChildren(...measured.parts);

const stripsOf = (/** @type {number} */ axes) => pairStrips(value, me, { apart, decoded, force }, axes);

function writeNumbers() {
  const tell = (/** @type {string} */ name, /** @type {string} */ text) => {
    if (hand.getAttribute(name) !== text) hand.setAttribute(name, text);
  };
  const lags = [0.5, 0.95].map((share) => text(lag(share), 0)).join(", ");
  write(element("lag"), lags);
  write(element("late"), late);
  shown.slowly?.();
  if (axes === 0) {
    shown.numbers.forEach(([, of], at) => {
      const number = element("more-numbers").children[at]?.lastElementChild;
      if (number) write(number, of());
    });
    tell(
      "aria-valuetext",
      shown
        .own(picture)
        .slice(0, shown.flat ? 1 : 2)
        .map((at) => `${(1e3 * at).toFixed(0)} millimetres`)
        .join(", "),
    );
    return;
  }
  measured.write();
  const at = 1e3 * value(`device_${me}`);
  if (Number.isFinite(at)) {
    tell("aria-valuenow", at.toFixed(0));
    const places = along(value, axes, `device_${me}`).map((at) => `${(1e3 * at).toFixed(0)} millimetres`);
    tell("aria-valuetext", `${places.join(", ")}, ${force(`hand_${me}`, 0).toFixed(1)} newtons`);
  }
}

// --- settings ---

/** Says something, if anybody listens. @param {string} text */
function speak(text) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(text);
  return true;
}
const { ask, answered, show, question, holds } = settings(speak);
/** @param {string} command */
const command = (command) => void speak(command);
choice("partner").addEventListener("change", () => command(`partner ${choice("partner").value}`));
element("stop").addEventListener("click", () => {
  const sent = speak("stop");
  unheard = sent
    ? "Stop may not have arrived: press the stop at the board or device"
    : "Stop was not sent: press the stop at the board or device";
  if (!sent) sayGone();
});
for (const id of ["start", "again", "stiff-again"]) element(id).addEventListener("click", () => command("start"));
element("let-go").addEventListener("click", letGo);
element("cut").addEventListener("click", () => command(element("cut").getAttribute("aria-pressed") === "true" ? "join" : "cut"));
/** The environment of the workshop that was shown last. */
let atWork = "pair";
pictures(
  (name) => ask(`show ${name}`, "environment"),
  () => atWork,
);

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
  const tell = (/** @type {string} */ part, /** @type {string} */ text) => {
    const place = of.querySelector(`.${part}`);
    if (place) write(place, text);
  };
  tell("name", name);
  tell("status", there ? status : `not there: ${status}`);
  tell("fault", fault ? `Fault: ${fault}. When the cause is gone, clear the fault, then arm.` : "");
  const lines = said.map(([line, answer]) => {
    const item = document.createElement("li");
    item.textContent = `${line}: ${answer}`;
    return item;
  });
  of.querySelector(".said")?.replaceChildren(...lines);
}

/** @param {number[]} modes */
function sayBoards(modes) {
  const { fault_base = 100, waits, alone } = hello ?? {};
  const which = (/** @type {(mode: number) => boolean} */ is) =>
    modes.flatMap((mode, at) => (document.getElementById(`board${at + 1}`) && is(mode) ? [at + 1] : [])).join(" and ");
  /** @type {[string, (of: string) => string][]} */
  const sentences = [
    [which((mode) => mode === waits), (of) => `the motors of board ${of} may be on: nothing is heard of it`],
    [which((mode) => mode === alone), (of) => `the motors of board ${of} are on without an operator: Stop turns them off`],
    [
      which((mode) => mode === 1),
      (of) => `the motors of board ${of} are on; they go off when the operator's page is hidden or closed`,
    ],
    [which((mode) => mode > fault_base), (of) => `fault at board ${of}: its motors are off`],
  ];
  // Cards come after the first picture.
  const said = element("boards").childElementCount
    ? sentences.flatMap(([of, text]) => (of ? [text(of)] : []))
    : ["waiting for the boards"];
  say(said.join(". ") || "all motors are off", said.length > 0);
}

/** A scene file of what is not as usual. */
function asToml() {
  /** @type {Map<string, string[]>} */
  const tables = new Map();
  for (const [key, text] of holds()?.changed ?? []) {
    const dot = key.lastIndexOf(".");
    const table = key.slice(0, dot);
    tables.set(table, [...(tables.get(table) ?? []), `${key.slice(dot + 1)} = ${text}`]);
  }
  const parts = [...tables].map(([table, lines]) => `[${table}]\n${lines.join("\n")}\n`);
  return `# A scene of cohold play; cohold cooperate --scene runs it too.\n\n${parts.join("\n")}`;
}
element("save").addEventListener("click", () => download("scene.toml", new Blob([asToml()], { type: "application/toml" })));
input("open").addEventListener("change", async () => {
  const file = input("open").files?.[0];
  if (file) ask(`file ${await file.text()}`, "file");
  input("open").value = "";
});
/** A link to this scene, for any run: it has no key. */
function asLink() {
  const keys = (holds()?.changed ?? []).map(([key, text]) => `${key}=${text.replaceAll('"', "")}`).join(" ");
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
  box: "-160 -68 320 114",
  flat: true,
  toScene: ([x]) => both.toScene(x, me),
  fromScene: ([x]) => [both.fromScene(x, me), 0, 0],
  hand: `wanted_${me}`,
  own: () => [value(`device_${me}`), 0, 0],
  draw: (isCut) => both.draw(isCut),
  numbers: [],
  strips: stripsOf(1),
  help: "Drag your hand (the ring) with mouse, finger or pen: its spring is your force, 5 mm are 1 N. Every arrow is a force, with whose it is; the bar on the right is as long as it says.",
};
const KEYS = "Keys: arrows move it by 2 mm, with Shift by 10; Home takes it to the middle, Escape lets go.";

/** What stands above what is exported: what is shown, then when, and in which scene. */
function headings() {
  const set = holds();
  const law = (set?.settings["coordination.comm"] ?? "").replaceAll('"', "");
  const delay = set && Number.isFinite(set.one_way_s) ? `, ${Number((1e3 * set.one_way_s).toPrecision(3))} ms one way` : "";
  const scene = (set?.changed ?? []).map(([key, text]) => `${key} = ${text.replaceAll('"', "")}`).join(", ");
  const when = hello?.recording ? dateOf(hello.recording) : `${new Date().toISOString().slice(0, 16).replace("T", " ")} UTC`;
  const of = hello?.boards || !law ? "" : `, law ${law}${delay}`;
  const whose = hello?.recording ? `${hello.recording.file}, of ${hello.recording.who}: ` : "";
  return [`${whose}${environment() ?? ""}${of}`, when, scene.length > 140 ? `${scene.slice(0, 139)}…` : scene || "scene default"];
}

// --- once a frame ---

/** From one question to the next while nothing moves, ms: at first, and when that has lasted; how long after the last move and the last touch either begins. */
const [AT_REST, LATER, SETTLES, LASTS] = [200, 400, 400, 5000];
/** From one writing of numbers to the next, and from one drawing of plots to the next, ms: while something moves, and at rest or where motion is to be reduced. */
const NUMBERS = { moving: 200, rest: 1000 };
const PLOTS = { moving: 30, rest: 250 };
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;
let [touched, written, plotted] = [0, 0, 0];
/** What the scene shows: which moment, or up to where something moved. */
let drawn = NaN;

/** @param {number} now ms */
function frame(now) {
  timer = undefined;
  timeline.frame(now);
  askForMore();
  const busy = moves(now);
  if (hello && shown) {
    frames += 1;
    measureLag(now);
    const moment = timeline.past ? samples.shown() : -samples.moved;
    const fresh = stale || moment !== drawn || replays();
    if (fresh) shown.draw(cut);
    if (fresh && hello.recording) sayRecorded(hello.recording);
    if (fresh || holding()) drawHand();
    [stale, drawn] = [false, moment];
    if (now - written >= (busy ? NUMBERS.moving : NUMBERS.rest) || (fresh && timeline.past)) {
      written = now;
      writeNumbers();
    }
    if (now - plotted >= (busy && !still.matches ? PLOTS.moving : PLOTS.rest)) {
      plotted = now;
      plots.draw();
    }
    timeline.write(now);
  }
  if (busy) requestAnimationFrame(frame);
  else timer = setTimeout(() => frame(performance.now()), now - Math.max(touched, samples.movedAt) < LASTS ? AT_REST : LATER);
}

/** Whether pictures are wanted once a frame: something moves, or somebody does something. @param {number} now ms */
const moves = (now) =>
  holding() || timeline.playing || replays() || now - touched < SETTLES || (!timeline.past && now - samples.movedAt < SETTLES);

/** Whether a picture replays what was. */
const replays = () => !still.matches && Number.isFinite(replayed());

/** Looks again at once. */
function wake() {
  if (timer === undefined) return;
  clearTimeout(timer);
  timer = undefined;
  requestAnimationFrame(frame);
}
for (const kind of ["pointerdown", "pointermove", "keydown", "input", "change", "click"])
  addEventListener(kind, () => {
    touched = performance.now();
    wake();
  });

const own = [...(hasHand ? [`hand ${me}`] : []), ...(operates ? ["operator"] : [])];
element("who").textContent = `– ${own.join(", ") || "watching"}`;
element("stop").toggleAttribute("disabled", own.length === 0);
input("paste").value = ring ? "" : location.href;
const environment = () => hello?.environments[kind]?.name;
/** Ticks before the end that a picture shows by itself, of a replay; no number of a picture that shows now. */
const replayed = () => shown?.replayed?.() ?? NaN;
Object.assign(window, {
  page: {
    value,
    environment,
    frames: () => frames,
    asCsv: () => plots.asCsv(),
    asSvg: () => plots.asSvg(),
    asToml,
    asLink,
    lag,
    command,
    replayed,
    time: () => plots.at(samples.shown()),
    moment: samples.shown,
    seek: (/** @type {number} */ second) => timeline.seek(Math.round((second - (hello?.recording?.start_s ?? 0)) / period())),
    replay: (/** @type {number} */ seconds, /** @type {number} */ speed) => timeline.replay(seconds, speed),
  },
});
may(operates, hasHand);
if (ring) line = connect();
else say("this address names no run: paste it under “Open link” in a page that cohold play has given you", true);
requestAnimationFrame(frame);
