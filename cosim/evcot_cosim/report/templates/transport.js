// SPDX-License-Identifier: Apache-2.0
// The transport bar below the picture: play, scrub, speed, and step buttons.

const SCRUB_STEPS = 10_000;

export class Transport {
  /** `step(kind, direction)` is called by the step buttons. */
  constructor(bar, clock, step) {
    this.bar = bar;
    this.clock = clock;
    this.playButton = bar.querySelector("[name=play]");
    this.scrub = bar.querySelector("[name=scrub]");
    this.speed = bar.querySelector("[name=speed]");
    this.scrub.max = SCRUB_STEPS;
    this.playButton.addEventListener("click", () => clock.toggle());
    this.scrub.addEventListener("input", () => clock.seek((this.scrub.value / SCRUB_STEPS) * clock.duration));
    this.speed.addEventListener("change", () => (clock.speed = Number(this.speed.value)));
    clock.speed = Number(this.speed.value);
    for (const button of bar.querySelectorAll("[data-step]")) {
      button.addEventListener("click", (event) => step(button.dataset.step, event.shiftKey ? -1 : 1));
    }
  }

  /** The next speed up or down. */
  faster(direction) {
    const place = Math.min(Math.max(this.speed.selectedIndex + direction, 0), this.speed.options.length - 1);
    this.speed.selectedIndex = place;
    this.clock.speed = Number(this.speed.value);
  }

  draw(text) {
    const { playing, now, duration } = this.clock;
    if (this.bar.dataset.playing !== String(playing)) {
      this.bar.dataset.playing = String(playing);
      this.playButton.setAttribute("aria-label", playing ? "Pause" : "Play");
    }
    this.scrub.value = duration ? (now / duration) * SCRUB_STEPS : 0;
    this.scrub.setAttribute("aria-valuetext", text);
  }
}
