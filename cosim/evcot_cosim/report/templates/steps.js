// SPDX-License-Identifier: Apache-2.0
// The moments for the step buttons: events, updates of a centre, merges, births, losses, differences.
import { after, notBefore } from "./search.js";
import { LOST, MERGED } from "./tracks.js";

export const KINDS = ["event", "update", "merge", "birth", "loss", "difference"];

export class Steps {
  /** `differences`: [time, side, id, …] found on one side only; `mismatch`: time of the mismatch with the model, or null. */
  constructor(recording, sides, differences, mismatch) {
    this.recording = recording;
    this.sides = sides;
    this.moments = { merge: [], birth: [], loss: [], difference: [] };
    for (const side of sides) {
      for (let life = 0; life < side.lives; life++) {
        this.moments.birth.push({ at: side.birth[life], side: side.name, life });
        if (side.ended[life] === MERGED) this.moments.merge.push({ at: side.end[life], side: side.name, life });
        if (side.ended[life] === LOST) this.moments.loss.push({ at: side.end[life], side: side.name, life });
      }
    }
    for (const [at, name, id] of differences) {
      const side = sides.find((one) => one.name === name);
      this.moments.difference.push({ at, side: name, life: side?.rows.get(id) ?? -1 });
    }
    if (mismatch !== null) this.moments.difference.push({ at: mismatch, side: null, life: -1 });
    for (const list of Object.values(this.moments)) list.sort((a, b) => a.at - b.at);
  }

  /** The nearest moment of a kind after (direction 1) or before (-1) `now`, of the sides in `seen`; or null. */
  find(kind, now, direction, seen) {
    const at = (times) => {
      const place = direction > 0 ? after(times, now) : notBefore(times, now) - 1;
      return place >= 0 && place < times.length ? { at: times[place], side: null, life: -1 } : null;
    };
    if (kind === "event") return at(this.recording.t);
    if (kind === "update") {
      const found = this.sides.filter((side) => seen.has(side.name) && side.engine).map((side) => at(this.#updates(side)));
      return found.filter(Boolean).sort((a, b) => direction * (a.at - b.at))[0] ?? null;
    }
    const list = this.moments[kind].filter(({ side }) => side === null || kind === "difference" || seen.has(side));
    if (direction > 0) return list.find((moment) => moment.at > now) ?? null;
    return list.findLast((moment) => moment.at < now) ?? null;
  }

  #updates(side) {
    side.updates ??= Float64Array.from(side.t).sort();
    return side.updates;
  }

  count(kind) {
    if (kind === "event") return this.recording.t.length;
    if (kind === "update") return this.sides.reduce((sum, side) => sum + (side.engine ? side.t.length : 0), 0);
    return this.moments[kind].length;
  }
}
