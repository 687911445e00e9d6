// SPDX-License-Identifier: Apache-2.0
// The moments for the step buttons: events, updates of a track, merges, births, losses, differences.
import { after, notBefore } from "./columns.js";
import { LOST, MERGED } from "./tracks.js";

export class Steps {
  /** `mismatch`: time of the mismatch with the model, or null. */
  constructor(recording, objects, mismatch) {
    this.recording = recording;
    this.engines = objects.sides.filter((side) => side.name !== "truth");
    this.moments = { merge: [], birth: [], loss: [], difference: [] };
    for (const side of this.engines) {
      for (let life = 0; life < side.lives; life++) {
        const number = side.object[life];
        this.moments.birth.push({ at: side.birth[life], side, number });
        if (side.ended[life] === MERGED) this.moments.merge.push({ at: side.end[life], side, number });
        if (side.ended[life] === LOST) this.moments.loss.push({ at: side.end[life], side, number });
      }
    }
    if (mismatch === null) for (const object of objects.list) if (objects.differs(object)) this.moments.difference.push({ at: object.birth, side: null, number: object.number });
    if (mismatch !== null) this.moments.difference.push({ at: mismatch, side: null, number: 0 });
    for (const list of Object.values(this.moments)) list.sort((a, b) => a.at - b.at);
  }

  /** The nearest moment of a kind after (direction 1) or before (-1) `now`, of the sides in `shown`; or null. */
  find(kind, now, direction, shown) {
    const among = (times) => {
      const place = direction > 0 ? after(times, now) : notBefore(times, now) - 1;
      return place >= 0 && place < times.length ? { at: times[place], side: null, number: 0 } : null;
    };
    if (kind === "event") return among(this.recording.t);
    if (kind === "update") {
      const found = this.engines.filter((side) => shown.has(side.name)).map((side) => among(this.#updates(side)));
      return found.filter(Boolean).sort((a, b) => direction * (a.at - b.at))[0] ?? null;
    }
    const list = this.moments[kind].filter(({ side }) => side === null || shown.has(side.name));
    return (direction > 0 ? list.find((moment) => moment.at > now) : list.findLast((moment) => moment.at < now)) ?? null;
  }

  #updates(side) {
    side.updates ??= Float64Array.from(side.t).sort();
    return side.updates;
  }
}
