// SPDX-License-Identifier: Apache-2.0
// Lifetimes: a bar from birth to end in the lane of its slot, one side above the other, merges joined to the survivor.
import { ALIVE, MERGED } from "./tracks.js";

const GAP = 22; // pixels below a side's lanes: merges are counted there where they are too many to be drawn
const STRIP = 16; // of it, the height of the counts
const CROWD_PX = 8; // fewer pixels for each merge in sight: they are counted
const NARROW = 2; // pixels: lives up to this wide are drawn together
const BIN = 4; // pixels of a count
const LANES_LEAST = 2; // of a side
const REACH = 6; // how near a click must be to a merge
const LABEL_LEAST = 26; // pixels that a bar must have to carry its id

export class LivesPanel {
  constructor(sides, height) {
    this.sides = sides;
    this.height = height;
    const lanes = sides.map((side) => Math.max(side.lanes, LANES_LEAST));
    this.lane = (height - GAP * sides.length) / Math.max(lanes.reduce((sum, count) => sum + count, 0), 1);
    this.tops = new Map(sides.map((side, i) => {
      return [side, lanes.slice(0, i).reduce((top, count) => top + count * this.lane + GAP, 0)];
    }));
  }

  #middle(side, life) {
    return this.tops.get(side) + (side.lane[life] + 0.5) * this.lane;
  }

  draw(context, width, axis, theme, selected) {
    for (const side of this.sides) {
      if (side !== this.sides[0]) {
        context.fillStyle = theme.line;
        context.fillRect(0, this.tops.get(side) - 2, width, 1);
      }
      if (!side.lives) {
        context.fillStyle = theme.quiet;
        context.font = `12px ${theme.font}`;
        context.textBaseline = "middle";
        context.fillText(`${side.name}: nothing became visible`, 8, this.tops.get(side) + this.lane + 1);
      }
      this.#bars(context, width, axis, theme, side, selected);
      if (this.#crowded(side, width, axis)) this.#counts(context, width, axis, theme, side);
      else this.#merges(context, width, axis, theme, side);
    }
  }

  #bars(context, width, axis, theme, side, selected) {
    const thick = Math.max(this.lane - (this.lane > 6 ? 3 : 1), 2);
    const colour = theme.sides[side.look].colour;
    const narrow = new Map(); // lane -> share of each pixel column that lives take
    context.font = `600 ${Math.min(10, thick)}px ${theme.font}`;
    context.textBaseline = "middle";
    for (let life = 0; life < side.lives; life++) {
      const left = axis.toX(side.birth[life], width);
      const right = axis.toX(side.end[life], width);
      if (right < 0 || left > width) continue;
      const y = this.#middle(side, life);
      const chosen = selected?.side === side && selected.life === life;
      if (right - left < NARROW && !chosen) {
        const lane = side.lane[life];
        if (!narrow.has(lane)) narrow.set(lane, new Float32Array(Math.ceil(width) + 1));
        narrow.get(lane)[Math.max(Math.floor(left), 0)] += Math.max(right - left, 0.3);
        continue;
      }
      context.globalAlpha = chosen ? 1 : 0.55;
      context.fillStyle = colour;
      context.fillRect(left, y - thick / 2, Math.max(right - left, 1.5), thick);
      context.globalAlpha = 1;
      if (chosen) {
        context.strokeStyle = theme.ink;
        context.strokeRect(left - 0.5, y - thick / 2 - 0.5, Math.max(right - left, 1.5) + 1, thick + 1);
      }
      if (side.ended[life] !== ALIVE) context.fillRect(right - 1, y - thick / 2, 1.5, thick);
      const inSight = Math.max(left, 0);
      if (thick >= 8 && Math.min(right, width) - inSight > LABEL_LEAST) {
        context.fillStyle = theme.ink;
        context.fillText(side.ids[life], inSight + 4, y + 0.5);
      }
    }
    context.fillStyle = colour;
    for (const [lane, covered] of narrow) {
      const top = this.tops.get(side) + (lane + 0.5) * this.lane - thick / 2;
      for (let x = 0; x < covered.length; x++) {
        if (!covered[x]) continue;
        context.globalAlpha = Math.min(0.3 + 0.5 * covered[x], 0.8);
        context.fillRect(x, top, 1, thick);
      }
    }
    context.globalAlpha = 1;
  }

  /** Whether the merges in sight are too many to be told apart. */
  #crowded(side, width, axis) {
    let seen = 0;
    for (let life = 0; life < side.lives; life++) {
      if (side.ended[life] === MERGED && side.end[life] >= axis.from && side.end[life] <= axis.to) seen += 1;
    }
    return seen * CROWD_PX > width;
  }

  /** How many merges there are in each part of the time, below the lanes. */
  #counts(context, width, axis, theme, side) {
    const counts = new Uint32Array(Math.ceil(width / BIN) + 1);
    let all = 0;
    for (let life = 0; life < side.lives; life++) {
      if (side.ended[life] !== MERGED || side.end[life] < axis.from || side.end[life] > axis.to) continue;
      counts[Math.floor(axis.toX(side.end[life], width) / BIN)] += 1;
      all += 1;
    }
    const most = counts.reduce((highest, count) => Math.max(highest, count), 1);
    const bottom = this.tops.get(side) + Math.max(side.lanes, LANES_LEAST) * this.lane + STRIP;
    context.fillStyle = theme.ink;
    context.globalAlpha = 0.45;
    counts.forEach((count, i) => context.fillRect(i * BIN, bottom - (STRIP * count) / most, BIN - 1, (STRIP * count) / most));
    context.globalAlpha = 1;
    context.font = `10px ${theme.font}`;
    context.textBaseline = "middle";
    const words = `${all.toLocaleString("en")} merges; zoom in to see each`;
    context.fillStyle = theme.panel;
    context.fillRect(2, bottom - STRIP + 1, context.measureText(words).width + 6, STRIP - 2);
    context.fillStyle = theme.ink;
    context.fillText(words, 5, bottom - STRIP / 2);
  }

  #merges(context, width, axis, theme, side) {
    context.strokeStyle = context.fillStyle = theme.ink;
    context.lineWidth = 0.7;
    const size = Math.min(3, this.lane / 2);
    for (let life = 0; life < side.lives; life++) {
      if (side.ended[life] !== MERGED) continue;
      const x = axis.toX(side.end[life], width);
      if (x < -REACH || x > width + REACH) continue;
      const y = this.#middle(side, life);
      context.beginPath();
      if (side.other[life] >= 0) {
        context.moveTo(x, y);
        context.lineTo(x, this.#middle(side, side.other[life]));
        context.stroke();
        context.beginPath();
      }
      context.moveTo(x - size, y);
      context.lineTo(x, y - size);
      context.lineTo(x + size, y);
      context.lineTo(x, y + size);
      context.fill();
    }
  }

  /** Hit test: {side, life, at, what} or null; `at` is the merge's time, or the time at the position on a bar. */
  hit(x, y, width, axis) {
    let found = null;
    for (const side of this.sides) {
      const crowded = this.#crowded(side, width, axis);
      for (let life = 0; life < side.lives; life++) {
        if (Math.abs(this.#middle(side, life) - y) > Math.max(this.lane / 2, 4)) continue;
        const left = axis.toX(side.birth[life], width);
        const right = axis.toX(side.end[life], width);
        if (!crowded && side.ended[life] === MERGED && Math.abs(right - x) <= REACH && !(found?.off <= Math.abs(right - x))) {
          found = { side, life, at: side.end[life], what: "merge", off: Math.abs(right - x) };
        } else if (!found && x >= left - 2 && x <= right + 2) {
          const at = Math.min(Math.max(axis.toTime(x, width), side.birth[life]), side.end[life]);
          found = { side, life, at, what: "life", off: Infinity };
        }
      }
    }
    return found;
  }

  readout() {
    return "";
  }
}
