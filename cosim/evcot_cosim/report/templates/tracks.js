// SPDX-License-Identifier: Apache-2.0
// Lifetimes and positions of one engine's tracks, or of the true objects.
import { after, notBefore } from "./search.js";

export const ALIVE = -1; // how a life ended
export const MERGED = 2;
export const LOST = 3;

const MARKS = 6; // at most, of ends that are marked at a time
const TRAIL_POINTS = 120; // at most, of one trail

export class Tracks {
  /** Columns of paths.py under this name; `ring`: per slot, window less inner radius, or null. Of the hardware a box is the window. */
  constructor({ name, ids, ring, engine, look, hardware, moving, stretch, stretches }, columns) {
    const of = (field) => columns[`${name}.${field}`];
    Object.assign(this, {
      name, ids, ring, engine, look, hardware, moving, stretch, stretches,
      slot: of("slot"), lane: of("lane"), birth: of("birth"), end: of("end"), ended: of("ended"), other: of("other"),
      t: of("t"), x: of("x"), y: of("y"), halfWidth: of("half_width"), halfHeight: of("half_height"), angle: of("angle"), vx: of("vx"), vy: of("vy"), nEv: of("n_ev"),
      aliveT: of("alive_t"), alive: of("alive"), quiet: of("quiet"),
    });
    this.lives = ids.length;
    this.meanSide = Float32Array.from(this.halfWidth, (half, i) => half + this.halfHeight[i]);
    this.first = new Int32Array(this.lives + 1); // where each life's points begin
    for (let i = 0; i < this.lives; i++) this.first[i + 1] = this.first[i] + of("count")[i];
    this.rows = new Map(ids.map((id, i) => [id, i]));
    this.slots = [...new Set(this.slot)];
    this.lanes = this.lane.reduce((most, lane) => Math.max(most, lane + 1), 0);
  }

  /** The lives at a time, after all changes at that time. */
  livesAt(now) {
    const found = [];
    for (let life = after(this.birth, now) - 1; life >= 0; life--) if (this.isAlive(life, now)) found.push(life);
    return found.reverse();
  }

  isAlive(life, now) {
    return this.birth[life] <= now && (now < this.end[life] || (this.ended[life] === ALIVE && now <= this.end[life]));
  }

  /** The life in a slot at a moment, its last moment included; -1 if there is none. */
  lifeIn(slot, now) {
    for (let life = after(this.birth, now) - 1; life >= 0; life--) {
      if (this.slot[life] === slot && now <= this.end[life]) return life;
    }
    return -1;
  }

  /** Index of the latest point of a life; its first one before its birth. */
  pointAt(life, now) {
    return Math.max(after(this.t, now, this.first[life], this.first[life + 1]) - 1, this.first[life]);
  }

  countAt(now) {
    const step = after(this.aliveT, now) - 1;
    return step < 0 ? 0 : this.alive[step];
  }

  /** A life in the format of a Stage, with its trail over the last `trail` microseconds. */
  cluster(life, now, trail, strong) {
    const point = this.pointAt(life, now);
    const [x, y] = this.#place(life, point, now);
    const inner = this.ring ? Math.max(this.halfWidth[point] - this.ring[this.slot[life]], 0.5) : null;
    return {
      id: this.ids[life], x, y, inner, strong, ...(this.moving && { vx: this.vx[point], vy: this.vy[point] }),
      halfWidth: this.halfWidth[point], halfHeight: this.halfHeight[point], angle: this.angle[point],
      trail: trail > 0 ? this.#trail(life, point, now - trail) : null,
    };
  }

  /** A tracker's output holds until its next one; a true object is interpolated between two instants. */
  #place(life, point, now) {
    const next = point + 1;
    if (this.engine || next >= this.first[life + 1] || now <= this.t[point]) return [this.x[point], this.y[point]];
    const part = (now - this.t[point]) / (this.t[next] - this.t[point]);
    return [this.x, this.y].map((values) => values[point] + part * (values[next] - values[point]));
  }

  #trail(life, point, since) {
    const begin = notBefore(this.t, since, this.first[life], point);
    const step = Math.ceil((point - begin + 1) / TRAIL_POINTS);
    const places = [];
    for (let i = begin; i < point; i += step) places.push(this.x[i], this.y[i]);
    places.push(this.x[point], this.y[point]);
    return places;
  }

  /** The latest lives that ended within (since, now]: their places, how fresh they are from 1 to 0, and words for the latest. */
  marks(since, now) {
    const found = [];
    for (let life = after(this.birth, now) - 1; life >= 0; life--) {
      if (this.end[life] <= now && this.end[life] > since && this.ended[life] !== ALIVE) {
        const point = this.first[life + 1] - 1;
        const merged = this.ended[life] === MERGED;
        const into = merged && this.other[life] >= 0 ? ` → ${this.ids[this.other[life]]}` : "";
        const fresh = 1 - (now - this.end[life]) / Math.max(now - since, 1);
        const text = `${this.ids[life]}${into}`;
        found.push({ x: this.x[point], y: this.y[point], kind: merged ? "merge" : "loss", at: this.end[life], fresh, text });
      }
    }
    found.sort((a, b) => b.at - a.at);
    found.length = Math.min(found.length, MARKS);
    for (const mark of found) if (mark.at < found[0].at) mark.text = "";
    return found;
  }
}
