// SPDX-License-Identifier: Apache-2.0
// What the page shows: the events up to the current time, the tracks of each side or the true objects, and the objects that
// they are of.
import { after, notBefore } from "./columns.js";
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

const ROW_GAP = 0.03; // of the recording, between two objects in one row of the timeline

/** The lives of all sides that are the same thing, as objects.py has paired them. Every view uses their numbers. */
export class Objects {
  constructor(sides, duration) {
    this.sides = sides;
    const found = new Map();
    sides.forEach((side, i) => {
      for (let life = 0; life < side.lives; life++) {
        const number = side.object[life];
        if (!found.has(number)) found.set(number, { number, lives: sides.map(() => []), birth: Infinity, end: -Infinity });
        const object = found.get(number);
        object.lives[i].push(life);
        object.birth = Math.min(object.birth, side.birth[life]);
        object.end = Math.max(object.end, side.end[life]);
      }
    });
    this.byNumber = found;
    this.list = [...found.values()].sort((a, b) => a.number - b.number);
    this.rows = this.#pack(ROW_GAP * duration);
  }

  /** Give each object the highest row of the timeline that is free during its time; returns the number of rows. */
  #pack(gap) {
    const ends = [];
    for (const object of this.list.toSorted((a, b) => a.birth - b.birth)) {
      const free = ends.findIndex((end) => end + gap < object.birth);
      object.row = free < 0 ? ends.length : free;
      ends[object.row] = object.end;
    }
    return ends.length;
  }

  /** The objects at a time: by number the life of each side, -1 where a side has none. */
  at(now) {
    const present = new Map();
    this.sides.forEach((side, i) => {
      for (const life of side.livesAt(now)) {
        const number = side.object[life];
        if (!present.has(number)) present.set(number, this.sides.map(() => -1));
        if (present.get(number)[i] < 0) present.get(number)[i] = life;
      }
    });
    return present;
  }

  /** Boxes of an object by side, null where a side has none; `lives` as of `at`. */
  boxes(lives, now) {
    return lives.map((life, i) => (life < 0 ? null : this.sides[i].boxAt(life, now)));
  }

  /** The class that a side says of an object: now, or when it was last there; `lives` as of `at`. Empty if there is none. */
  classOf(object, lives, now) {
    for (const [i, side] of this.sides.entries()) {
      const own = lives ? [lives[i]].filter((life) => life >= 0) : object.lives[i];
      const found = own.map((life) => side.classAt(life, now)).findLast(Boolean);
      if (found) return found;
    }
    return "";
  }

  /** Whether any side says classes. */
  get classified() {
    return this.sides.some((side) => side.labels.length);
  }

  /** The ids of an object's tracks on a side, each once. */
  ids(object, i) {
    return [...new Set(object.lives[i].map((life) => this.sides[i].ids[life]))];
  }

  /** Whether only one of the first two engines has it. */
  differs(object) {
    const [a, b] = object.lives;
    return this.engines > 1 && Boolean(a.length) !== Boolean(b.length);
  }

  get engines() {
    return this.sides.filter((side) => side.name !== "truth").length;
  }

  /** Where an object is now, in a word and a grade. */
  status(object, lives, now) {
    if (!lives) return now < object.birth ? ["later", "none"] : ["ended", "none"];
    const { engines, sides } = this;
    const seen = sides.slice(0, Math.min(engines, 2)).filter((_, i) => lives[i] >= 0);
    if (!seen.length) return lives.some((life, i) => life >= 0 && i < engines) ? ["other", "fair"] : ["missed", "poor"];
    if (engines === 1) return ["tracked", "good"];
    return seen.length === 2 ? ["both", "good"] : [`${seen[0].short} only`, "fair"];
  }
}

/** Distance of two boxes' centres; null without one of them. */
export function apart(one, other) {
  return one && other ? Math.hypot(one.x - other.x, one.y - other.y) : null;
}
