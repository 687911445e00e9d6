// SPDX-License-Identifier: Apache-2.0
// The playback time, in microseconds after the first event: the clock and the bar below the picture, the part of it that the
// timeline shows, and the moments for the step buttons.
import { after, notBefore } from "./columns.js";
import { LOST, MERGED } from "./tracks.js";

const FRAME_MAX = 100; // ms that one frame may advance: after a pause of the tab nothing is skipped

export class Clock {
  /** `changed(clock)` is called once per frame if the time has changed or anything was invalidated. */
  constructor(duration, changed) {
    this.duration = duration;
    this.now = 0;
    this.speed = 1;
    this.playing = false;
    this.changed = changed;
    this.waiting = false;
    this.last = null;
  }

  /** Request a call of `changed` at the next frame. */
  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((at) => this.#frame(at));
  }

  #frame(at) {
    this.waiting = false;
    if (this.playing) {
      const passed = this.last === null ? 0 : Math.min(at - this.last, FRAME_MAX);
      this.last = at;
      this.now = Math.min(this.now + passed * 1000 * this.speed, this.duration);
      if (this.now >= this.duration) this.playing = false;
    }
    if (!this.playing) this.last = null;
    this.changed(this);
    if (this.playing) this.invalidate();
  }

  seek(time) {
    this.now = Math.min(Math.max(time, 0), this.duration);
    this.invalidate();
  }

  play() {
    if (this.now >= this.duration) this.now = 0;
    this.playing = true;
    this.invalidate();
  }

  pause() {
    this.playing = false;
    this.invalidate();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }
}

/** The bar below the picture: play, time, speed. */
export class Transport {
  constructor(clock) {
    this.clock = clock;
    this.button = document.getElementById("play");
    this.time = document.getElementById("clock");
    this.speed = document.getElementById("speed");
    this.speed.addEventListener("change", () => { clock.speed = Number(this.speed.value); });
    clock.speed = Number(this.speed.value);
  }

  /** The next speed up or down. */
  faster(direction) {
    this.speed.selectedIndex = Math.min(Math.max(this.speed.selectedIndex + direction, 0), this.speed.options.length - 1);
    this.clock.speed = Number(this.speed.value);
  }

  draw() {
    const { playing, now } = this.clock;
    this.time.textContent = `${(now / 1e6).toFixed(3)} s`;
    if (this.button.dataset.playing === String(playing)) return;
    if (this.button.dataset.playing === "true") document.getElementById("said").textContent = `Paused at ${this.time.textContent}`;
    this.button.dataset.playing = String(playing);
    this.button.setAttribute("aria-label", playing ? "Pause" : "Play");
    this.button.querySelector("use").setAttribute("href", playing ? "#icon-pause" : "#icon-play");
  }
}

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

export class Steps {
  /** `mismatch`: time of the mismatch with the model, or null. */
  constructor(recording, objects, mismatch) {
    this.recording = recording;
    this.engines = objects.sides.filter((side) => side.name !== "truth");
    this.moments = { merge: [], birth: [], loss: [], difference: [] };
    for (const side of this.engines) {
      for (let life = 0; life < side.lives; life++) {
        const number = side.object[life];
        this.moments.birth.push({ at: side.birth[life], side, number });
        if (side.ended[life] === MERGED) this.moments.merge.push({ at: side.end[life], side, number });
        if (side.ended[life] === LOST) this.moments.loss.push({ at: side.end[life], side, number });
      }
    }
    if (mismatch === null) for (const object of objects.list) if (objects.differs(object)) this.moments.difference.push({ at: object.birth, side: null, number: object.number });
    if (mismatch !== null) this.moments.difference.push({ at: mismatch, side: null, number: 0 });
    for (const list of Object.values(this.moments)) list.sort((a, b) => a.at - b.at);
  }

  /** The nearest moment of a kind after (direction 1) or before (-1) `now`, of the sides in `shown`; or null. */
  find(kind, now, direction, shown) {
    const among = (times) => {
      const place = direction > 0 ? after(times, now) : notBefore(times, now) - 1;
      return place >= 0 && place < times.length ? { at: times[place], side: null, number: 0 } : null;
    };
    if (kind === "event") return among(this.recording.t);
    if (kind === "update") {
      const found = this.engines.filter((side) => shown.has(side.name)).map((side) => among(this.#updates(side)));
      return found.filter(Boolean).sort((a, b) => direction * (a.at - b.at))[0] ?? null;
    }
    const list = this.moments[kind].filter(({ side }) => side === null || shown.has(side.name));
    return (direction > 0 ? list.find((moment) => moment.at > now) : list.findLast((moment) => moment.at < now)) ?? null;
  }

  #updates(side) {
    side.updates ??= Float64Array.from(side.t).sort();
    return side.updates;
  }
}
