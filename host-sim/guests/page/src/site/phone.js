// @ts-check
// The page on a phone: drawings fill its width, their texts are as large as the others, and who holds a hand sees that and little else.

/** Whether there is little room. */
export const phone = matchMedia("(max-width: 40rem)");
/** So much of an axis is shown where there is little room, and what is drawn is one object: what is beyond is seldom come to. */
const LESS = 0.72;

/** Whether a window is touched: then it has no keys to tell of. */
export const touched = matchMedia("(pointer: coarse)");

/** The drawings, and what they show where there is room. @type {Map<SVGSVGElement, string>} */
let boxes = new Map();

/** The least share of its sides that a drawing shows. */
let least = 1;

/** What a drawing shows: of a wide one on a phone less of its sides, and more above and below. @param {SVGSVGElement} stage @param {string} box */
function fitted(stage, box) {
  const [x = 0, y = 0, wide = 1, high = 1] = box.split(" ").map(Number);
  const aspect = stage.clientWidth / stage.clientHeight;
  if (!phone.matches || !(wide / high > aspect)) return box;
  const less = Math.max(least * wide, high * aspect);
  const more = less / aspect;
  return [x + (wide - less) / 2, y - (more - high) / 2, less, more].map((number) => number.toFixed(2)).join(" ");
}

/** @param {SVGSVGElement} stage */
function fit(stage) {
  const box = boxes.get(stage);
  if (box) stage.setAttribute("viewBox", fitted(stage, box));
  // Pixels of a unit of the drawing: the style sheet makes its texts and the hand large enough with it.
  const scale = stage.getScreenCTM()?.a;
  if (scale) stage.style.setProperty("--px", `${scale}`);
}

const sizes = new ResizeObserver((seen) => {
  for (const { target } of seen) fit(/** @type {SVGSVGElement} */ (target));
});

/** From now on these are the drawings, each of which shows what its viewBox says where there is room.
 * @param {SVGSVGElement[]} stages @param {boolean} flat it is one object along one axis */
export function fitStages(stages, flat) {
  sizes.disconnect();
  least = flat ? LESS : 1;
  boxes = new Map(stages.map((stage) => [stage, stage.getAttribute("viewBox") ?? ""]));
  for (const stage of stages) {
    fit(stage);
    sizes.observe(stage);
  }
}

/** What this window may do, for the style sheet: "operator", "hand" or "watch". @param {boolean} operates @param {boolean} hasHand */
export const may = (operates, hasHand) => {
  document.body.dataset.may = operates ? "operator" : hasHand ? "hand" : "watch";
};
