// SPDX-License-Identifier: Apache-2.0
// Objects: the lives of all sides that are the same thing, as objects.py has paired them. Every view uses their numbers.

const ROW_GAP = 0.03; // of the recording, between two objects in one row of the timeline

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
