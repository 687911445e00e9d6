// SPDX-License-Identifier: Apache-2.0
// Zoomable canvas of events and boxes, and its zoom, pan and clicks by mouse, wheel and touch. Coordinates are in pixels of the
// sensor; (x, y) is the centre of that pixel.
import { fading } from "./surface.js";

const TAG_PX = 17; // height of a number
const TAGS_MAX = 60;
const TRAIL_STEP_PX = 2; // shorter steps of a trail are left out
const MARK_PX = 6;
const ZOOM_MAX = 16;

/**
 * @typedef {{x: number, y: number, halfWidth: number, halfHeight: number, angle: ?number, strong: boolean, colour: ?string,
 *   trail: ?ArrayLike<number>}} Box  trail: x0, y0, x1, y1, … oldest first
 * @typedef {{colour: string, dash: number[], width: number, filled: boolean, boxes: Box[], marks: {x: number, y: number, merge: boolean}[]}} Layer
 * @typedef {{box: Box, parts: [string, ?string][], strong: boolean}} Tag  parts: texts and their colours
 */

export class Stage {
  /** A canvas whose size CSS gives, for a sensor of width x height pixels. */
  constructor(canvas, width, height) {
    this.canvas = canvas;
    this.sensor = { width, height };
    this.context = canvas.getContext("2d", { alpha: false });
    this.image = new ImageData(width, height);
    this.words = new Uint32Array(this.image.data.buffer);
    this.bitmap = document.createElement("canvas");
    Object.assign(this.bitmap, { width, height });
    this.bitmapContext = this.bitmap.getContext("2d", { alpha: false });
    this.overlay = null; // a picture of the whole sensor to lay over the events
    this.zoom = 1; // 1: the whole sensor fits into the canvas
    this.centre = { x: (width - 1) / 2, y: (height - 1) / 2 };
    this.resize();
  }

  /** Adapt to the layout's size. */
  resize() {
    this.ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    const [width, height] = [clientWidth, clientHeight].map((size) => Math.max(1, Math.round(size * this.ratio)));
    if (width !== this.canvas.width || height !== this.canvas.height) Object.assign(this.canvas, { width, height });
  }

  /** Set the colours, as `readTheme` gives them. */
  dress(theme) {
    const { ground, off, on } = theme.stage;
    this.theme = theme;
    this.colours = [fading(off, ground), fading(on, ground)];
  }

  /** Canvas pixels per pixel of the sensor. */
  get scale() {
    const { width, height } = this.sensor;
    return this.zoom * Math.min(this.canvas.width / width, this.canvas.height / height);
  }

  /** Sensor coordinates of a position on the page, (clientX, clientY). */
  toSensor(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    return {
      x: this.centre.x + ((clientX - box.left) * this.ratio - this.canvas.width / 2) / this.scale,
      y: this.centre.y + ((clientY - box.top) * this.ratio - this.canvas.height / 2) / this.scale,
    };
  }

  /** Zoom by a factor around (clientX, clientY). */
  zoomAt(factor, clientX, clientY) {
    const before = this.toSensor(clientX, clientY);
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), ZOOM_MAX);
    const after = this.toSensor(clientX, clientY);
    this.moveTo(this.centre.x + before.x - after.x, this.centre.y + before.y - after.y);
  }

  /** Pan by a number of pixels of the page. */
  pan(dx, dy) {
    this.moveTo(this.centre.x - (dx * this.ratio) / this.scale, this.centre.y - (dy * this.ratio) / this.scale);
  }

  /** Centre the view on a position of the sensor, clipped to the sensor's edges. */
  moveTo(x, y) {
    const { width, height } = this.sensor;
    const halfX = Math.min(this.canvas.width / this.scale, width) / 2;
    const halfY = Math.min(this.canvas.height / this.scale, height) / 2;
    this.centre.x = Math.min(Math.max(x, halfX - 0.5), width - 0.5 - halfX);
    this.centre.y = Math.min(Math.max(y, halfY - 0.5), height - 0.5 - halfY);
  }

  /** Show the whole sensor. */
  fit() {
    this.zoom = 1;
    this.moveTo(0, 0);
  }

  /** Draw an EventSurface at time `now`, then the layers, the first one lowest, and the numbers. */
  draw(surface, now, decay, layers, tags) {
    const { context, canvas, scale, sensor } = this;
    surface.paint(this.words, now, decay, this.colours);
    this.bitmapContext.putImageData(this.image, 0, 0);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.theme.edge;
    context.fillRect(0, 0, canvas.width, canvas.height);
    const left = canvas.width / 2 - (this.centre.x + 0.5) * scale;
    const top = canvas.height / 2 - (this.centre.y + 0.5) * scale;
    context.imageSmoothingEnabled = scale < 1;
    const place = [left, top, sensor.width * scale, sensor.height * scale];
    context.drawImage(this.bitmap, ...place);
    if (this.overlay) {
      context.globalAlpha = 0.7;
      context.drawImage(this.overlay, ...place);
      context.globalAlpha = 1;
    }
    context.save();
    context.beginPath();
    context.rect(...place);
    context.clip();
    context.translate(Math.round(left + scale / 2), Math.round(top + scale / 2)); // whole pixels keep frames sharp
    for (const layer of layers) this.#drawLayer(layer);
    for (const layer of layers) this.#mark(layer);
    const view = { left: -scale / 2, top: -scale / 2, right: (sensor.width - 0.5) * scale, bottom: (sensor.height - 0.5) * scale };
    this.#drawTags(tags, view);
    context.restore();
  }

  #drawLayer({ colour, dash, width, boxes, filled }) {
    const { context, ratio } = this;
    context.globalAlpha = 0.75;
    for (const box of boxes) {
      context.strokeStyle = box.colour ?? colour;
      context.lineWidth = width * ratio * (box.strong ? 1.2 : 0.75);
      this.#trace(box.trail);
    }
    context.globalAlpha = 1;
    for (const box of boxes) {
      if (box.strong && filled) {
        context.globalAlpha = 0.1;
        context.fillStyle = this.theme.accent;
        this.#turned(box, (x, y) => context.fillRect(...this.#rectangle(box, x, y)));
        context.globalAlpha = 1;
      }
      context.fillStyle = box.colour ?? colour;
      const pen = Math.max(1, Math.round(width * ratio * (box.strong ? 1.6 : 1)));
      this.#turned(box, (x, y) => this.#frame(this.#rectangle(box, x, y), pen, dash));
    }
  }

  #trace(trail) {
    if (!trail || trail.length < 4) return;
    const { context, scale, ratio } = this;
    let [x, y] = [trail[0] * scale, trail[1] * scale];
    context.beginPath();
    context.moveTo(x, y);
    for (let i = 2; i < trail.length; i += 2) {
      const [left, top] = [trail[i] * scale, trail[i + 1] * scale];
      if (Math.abs(left - x) + Math.abs(top - y) < TRAIL_STEP_PX * ratio && i < trail.length - 2) continue;
      context.lineTo((x = left), (y = top));
    }
    context.stroke();
  }

  #turned({ x, y, angle }, drawn) {
    if (!angle) return void drawn(x * this.scale, y * this.scale);
    const { context } = this;
    context.save();
    context.translate(x * this.scale, y * this.scale);
    context.rotate(angle);
    drawn(0, 0);
    context.restore();
  }

  /** Left, top, width and height of a box around (x, y), in canvas pixels. */
  #rectangle({ halfWidth, halfHeight }, x, y) {
    const [left, top] = [Math.round(x - halfWidth * this.scale), Math.round(y - halfHeight * this.scale)];
    return [left, top, Math.round(x + halfWidth * this.scale) - left, Math.round(y + halfHeight * this.scale) - top];
  }

  /** The outline of a rectangle. Drawn as rectangles: browsers are slow at dashed lines. */
  #frame([left, top, wide, high], pen, dash) {
    const { context } = this;
    for (const edge of [top, top + high - pen]) this.#edge(left, left + wide, dash, (at, length) => context.fillRect(at, edge, length, pen));
    for (const edge of [left, left + wide - pen]) this.#edge(top, top + high, dash, (at, length) => context.fillRect(edge, at, pen, length));
  }

  #edge(from, to, [on, off = 0] = [], fill) {
    if (!off) return void fill(from, to - from);
    const step = (on + off) * this.ratio;
    for (let at = from; at < to; at += step) fill(at, Math.min(on * this.ratio, to - at));
  }

  /** A merge as a diamond, a loss as a cross. */
  #mark({ colour, marks }) {
    const { context, scale, ratio } = this;
    const size = MARK_PX * ratio;
    context.strokeStyle = colour;
    context.lineWidth = 2 * ratio;
    for (const { x, y, merge } of marks) {
      const [left, top] = [x * scale, y * scale];
      context.beginPath();
      if (merge) {
        context.moveTo(left - size, top);
        for (const [dx, dy] of [[0, -1], [1, 0], [0, 1], [-1, 0]]) context.lineTo(left + dx * size, top + dy * size);
      } else {
        for (const side of [-1, 1]) {
          context.moveTo(left - size, top - side * size);
          context.lineTo(left + size, top + side * size);
        }
      }
      context.stroke();
    }
  }

  /** Each number where it covers least, the strong one first. */
  #drawTags(tags, view) {
    const { context, ratio, theme } = this;
    const high = TAG_PX * ratio;
    context.font = `600 ${12 * ratio}px ${theme.font}`;
    context.textBaseline = "middle";
    const taken = tags.map(({ box }) => {
      const [left, top, wide, tall] = this.#rectangle(box, box.x * this.scale, box.y * this.scale);
      return { left, top, right: left + wide, bottom: top + tall, weight: 1 };
    });
    const inOrder = tags.map((tag, i) => ({ ...tag, around: taken[i] })).sort((a, b) => b.strong - a.strong);
    for (const { parts, strong, around } of inOrder.slice(0, TAGS_MAX)) {
      const widths = parts.map(([text]) => context.measureText(text).width + 8 * ratio);
      const wide = widths.reduce((sum, one) => sum + one, 0);
      const { left, top } = this.#freePlace(around, wide, high, taken, view);
      taken.push({ left, top, right: left + wide, bottom: top + high, weight: 3 });
      context.fillStyle = strong ? theme.accent : theme.raise;
      context.strokeStyle = strong ? theme.accent : theme.quiet;
      context.lineWidth = ratio;
      context.beginPath();
      context.roundRect(left, top, wide, high, 4 * ratio);
      context.fill();
      context.stroke();
      let at = left + 4 * ratio;
      parts.forEach(([text], i) => {
        context.fillStyle = strong ? theme.onAccent : theme.ink;
        context.fillText(text, at, top + high / 2 + ratio);
        at += widths[i];
      });
    }
  }

  #freePlace({ left, top, right, bottom }, wide, high, taken, view) {
    const gap = 3 * this.ratio;
    const places = [[left, top - high - gap], [left, bottom + gap], [right - wide, top - high - gap], [right - wide, bottom + gap], [right + gap, top], [left - wide - gap, top]];
    let best = { cost: Infinity };
    places.forEach(([wishedLeft, wishedTop], rank) => {
      const x = Math.max(view.left + 2, Math.min(wishedLeft, view.right - wide - 2));
      const y = Math.max(view.top + 2, Math.min(wishedTop, view.bottom - high - 2));
      let cost = 2 * rank + 6 * Math.hypot(x - wishedLeft, y - wishedTop);
      for (const one of taken) {
        const [across, down] = [Math.min(x + wide, one.right) - Math.max(x, one.left), Math.min(y + high, one.bottom) - Math.max(y, one.top)];
        if (across > 0 && down > 0) cost += (across * down * one.weight) / 8;
      }
      if (cost < best.cost) best = { cost, left: x, top: y };
    });
    return best;
  }
}

const CLICK_PX = 4; // a pointer that moves further drags

/** Calls `changed()` after the stage's view has moved, and `clicked(event)`. */
export function zoomable(stage, changed, clicked = () => {}) {
  const { canvas } = stage;
  const fingers = new Map();
  let moved = 0;
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    stage.zoomAt(Math.exp(-event.deltaY / 300), event.clientX, event.clientY);
    changed();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (!fingers.size) moved = 0;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : null;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    moved += Math.hypot(event.clientX - last.x, event.clientY - last.y);
    if (before) {
      const after = spread();
      stage.pan(after.x - before.x, after.y - before.y);
      stage.zoomAt(after.apart / Math.max(before.apart, 1), after.x, after.y);
    } else if (moved > CLICK_PX) {
      stage.pan(event.clientX - last.x, event.clientY - last.y);
    }
    changed();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (fingers.size === 1 && moved <= CLICK_PX) clicked(event);
    fingers.delete(event.pointerId);
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
  return {
    zoom(factor) {
      const box = canvas.getBoundingClientRect();
      stage.zoomAt(factor, box.left + box.width / 2, box.top + box.height / 2);
      changed();
    },
    fit() {
      stage.fit();
      changed();
    },
  };
}
