// SPDX-License-Identifier: Apache-2.0
// Curves over time: events, clusters alive, and size, N_ev and TC of every track.
import { after } from "./search.js";

const PAD = 4; // pixels above and below a curve
const LINEAR = 500; // us of silence up to which the scale is about linear

function frame(context, width, height, theme, most, unit) {
  context.fillStyle = theme.line;
  context.fillRect(0, height - 1, width, 1);
  context.font = `10px ${theme.font}`;
  context.textBaseline = "top";
  const text = `${most.toLocaleString("en", { maximumFractionDigits: 1 })}${unit}`;
  context.fillStyle = theme.panel; // a curve at its most does not strike the text out
  context.globalAlpha = 0.8;
  context.fillRect(0, 0, context.measureText(text).width + 4, 12);
  context.globalAlpha = 1;
  context.fillStyle = theme.quiet;
  context.fillText(text, 2, 1);
}

/** Event rate over the recording, as an area. */
export class RatePanel {
  constructor(recording, duration) {
    this.height = 44;
    this.counts = recording.rate;
    this.step = duration / this.counts.length;
    this.most = this.counts.reduce((most, count) => Math.max(most, count), 0);
  }

  #perSecond(count) {
    return this.step ? (count / this.step) * 1e6 : 0;
  }

  draw(context, width, axis, theme) {
    const { height, counts, step } = this;
    const first = Math.max(Math.floor(axis.from / step), 0);
    const end = Math.min(Math.ceil(axis.to / step), counts.length);
    context.fillStyle = theme.quiet;
    context.globalAlpha = 0.45;
    context.beginPath();
    context.moveTo(axis.toX(first * step, width), height);
    for (let i = first; i < end; i++) {
      const top = height - (this.most ? ((height - PAD) * counts[i]) / this.most : 0);
      context.lineTo(axis.toX(i * step, width), top);
      context.lineTo(axis.toX((i + 1) * step, width), top);
    }
    context.lineTo(axis.toX(end * step, width), height);
    context.fill();
    context.globalAlpha = 1;
    frame(context, width, height, theme, this.#perSecond(this.most) / 1e3, " k/s");
  }

  readout(now) {
    const count = this.counts[Math.min(Math.floor(now / (this.step || 1)), this.counts.length - 1)];
    return [{ text: `${(this.#perSecond(count) / 1e3).toLocaleString("en", { maximumFractionDigits: 1 })} k/s` }];
  }
}

/** Number of clusters alive, as a step curve. */
export class AlivePanel {
  constructor(sides) {
    this.height = 64;
    this.sides = sides;
    this.most = Math.max(1, ...sides.map((side) => side.alive.reduce((most, count) => Math.max(most, count), 0)));
  }

  draw(context, width, axis, theme, selected, shown) {
    const toY = (count) => this.height - 1 - ((this.height - 2 * PAD) * count) / this.most;
    for (const side of this.sides) {
      if (!shown.has(side.name)) continue;
      const { colour, dash, width: pen } = theme.sides[side.look];
      context.strokeStyle = colour;
      context.lineWidth = pen;
      context.setLineDash(dash);
      context.beginPath();
      const first = Math.max(after(side.aliveT, axis.from) - 1, 0);
      let y = toY(0);
      context.moveTo(axis.toX(side.aliveT[first] ?? 0, width), y);
      for (let i = first; i < side.aliveT.length && side.aliveT[i] <= axis.to; i++) {
        const x = axis.toX(side.aliveT[i], width);
        context.lineTo(x, y);
        context.lineTo(x, (y = toY(side.alive[i])));
      }
      context.lineTo(width, y);
      context.stroke();
    }
    context.setLineDash([]);
    frame(context, width, this.height, theme, this.most, "");
  }

  readout(now, selected, shown) {
    return this.sides.filter((side) => shown.has(side.name)).map((side) => ({ side, text: String(side.countAt(now)) }));
  }
}

/** A value of every track's points, one line per track; several changes within a pixel are drawn as their range. */
export class PointPanel {
  constructor(sides, { value, unit }) {
    this.height = 64;
    this.unit = unit;
    this.value = value;
    this.sides = sides.filter((side) => side.engine && side.lives);
    this.most = Math.max(1, ...this.sides.map((side) => value(side).reduce((most, one) => Math.max(most, one), 0)));
  }

  draw(context, width, axis, theme, selected, shown) {
    for (const side of this.sides.toReversed()) {
      if (!shown.has(side.name)) continue;
      const values = this.value(side);
      for (let life = 0; life < side.lives; life++) {
        if (side.end[life] < axis.from || side.birth[life] > axis.to) continue;
        const chosen = selected?.side === side && selected.life === life;
        context.strokeStyle = theme.sides[side.look].colour;
        context.globalAlpha = chosen ? 1 : 0.4;
        context.lineWidth = chosen ? 2 : 1;
        this.#line(context, width, axis, side, life, values);
      }
    }
    context.globalAlpha = 1;
    frame(context, width, this.height, theme, this.most, this.unit);
  }

  #line(context, width, axis, side, life, values) {
    const toY = (value) => this.height - 1 - ((this.height - 2 * PAD) * value) / this.most;
    const begin = side.pointAt(life, axis.from);
    let y = toY(values[begin]);
    let column = Math.round(axis.toX(side.t[begin], width));
    let [low, high] = [y, y];
    context.beginPath();
    context.moveTo(column, y);
    for (let i = begin + 1; i < side.first[life + 1]; i++) {
      const x = Math.round(axis.toX(side.t[i], width));
      if (x !== column) {
        if (high > low) context.moveTo(column, low), context.lineTo(column, high);
        context.moveTo(column, y);
        context.lineTo(x, y);
        [column, low, high] = [x, y, y];
      }
      y = toY(values[i]);
      [low, high] = [Math.min(low, y), Math.max(high, y)];
      if (x > width) break;
    }
    context.moveTo(column, low);
    context.lineTo(column, high);
    context.moveTo(column, y);
    context.lineTo(axis.toX(side.end[life], width), y);
    context.stroke();
  }

  readout(now, selected, shown) {
    return this.sides.filter((side) => shown.has(side.name)).map((side) => {
      const values = this.value(side);
      const chosen = selected?.side === side && side.isAlive(selected.life, now);
      const lives = chosen ? [selected.life] : side.livesAt(now);
      const mean = lives.reduce((sum, life) => sum + values[side.pointAt(life, now)], 0) / lives.length;
      const what = chosen ? `${side.ids[selected.life]}: ` : "mean ";
      return { side, text: lives.length ? `${what}${mean.toFixed(1)}${this.unit}` : "none" };
    });
  }
}

/** The longest gap of a slot's cluster in each interval. */
export class QuietPanel {
  constructor(sides) {
    this.height = 64;
    this.sides = sides.filter((side) => side.engine && side.lives);
    this.most = Math.max(1, ...this.sides.map((side) => side.quiet.reduce((most, one) => Math.max(most, one), 0)));
  }

  draw(context, width, axis, theme, selected, shown) {
    for (const side of this.sides.toReversed()) {
      if (!shown.has(side.name)) continue;
      for (const slot of side.slots) {
        const chosen = selected?.side === side && side.slot[selected.life] === slot;
        context.strokeStyle = theme.sides[side.look].colour;
        context.globalAlpha = chosen ? 1 : 0.4;
        context.lineWidth = chosen ? 2 : 1;
        this.#line(context, width, axis, side, slot);
      }
    }
    context.globalAlpha = 1;
    frame(context, width, this.height, theme, this.most / 1e3, " ms, logarithmic");
  }

  #line(context, width, axis, side, slot) {
    const { stretch, stretches, quiet } = side;
    const first = Math.max(Math.floor(axis.from / stretch), 0);
    const end = Math.min(Math.ceil(axis.to / stretch) + 1, stretches);
    let down = false;
    context.beginPath();
    for (let i = first; i < end; i++) {
      const peak = quiet[slot * stretches + i];
      const x = axis.toX((i + 0.5) * stretch, width);
      const y = this.height - 1 - ((this.height - 2 * PAD) * Math.log1p(Math.max(peak, 0) / LINEAR)) / Math.log1p(this.most / LINEAR);
      if (peak < 0) down = false;
      else if (down) context.lineTo(x, y);
      else context.moveTo(x, y), context.lineTo(x + 0.5, y), (down = true);
    }
    context.stroke();
  }

  readout(now, selected, shown) {
    return this.sides.filter((side) => shown.has(side.name)).map((side) => {
      const at = Math.min(Math.floor(now / side.stretch), side.stretches - 1);
      const chosen = selected?.side === side;
      const slots = chosen ? [side.slot[selected.life]] : side.slots;
      const peak = Math.max(-1, ...slots.map((slot) => side.quiet[slot * side.stretches + at]));
      return { side, text: peak < 0 ? "none" : `${chosen ? "" : "longest "}${(peak / 1e3).toFixed(2)} ms` };
    });
  }
}
