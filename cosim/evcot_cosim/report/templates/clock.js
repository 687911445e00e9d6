// SPDX-License-Identifier: Apache-2.0
// The playback time, in microseconds after the first event: paused, or running at some speed.

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
