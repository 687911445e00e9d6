// SPDX-License-Identifier: Apache-2.0
// The panels beneath the playback: one axis of time, one cursor through all of them.

const TICK_PX = 90; // about, between two ticks

export class Timeline {
  /**
   * @param root the element that holds the panels' canvases, each in a figure with a `.readout`, and the `.cursor` and `.ticks`
   * @param panels canvas id -> panel with `height`, `draw` and `readout`
   * @param acts {seek(time), choose(hit), changed()}
   */
  constructor(root, axis, panels, acts) {
    this.root = root;
    this.axis = axis;
    this.acts = acts;
    this.cursor = root.querySelector(".cursor");
    this.ticks = root.querySelector(".ticks");
    this.panels = Object.entries(panels).map(([id, panel]) => {
      const canvas = root.querySelector(`#${id}`);
      return { panel, canvas, context: canvas.getContext("2d"), readout: canvas.closest("figure").querySelector(".readout") };
    });
    for (const entry of this.panels) this.#listen(entry);
    this.stale = true;
  }

  /** Adapt to the layout's width. */
  resize() {
    this.ratio = window.devicePixelRatio || 1;
    for (const { canvas, panel } of this.panels) {
      canvas.width = Math.max(1, Math.round(canvas.clientWidth * this.ratio));
      canvas.height = Math.round(panel.height * this.ratio);
    }
    this.stale = true;
  }

  get width() {
    return this.panels[0].canvas.clientWidth;
  }

  /** Redraw: the curves only if more than the time has changed. */
  draw(now, theme, selected, shown) {
    if (this.stale) this.#drawPanels(theme, selected, shown);
    this.stale = false;
    const x = this.axis.toX(now, this.width);
    this.#place(this.cursor, x);
  }

  /** Write the values at a time beside the panels' names. */
  read(now, theme, selected, shown) {
    for (const { panel, readout } of this.panels) {
      if (!readout) continue;
      readout.replaceChildren(...[...panel.readout(now, selected, shown)].map(({ side, text }) => {
        const value = document.createElement("span");
        value.textContent = side ? `${side.name} ${text}` : text;
        if (side) value.style.color = theme.sides[side.look].text;
        return value;
      }));
    }
  }

  #place(line, x) {
    line.style.transform = `translateX(${x.toFixed(1)}px)`;
    line.style.setProperty("--part", (x / this.width).toFixed(4)); // on paper the width is another
    line.hidden = x < 0 || x > this.width;
  }

  #drawPanels(theme, selected, shown) {
    for (const { panel, canvas, context } of this.panels) {
      context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      context.clearRect(0, 0, canvas.width, canvas.height);
      panel.draw(context, this.width, this.axis, theme, selected, shown);
    }
    for (const line of this.root.querySelectorAll("[data-at]")) this.#place(line, this.axis.toX(Number(line.dataset.at), this.width));
    this.ticks.replaceChildren(...this.axis.ticks(Math.max(this.width / TICK_PX, 2)).map(([time, label]) => {
      const tick = document.createElement("span");
      tick.textContent = label;
      tick.style.left = `${(100 * this.axis.toX(time, this.width)) / this.width}%`;
      return tick;
    }));
  }

  #listen({ canvas, panel }) {
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    const scrub = (event) => this.acts.seek(this.axis.toTime(place(event).x, this.width));
    let dragged = false;
    canvas.addEventListener("pointerdown", (event) => {
      dragged = false;
      canvas.setPointerCapture(event.pointerId);
      if (!panel.hit) scrub(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      const { x, y } = place(event);
      if (event.buttons) {
        dragged ||= Math.abs(event.movementX) > 0;
        if (dragged) scrub(event);
      } else if (panel.hit) {
        const found = panel.hit(x, y, this.width, this.axis);
        canvas.style.cursor = found ? "pointer" : "crosshair";
        canvas.title = found ? `${found.side.name} ${found.side.ids[found.life]}${found.what === "merge" ? ": merge" : ""}` : "";
      }
    });
    canvas.addEventListener("click", (event) => {
      if (!panel.hit || dragged) return;
      const { x, y } = place(event);
      const found = panel.hit(x, y, this.width, this.axis);
      if (found) this.acts.choose(found);
      else scrub(event);
    });
    canvas.addEventListener("wheel", (event) => {
      if (event.ctrlKey || event.metaKey) {
        this.axis.zoomAt(Math.exp(-event.deltaY / 200), this.axis.toTime(place(event).x, this.width));
      } else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        this.axis.pan((event.deltaX || event.deltaY) / this.width);
      } else {
        return;
      }
      event.preventDefault();
      this.acts.changed();
    }, { passive: false });
  }
}
