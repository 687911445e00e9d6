// SPDX-License-Identifier: Apache-2.0
// The stretch of time that all curves share, and its ticks.

const SHORTEST = 20; // us
const FOLLOW = 0.1; // where in the stretch the time stands after it has been followed

export class Axis {
  constructor(duration) {
    this.duration = Math.max(duration, SHORTEST);
    this.fit();
  }

  fit() {
    this.from = 0;
    this.to = this.duration;
  }

  get span() {
    return this.to - this.from;
  }

  get zoomed() {
    return this.span < this.duration;
  }

  toX(time, width) {
    return ((time - this.from) / this.span) * width;
  }

  toTime(x, width) {
    return this.from + (x / width) * this.span;
  }

  /** Shorten by a factor around a time, which stays where it is. */
  zoomAt(factor, time) {
    const span = Math.min(Math.max(this.span / factor, SHORTEST), this.duration);
    this.#place(time - ((time - this.from) / this.span) * span, span);
  }

  /** Move by a part of what is shown. */
  pan(part) {
    this.#place(this.from + part * this.span, this.span);
  }

  /** Have a time in sight; returns whether that moved anything. */
  follow(time) {
    if (time >= this.from && time <= this.to) return false;
    this.#place(time - FOLLOW * this.span, this.span);
    return true;
  }

  #place(from, span) {
    this.from = Math.min(Math.max(from, 0), this.duration - span);
    this.to = this.from + span;
  }

  /** [time, label] of about so many ticks. */
  ticks(about) {
    const raw = this.span / about;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw);
    const found = [];
    for (let i = Math.ceil(this.from / step); i * step <= this.to; i++) found.push([i * step, timeText(i * step, step)]);
    return found;
  }
}

/** A time in words; `step`: how exact. */
export function timeText(time, step = 1) {
  const [unit, length] = step >= 1e5 ? ["s", 1e6] : step >= 100 || time >= 1e5 ? ["ms", 1e3] : ["µs", 1];
  const digits = Math.max(0, Math.ceil(-Math.log10(step / length) - 1e-9));
  return `${(time / length).toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits })} ${unit}`;
}
