// SPDX-License-Identifier: Apache-2.0
// Display options: the checkboxes and sliders beside the playback.

const PARTS = ["box", "inner", "id", "trail", "velocity"];

/** A slider's position on a logarithmic scale: its `min` and `max` are powers of ten. */
function power(slider) {
  return 10 ** Number(slider.value);
}

function lengthText(us) {
  return us >= 1e6 ? `${(us / 1e6).toPrecision(2)} s` : us >= 1e3 ? `${Number((us / 1e3).toPrecision(2))} ms` : `${us.toPrecision(2)} µs`;
}

export class Layers {
  constructor(form, changed) {
    this.form = form;
    this.decaySlider = form.querySelector("[name=decay]");
    this.trailSlider = form.querySelector("[name=trail_length]");
    form.addEventListener("input", () => {
      this.#label();
      changed();
    });
    form.addEventListener("submit", (event) => event.preventDefault());
    this.#label();
  }

  #label() {
    for (const slider of [this.decaySlider, this.trailSlider]) {
      const text = lengthText(power(slider));
      slider.parentElement.querySelector("output").textContent = text;
      slider.setAttribute("aria-valuetext", text);
    }
  }

  #on(name) {
    return this.form.querySelector(`[name="${name}"]`)?.checked ?? false;
  }

  get decay() {
    return power(this.decaySlider);
  }

  get trail() {
    return power(this.trailSlider);
  }

  /** Bit 0: OFF events, bit 1: ON events. */
  get polarities() {
    return (this.#on("off") ? 1 : 0) | (this.#on("on") ? 2 : 0);
  }

  /** Parts of a side that are shown, by name. */
  of(side) {
    return Object.fromEntries(PARTS.map((part) => [part, this.#on(`${side}.${part}`)]));
  }

  /** Names of the sides of which anything is shown. */
  seen(sides) {
    return new Set(sides.map(({ name }) => name).filter((name) => PARTS.some((part) => this.#on(`${name}.${part}`))));
  }

  /** Hide all parts of a side; if none is shown, show the default ones. */
  toggle(side) {
    const boxes = PARTS.map((part) => this.form.querySelector(`[name="${side}.${part}"]`)).filter((box) => box && !box.disabled);
    const any = boxes.some((box) => box.checked);
    for (const box of boxes) box.checked = any ? false : box.defaultChecked;
    this.form.dispatchEvent(new Event("input"));
  }

  slower(direction) {
    this.decaySlider.stepUp(direction * 4);
    this.form.dispatchEvent(new Event("input"));
  }
}
