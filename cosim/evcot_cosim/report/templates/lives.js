// SPDX-License-Identifier: Apache-2.0
// Lifetimes: a bar from birth to end in the lane of its slot, one side above the other, merges joined to the survivor.
import { ALIVE, MERGED } from "./tracks.js";

const GAP = 10; // pixels between sides
const LANES_LEAST = 2; // of a side
const REACH = 6; // how near a click must be to a merge
const LABEL_LEAST = 26; // pixels that a bar must have to carry its id

export class LivesPanel {
  constructor(sides, height) {
    this.sides = sides;
    this.height = height;
    const lanes = sides.map((side) => Math.max(side.lanes, LANES_LEAST));
    this.lane = (height - GAP * Math.max(sides.length - 1, 0)) / Math.max(lanes.reduce((sum, count) => sum + count, 0), 1);
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
        context.fillRect(0, this.tops.get(side) - GAP / 2, width, 1);
      }
      if (!side.lives) {
        context.fillStyle = theme.quiet;
        context.font = `12px ${theme.font}`;
        context.textBaseline = "middle";
        context.fillText(`${side.name}: nothing became visible`, 8, this.tops.get(side) + this.lane + 1);
      }
      this.#bars(context, width, axis, theme, side, selected);
      this.#merges(context, width, axis, theme, side);
    }
  }

  #bars(context, width, axis, theme, side, selected) {
    const thick = Math.max(this.lane - (this.lane > 6 ? 3 : 1), 2);
    const colour = theme.sides[side.name].colour;
    context.font = `600 ${Math.min(10, thick)}px ${theme.font}`;
    context.textBaseline = "middle";
    for (let life = 0; life < side.lives; life++) {
      const left = axis.toX(side.birth[life], width);
      const right = axis.toX(side.end[life], width);
      if (right < 0 || left > width) continue;
      const y = this.#middle(side, life);
      const chosen = selected?.side === side && selected.life === life;
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
      for (let life = 0; life < side.lives; life++) {
        if (Math.abs(this.#middle(side, life) - y) > Math.max(this.lane / 2, 4)) continue;
        const left = axis.toX(side.birth[life], width);
        const right = axis.toX(side.end[life], width);
        if (side.ended[life] === MERGED && Math.abs(right - x) <= REACH && !(found?.off <= Math.abs(right - x))) {
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
