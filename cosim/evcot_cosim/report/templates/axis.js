// SPDX-License-Identifier: Apache-2.0
// The time axis of the timeline, and its ticks.

const SHORTEST = 20; // us
const FOLLOW = 0.1; // position of the current time on the axis after scrolling to it

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

  /** Zoom by a factor around a time, which keeps its position. */
  zoomAt(factor, time) {
    const span = Math.min(Math.max(this.span / factor, SHORTEST), this.duration);
    this.place(time - ((time - this.from) / this.span) * span, span);
  }

  /** Scroll by a fraction of the shown interval. */
  pan(part) {
    this.place(this.from + part * this.span, this.span);
  }

  /** Scroll until a time is visible; returns whether the axis moved. */
  follow(time) {
    if (time >= this.from && time <= this.to) return false;
    this.place(time - FOLLOW * this.span, this.span);
    return true;
  }

  /** Show a part that begins at a time. */
  place(from, span = this.span) {
    this.from = Math.min(Math.max(from, 0), this.duration - span);
    this.to = this.from + span;
  }

  /** [time, label] of about the given number of ticks. */
  ticks(about) {
    const raw = this.span / about;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw);
    const found = [];
    for (let i = Math.ceil(this.from / step); i * step <= this.to; i++) found.push([i * step, timeText(i * step, step)]);
    return found;
  }
}

/** A time as text; `step`: its resolution. */
export function timeText(time, step = 1) {
  const [unit, length] = step >= 1e5 ? ["s", 1e6] : step >= 100 || time >= 1e5 ? ["ms", 1e3] : ["µs", 1];
  const digits = Math.max(0, Math.ceil(-Math.log10(step / length) - 1e-9));
  return `${(time / length).toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits })} ${unit}`;
}
