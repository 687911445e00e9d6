// SPDX-License-Identifier: Apache-2.0
// Lifetimes and positions of one side's tracks, or of the true objects.
import { after, notBefore } from "./columns.js";

export const ALIVE = -1; // how a life ended
export const MERGED = 2;
export const LOST = 3;

const TRAIL_POINTS = 120; // at most, of one trail
const SPEED_US = 120_000; // over which a speed is measured

export class Tracks {
  /** Columns of paths.py under this name. */
  constructor({ name, label, short, ids, labels, look, moving, waves }, columns) {
    const of = (field) => columns[`${name}.${field}`];
    Object.assign(this, {
      name, label, short, ids, labels, look, moving, waves,
      slot: of("slot"), birth: of("birth"), end: of("end"), ended: of("ended"), other: of("other"), object: of("object"),
      t: of("t"), x: of("x"), y: of("y"), halfWidth: of("half_width"), halfHeight: of("half_height"), angle: of("angle"),
      aliveT: of("alive_t"), alive: of("alive"), classT: of("class_t"), classLabel: of("class_label"),
    });
    this.lives = ids.length;
    this.first = new Int32Array(this.lives + 1); // where each life's points begin
    this.firstClass = new Int32Array(this.lives + 1); // the same of its changes of class
    for (let i = 0; i < this.lives; i++) {
      this.first[i + 1] = this.first[i] + of("count")[i];
      this.firstClass[i + 1] = this.firstClass[i] + (labels.length ? of("class_count")[i] : 0);
    }
  }

  /** The lives at a time, after all changes at that time, in order of birth. */
  livesAt(now) {
    const found = [];
    for (let life = 0, born = after(this.birth, now); life < born; life++) if (this.isAlive(life, now)) found.push(life);
    return found;
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

  countAt(now) {
    const step = after(this.aliveT, now) - 1;
    return step < 0 ? 0 : this.alive[step];
  }

  /** The box of a life. A tracker's output holds until its next one; a true object is interpolated between two instants. */
  boxAt(life, now) {
    const point = this.#pointAt(life, now);
    const box = { x: this.x[point], y: this.y[point], halfWidth: this.halfWidth[point], halfHeight: this.halfHeight[point], angle: this.angle[point] };
    const next = point + 1;
    if (!this.moving || next >= this.first[life + 1] || now <= this.t[point]) return box;
    const part = (now - this.t[point]) / (this.t[next] - this.t[point]);
    box.x += part * (this.x[next] - box.x);
    box.y += part * (this.y[next] - box.y);
    return box;
  }

  /** The class of a life, by its last verdict so far; empty before the first one. */
  classAt(life, now) {
    if (!this.labels.length) return "";
    const change = after(this.classT, now, this.firstClass[life], this.firstClass[life + 1]) - 1;
    return change < this.firstClass[life] ? "" : this.labels[this.classLabel[change]];
  }

  /** All changes of a life's class: {at, label}. */
  classesOf(life) {
    const changes = [];
    for (let i = this.firstClass[life]; i < this.firstClass[life + 1]; i++) changes.push({ at: this.classT[i], label: this.labels[this.classLabel[i]] });
    return changes;
  }

  /** Pixels per second over the last tenth of a second or so; null of a life that is younger. */
  speedAt(life, now) {
    if (now - this.birth[life] < SPEED_US) return null;
    const [then, here] = [this.boxAt(life, now - SPEED_US), this.boxAt(life, now)];
    return (Math.hypot(here.x - then.x, here.y - then.y) * 1e6) / SPEED_US;
  }

  /** Where a life has been for some time: x0, y0, x1, y1, …, oldest first. */
  trail(life, now, length) {
    const point = this.#pointAt(life, now);
    const begin = notBefore(this.t, now - length, this.first[life], point);
    const step = Math.ceil((point - begin + 1) / TRAIL_POINTS);
    const places = [];
    for (let i = begin; i < point; i += step) places.push(this.x[i], this.y[i]);
    const { x, y } = this.boxAt(life, now);
    places.push(x, y);
    return places;
  }

  /** The places of lives that ended within (since, now]. */
  marks(since, now) {
    const found = [];
    for (let life = after(this.birth, now) - 1; life >= 0; life--) {
      if (this.end[life] > now || this.end[life] <= since || this.ended[life] === ALIVE) continue;
      const point = this.first[life + 1] - 1;
      found.push({ x: this.x[point], y: this.y[point], merge: this.ended[life] === MERGED, life });
    }
    return found;
  }

  /** Index of the latest point of a life; its first one before its birth. */
  #pointAt(life, now) {
    return Math.max(after(this.t, now, this.first[life], this.first[life + 1]) - 1, this.first[life]);
  }
}
