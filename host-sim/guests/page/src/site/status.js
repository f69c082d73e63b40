// @ts-check
// How it stands, in one sentence whose colour is true: red when a peer has stopped itself, motors are off, nothing gets through, or the copies
// are no longer one object.

/** Copies that are farther apart than this, mm, are no longer one object. */
export const TOGETHER_MM = 10;

/** The faults that a peer of the page comes to, without names of keys. @type {Record<number, string>} */
const PLAINLY = {
  3: "its device moved faster than it may",
  4: "its motor pushed as hard as it can, for too long",
  5: "it heard nothing of the other peer for too long",
  7: "its object ran away",
  9: "its device ran away against its motor, or was struck",
  10: "what it heard of the other peer was too old",
  11: "it pushed the hand harder than it may, for too long",
  12: "it gave the hand more power than it may, for too long",
  13: "its device left its workspace",
};

/** Why a peer stopped itself, in plain words; of other faults what the program says. @param {number} fault @param {Record<string, string>} faults */
export const plainly = (fault, faults) => PLAINLY[fault] ?? faults[`${fault}`] ?? "a fault";

/** What is known of it: who has stopped itself and why, whom it waits for, the peers whose motors are off, which of them is on another machine (0:
 * none), what a picture says of itself, how far the copies are apart (mm), which share of the last moments was fresh at either peer, and who has
 * the hands.
 * @typedef {{ fault: { peer: number, why: string } | undefined, waits: string | undefined, off: number[], far: number, cut: boolean,
 *   told: [string, boolean] | undefined, apart: number, live: number[], hands: string }} Known */

/** The sentence, and whether it is bad. @param {Known} known @returns {[string, boolean]} */
export function sentence({ fault, waits, off, far, cut, told, apart, live, hands }) {
  const halts =
    fault && !told?.[1]
      ? `peer ${fault.peer} stopped: ${fault.why}. Press Start.`
      : waits !== undefined
        ? `waiting for ${waits}`
        : undefined;
  // On two machines each end has a Stop of its own.
  const [here, there] = [off.includes(3 - far), off.includes(far)];
  const other = halts ?? `the motors of peer ${far} are on`;
  if (far && here && !there) return [`stopped: your motors are off. Press Start. ${other}`, true];
  if (halts !== undefined) return [halts, true];
  if (far && there && !here) return [`the motors of peer ${far} are off, yours are on. Press Stop to turn yours off.`, true];
  if (off.length > 0 && !fault) return ["stopped: motors are off. Press Start.", true];
  if (cut) return ["the cable is cut", true];
  if (told) return told;
  if (apart > TOGETHER_MM) return [`the copies are ${apart.toFixed(0)} mm apart: they are no longer one object`, true];
  if (live.length > 0 && live.every((share) => share === 0)) return ["nothing gets through: each copy stands alone", true];
  return [hands, false];
}
