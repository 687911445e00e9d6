// SPDX-License-Identifier: Apache-2.0
// The events, and a surface with the events up to the current time.
import { after } from "./columns.js";
import { EventSurface } from "./surface.js";

export class Recording {
  constructor(facts, columns) {
    Object.assign(this, { t: columns.t, x: columns.x, y: columns.y, owner: columns.owner });
    this.owners = facts.owners; // what each code says: one slot per side
    this.cell = facts.cell; // pixels of the sensor to one that is drawn, per side
    this.rate = columns.rate;
    this.p = new Uint8Array(facts.shown);
    for (let i = 0; i < facts.shown; i++) this.p[i] = (columns.p[i >> 3] >> (i & 7)) & 1;
    this.surface = new EventSurface(Math.ceil(facts.width / this.cell), Math.ceil(facts.height / this.cell));
    this.from = this.to = 0; // events that went into the surface
    this.polarities = 3;
  }

  /** Number of events up to a time. */
  upTo(now) {
    return after(this.t, now);
  }

  /** Update the surface with all events still visible at `now`; moving forward adds only the new ones. */
  show(now, decay, polarities) {
    const from = after(this.t, now - EventSurface.reach(decay));
    const to = this.upTo(now);
    if (to < this.to || from > this.to || from < this.from || polarities !== this.polarities) {
      this.surface.clear();
      this.from = this.to = from;
      this.polarities = polarities;
    }
    this.surface.add(this.t, this.x, this.y, this.p, this.to, to, polarities);
    this.to = to;
  }
}
