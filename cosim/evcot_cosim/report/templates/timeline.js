// SPDX-License-Identifier: Apache-2.0
// The timeline: event rate, tracks alive, and the lifetime of every object, over one axis with one cursor.
import { fitted } from "./panes.js";
import { ALIVE, MERGED } from "./tracks.js";

const AXIS_PX = 22;
const WINDOW_PX = 9; // the bar that shows which part of the time is in view
const RIGHT_PX = 12;
const ROW_PX = [13, 16]; // height of a row of objects: least, most
const BAR_PX = [3, 3, 2]; // of an object's sides
const PHONE_PX = 700; // a narrower timeline has no event rate, no names, and lower rows

export class Timeline {
  /** `acts`: seek(time) and select(number). */
  constructor(canvas, axis, recording, objects, mismatch, acts) {
    Object.assign(this, { canvas, axis, objects, mismatch, acts, scroll: 0 });
    this.sides = objects.sides;
    this.rate = recording.rate;
    this.rateMost = this.rate.reduce((most, value) => Math.max(most, value), 1);
    this.aliveMost = this.sides.reduce((most, side) => side.alive.reduce((max, value) => Math.max(max, value), most), 1);
    this.still = document.createElement("canvas"); // what does not depend on the time of the playback
    this.stale = true;
    this.#listen();
  }

  /** Redraw; what only the time changes is drawn over a picture of the rest. */
  draw(now, theme, selected, shown) {
    const { context, width, height } = fitted(this.canvas);
    if (this.stale || this.still.width !== this.canvas.width || this.still.height !== this.canvas.height) {
      Object.assign(this.still, { width: this.canvas.width, height: this.canvas.height });
      this.#layOut(width, height);
      const still = this.still.getContext("2d");
      still.setTransform(context.getTransform());
      this.#drawStill(still, theme, selected, shown);
      this.stale = false;
    }
    context.save();
    context.resetTransform();
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.drawImage(this.still, 0, 0);
    context.restore();
    this.#drawNow(context, now, theme, shown);
  }

  x(time) {
    return this.left + this.axis.toX(time, this.wide);
  }

  time(x) {
    return this.axis.toTime(x - this.left, this.wide);
  }

  #layOut(width, height) {
    const phone = width < PHONE_PX && height < 150;
    Object.assign(this, { width, height, phone, left: phone ? 44 : 112 });
    this.wide = Math.max(width - this.left - RIGHT_PX, 1);
    this.rateHigh = phone ? 0 : height < 210 ? 24 : 32;
    this.aliveHigh = phone ? 26 : height < 210 ? 30 : 40;
    this.top = AXIS_PX + this.rateHigh + this.aliveHigh + 3;
    this.bottom = height - WINDOW_PX - 3;
    const room = this.bottom - this.top;
    this.rowHigh = phone ? 9 : Math.max(ROW_PX[0], Math.min(ROW_PX[1], Math.floor(room / Math.max(1, this.objects.rows))));
    this.overflow = Math.max(0, this.objects.rows * this.rowHigh - room);
    this.scroll = Math.min(Math.max(this.scroll, 0), this.overflow);
  }

  #drawStill(context, theme, selected, shown) {
    context.clearRect(0, 0, this.width, this.height);
    context.font = `12px ${theme.font}`;
    context.textBaseline = "middle";
    context.fillStyle = theme.panel;
    context.fillRect(0, 0, this.width, AXIS_PX);
    this.#drawTicks(context, theme);
    if (this.rateHigh) this.#drawRate(context, theme);
    this.#drawAlive(context, theme, shown);
    context.strokeStyle = theme.line;
    context.beginPath();
    for (const y of [AXIS_PX + this.rateHigh, this.top - 3]) {
      context.moveTo(0, y + 0.5);
      context.lineTo(this.width, y + 0.5);
    }
    context.stroke();
    this.#drawObjects(context, theme, selected, shown);
    this.#drawWindow(context, theme);
    if (this.mismatch !== null) this.#drawMismatch(context, theme);
  }

  #drawTicks(context, theme) {
    context.strokeStyle = theme.line;
    context.textAlign = "center";
    for (const [time, label] of this.axis.ticks(this.phone ? 4 : 8)) {
      const x = Math.round(this.x(time)) + 0.5;
      context.beginPath();
      context.moveTo(x, AXIS_PX - 4);
      context.lineTo(x, this.bottom);
      context.stroke();
      context.fillStyle = theme.quiet;
      if (x < this.width - 24) context.fillText(label, Math.max(x, this.left + 12), AXIS_PX / 2);
    }
    context.textAlign = "left";
    if (this.phone) return;
    context.fillText("events", 12, AXIS_PX + this.rateHigh / 2);
    context.fillText("objects", 12, this.top + 8);
    if (this.sides.length <= 4) context.fillText("alive", 12, AXIS_PX + this.rateHigh + this.aliveHigh / 2); // else numbers need the room
  }

  /** Draw with everything outside of a lane clipped. */
  #inLane(context, top, bottom, left, drawn) {
    context.save();
    context.beginPath();
    context.rect(left, top, this.width - left - RIGHT_PX + 2, bottom - top);
    context.clip();
    drawn();
    context.restore();
  }

  #drawRate(context, theme) {
    const bottom = AXIS_PX + this.rateHigh;
    const step = this.axis.duration / this.rate.length;
    this.#inLane(context, AXIS_PX, bottom, this.left, () => {
      context.beginPath();
      context.moveTo(this.x(0), bottom);
      this.rate.forEach((value, i) => context.lineTo(this.x((i + 0.5) * step), bottom - 1 - ((this.rateHigh - 5) * value) / this.rateMost));
      context.lineTo(this.x(this.axis.duration), bottom);
      context.globalAlpha = 0.55;
      context.fillStyle = theme.quiet;
      context.fill();
    });
  }

  #drawAlive(context, theme, shown) {
    const bottom = AXIS_PX + this.rateHigh + this.aliveHigh;
    this.#inLane(context, bottom - this.aliveHigh, bottom, this.left, () => {
      this.sides.forEach((side, i) => {
        if (!shown.has(side.name)) return;
        const y = (count) => bottom - 4 - ((this.aliveHigh - 10) * count) / this.aliveMost + (i - 1);
        context.beginPath();
        context.moveTo(this.x(0), y(0));
        side.aliveT.forEach((time, k) => {
          context.lineTo(this.x(time), y(k ? side.alive[k - 1] : 0));
          context.lineTo(this.x(time), y(side.alive[k]));
        });
        context.lineTo(this.x(this.axis.duration), y(side.alive.at(-1) ?? 0));
        this.#pen(context, theme.sides[side.look], 1.75);
        context.stroke();
      });
    });
    context.setLineDash([]);
  }

  #pen(context, { colour, dash }, width) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(dash);
  }

  #rowTop(row) {
    return this.top + row * this.rowHigh - this.scroll;
  }

  #drawObjects(context, theme, selected, shown) {
    this.#inLane(context, this.top - 2, this.bottom, this.phone ? this.left : 0, () => {
      for (const object of this.objects.list) {
        const y = this.#rowTop(object.row);
        if (y + this.rowHigh < this.top || y > this.bottom || this.x(object.end) < this.left || this.x(object.birth) > this.width) continue;
        this.#drawObject(context, theme, object, y, object.number === selected, shown);
      }
    });
    context.setLineDash([]);
    context.globalAlpha = 1;
    if (this.overflow && !this.phone) {
      const room = this.bottom - this.top;
      const high = (room * room) / (room + this.overflow);
      context.fillStyle = theme.line;
      context.fillRect(this.width - 7, this.top + (this.scroll / this.overflow) * (room - high), 4, high);
    }
    if (this.objects.list.length) return;
    context.fillStyle = theme.quiet;
    context.fillText("No track became visible.", this.left + 8, this.top + 10);
  }

  #drawObject(context, theme, object, y, strong, shown) {
    if (strong) {
      context.globalAlpha = 1;
      context.fillStyle = theme.tint;
      const left = Math.max(this.x(object.birth) - 22, 0);
      context.fillRect(left, y - 1, this.x(object.end) + 4 - left, this.rowHigh);
    }
    const bars = this.sides.filter((side, i) => shown.has(side.name) && object.lives[i].length);
    const high = bars.length > 3 ? 1.5 : 0;
    let top = y + 1;
    for (const side of bars) {
      const i = this.sides.indexOf(side);
      const pen = this.phone ? [2.5, 2, 1.5][i] ?? 1.5 : high || (BAR_PX[i] ?? 2);
      for (const life of object.lives[i]) this.#drawLife(context, theme, side, life, top, pen, strong);
      top += pen + (this.phone ? 0.5 : 1);
    }
    const x = Math.max(this.left, this.x(object.birth));
    if (this.phone || x >= this.width - RIGHT_PX) return;
    context.globalAlpha = 1;
    context.fillStyle = strong ? theme.accent : theme.ink;
    context.font = `${strong ? "600 " : ""}12px ${theme.font}`;
    context.textAlign = "right";
    context.fillText(String(object.number), x - 4, y + 7);
    context.textAlign = "left";
  }

  #drawLife(context, theme, side, life, top, pen, strong) {
    const [from, end] = [Math.max(this.left, this.x(side.birth[life])), this.x(side.end[life])];
    const to = Math.min(this.width - RIGHT_PX, end);
    if (to < this.left || from > this.width) return;
    const style = theme.sides[side.look];
    context.globalAlpha = strong ? 1 : 0.8;
    this.#pen(context, style, pen);
    context.beginPath();
    context.moveTo(from, top + pen / 2);
    context.lineTo(Math.max(to, from + 1.5), top + pen / 2);
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
    if (this.phone || side.name === "truth" || side.ended[life] === ALIVE || end < this.left || end > this.width - 8) return;
    context.lineWidth = 1.5;
    context.beginPath();
    if (side.ended[life] === MERGED) {
      const survivor = side.other[life] < 0 ? null : this.objects.byNumber.get(side.object[side.other[life]]);
      if (survivor && survivor.number !== side.object[life]) {
        context.moveTo(end, top);
        context.lineTo(end, this.#rowTop(survivor.row) + 3);
      }
      context.moveTo(end, top - 2.5);
      for (const [dx, dy] of [[3.5, 1], [0, 4.5], [-3.5, 1], [0, -2.5]]) context.lineTo(end + dx, top + dy);
    } else {
      for (const way of [-1, 1]) {
        context.moveTo(end + 1, top + 1 - 3 * way);
        context.lineTo(end + 7, top + 1 + 3 * way);
      }
    }
    context.stroke();
  }

  #drawWindow(context, theme) {
    const { duration, from, to } = this.axis;
    const x = (time) => this.left + (time / duration) * this.wide;
    context.fillStyle = theme.panel;
    context.fillRect(0, this.height - WINDOW_PX, this.width, WINDOW_PX);
    context.fillStyle = theme.line;
    context.fillRect(this.left, this.height - 7, this.wide, 5);
    context.fillStyle = theme.quiet;
    context.fillRect(x(from), this.height - 7, Math.max(8, x(to) - x(from)), 5);
  }

  #drawMismatch(context, theme) {
    const x = Math.max(this.left, this.x(this.mismatch));
    context.fillStyle = theme.panel;
    context.globalAlpha = 0.86;
    context.fillRect(x, AXIS_PX, this.width - x, this.bottom - AXIS_PX);
    context.globalAlpha = 1;
    context.fillStyle = theme.poor;
    context.fillRect(x - 1, AXIS_PX, 2, this.bottom - AXIS_PX);
    context.font = `600 12px ${theme.font}`;
    const text = "the run stopped here: mismatch";
    context.textAlign = x + context.measureText(text).width + 16 > this.width ? "right" : "left";
    context.fillText(text, x + (context.textAlign === "left" ? 8 : -8), AXIS_PX + 14);
    context.textAlign = "left";
  }

  /** The cursor, its time, and the values at it. */
  #drawNow(context, now, theme, shown) {
    context.textBaseline = "middle";
    context.textAlign = "right";
    if (this.rateHigh) {
      const step = this.axis.duration / this.rate.length;
      const value = this.rate[Math.min(Math.floor(now / step), this.rate.length - 1)] / step;
      context.font = `12px ${theme.font}`;
      context.fillStyle = theme.ink;
      const [scale, unit] = value < 1e-3 ? [1e6, "/s"] : value < 1 ? [1e3, "k/s"] : [1, "M/s"];
      context.fillText(`${Number((scale * value).toPrecision(3))} ${unit}`, this.left - 8, AXIS_PX + this.rateHigh / 2);
    }
    context.font = `600 12px ${theme.font}`;
    let right = this.left - 8;
    for (const side of this.sides.toReversed()) {
      if (!shown.has(side.name)) continue;
      const text = String(side.countAt(now));
      context.fillStyle = theme.sides[side.look].colour;
      context.fillText(text, right, AXIS_PX + this.rateHigh + this.aliveHigh / 2);
      right -= context.measureText(text).width + (this.phone ? 4 : 6);
    }
    context.textAlign = "left";
    const x = this.x(now);
    if (x < this.left - 1 || x > this.width - RIGHT_PX + 1) return;
    const label = (now / 1e6).toFixed(3);
    const wide = context.measureText(label).width + 12;
    const left = Math.max(this.left - 10, Math.min(x - wide / 2, this.width - wide - 2));
    context.fillStyle = theme.accent;
    context.fillRect(x - 1, AXIS_PX - 2, 2, this.bottom - AXIS_PX + 2);
    context.beginPath();
    context.roundRect(left, 2, wide, 18, 4);
    context.fill();
    context.fillStyle = theme.onAccent;
    context.fillText(label, left + 6, 11.5);
  }

  /** The object whose row and time are at a place of the canvas, or null. */
  #objectAt(x, y) {
    if (y < this.top || y > this.bottom) return null;
    const [row, time, reach] = [Math.floor((y - this.top + this.scroll) / this.rowHigh), this.time(x), (this.axis.span * 8) / this.wide];
    return this.objects.list.find((object) => object.row === row && time >= object.birth - 3 * reach && time <= object.end + reach) ?? null;
  }

  #listen() {
    const { canvas, axis } = this;
    let held = null; // "time" or "window"
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const drag = (x) => {
      if (held === "time") return void this.acts.seek(this.time(x));
      axis.place(((x - this.left) / this.wide) * axis.duration - axis.span / 2);
      this.#changed();
    };
    canvas.addEventListener("pointerdown", (event) => {
      const [x, y] = at(event);
      canvas.setPointerCapture(event.pointerId);
      held = y > this.height - WINDOW_PX && axis.zoomed ? "window" : "time";
      const object = held === "time" ? this.#objectAt(x, y) : null;
      if (object) this.acts.select(object.number);
      drag(x);
    });
    canvas.addEventListener("pointermove", (event) => { if (held) drag(at(event)[0]); });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (event.ctrlKey || event.metaKey) axis.zoomAt(Math.exp(-event.deltaY / 300), this.time(at(event)[0]));
      else if (event.shiftKey) axis.pan(Math.sign(event.deltaY || event.deltaX) / 10);
      else this.scroll += event.deltaY / 4;
      this.#changed();
    }, { passive: false });
  }

  #changed() {
    this.stale = true;
    this.acts.changed();
  }
}
