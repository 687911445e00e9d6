// SPDX-License-Identifier: Apache-2.0
// The playback time, in microseconds after the first event: paused, or running at some speed; and the bar below the picture.

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
