// SPDX-License-Identifier: Apache-2.0
// Zoomable canvas of events and clusters. Coordinates are in pixels of the sensor; (x, y) is the centre of that pixel.
import { fading } from "./surface.js";

const ID_PX = 11;
const INNER_DASH = [1, 3];
const ARROW_PX = 7; // of the head; a shorter arrow is not drawn
const TRAIL_STEP_PX = 2; // shorter steps of a trail are left out
const ZOOM_MAX = 40; // canvas pixels for one of the sensor's, on a screen of common density

/**
 * @typedef {{id: string|number, x: number, y: number, halfWidth: number, halfHeight: number, inner: ?number,
 *   trail: ?ArrayLike<number>, strong: boolean}} Cluster  inner: half side or null; trail: x0, y0, x1, y1, … oldest first
 * @typedef {{colour: string, dash: number[], width: number, clusters: Cluster[],
 *   show: {window: boolean, inner: boolean, id: boolean, trail: boolean}, marks: ?{x: number, y: number, kind: string,
 *   text: string, fresh: ?number}[], corner: ?("left"|"right"|"below")}} Layer  dash in canvas pixels; marks: of kind "merge" or "loss";
 *   corner: where ids stand
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
    this.bitmap.width = width;
    this.bitmap.height = height;
    this.bitmapContext = this.bitmap.getContext("2d", { alpha: false });
    this.zoom = 1; // 1: the whole sensor fills the canvas
    this.centre = { x: (width - 1) / 2, y: (height - 1) / 2 };
    this.resize();
  }

  /** Adapt to the layout's size; returns whether it changed. */
  resize() {
    const ratio = window.devicePixelRatio || 1;
    const box = this.canvas.getBoundingClientRect();
    const width = Math.max(1, Math.round(box.width * ratio));
    const height = Math.max(1, Math.round(box.height * ratio));
    if (width === this.canvas.width && height === this.canvas.height) return false;
    Object.assign(this.canvas, { width, height });
    this.ratio = ratio;
    return true;
  }

  /** Set colours: background, OFF and ON events as [r, g, b], the rest as CSS colours. */
  dress({ ground, off, on, edge, font }) {
    this.colours = [fading(off, ground), fading(on, ground)];
    this.edge = edge; // beyond the sensor
    this.ground = `rgb(${ground.join(",")})`;
    this.font = font;
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
    const most = (ZOOM_MAX * this.ratio * this.zoom) / this.scale;
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), Math.max(1, most));
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

  /** Whether a position on the sensor is visible. */
  sees(x, y) {
    const { width, height } = this.canvas;
    return Math.abs(x - this.centre.x) * this.scale < 0.45 * width && Math.abs(y - this.centre.y) * this.scale < 0.45 * height;
  }

  /** Draw an EventSurface at time `now`, then the layers, the first one lowest. */
  draw(surface, now, decay, layers) {
    const { context, canvas, bitmapContext, image, scale } = this;
    surface.paint(this.words, now, decay, this.colours);
    bitmapContext.putImageData(image, 0, 0);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.edge;
    context.fillRect(0, 0, canvas.width, canvas.height);
    const left = canvas.width / 2 - (this.centre.x + 0.5) * scale;
    const top = canvas.height / 2 - (this.centre.y + 0.5) * scale;
    context.imageSmoothingEnabled = scale < 1;
    context.drawImage(this.bitmap, left, top, this.sensor.width * scale, this.sensor.height * scale);
    context.save();
    context.translate(Math.round(left + scale / 2), Math.round(top + scale / 2)); // whole pixels keep frames sharp
    this.taken = []; // by texts: a later one does not go over them
    for (const layer of layers) this.#drawLayer(layer);
    for (const layer of layers) this.#mark(layer);
    context.restore();
  }

  #drawLayer({ colour, dash, width, clusters, show, ahead, corner = "left" }) {
    const { context, ratio } = this;
    context.strokeStyle = context.fillStyle = colour;
    if (show.trail) {
      context.lineWidth = width * ratio;
      context.globalAlpha = 0.75;
      for (const cluster of clusters) this.#trace(cluster.trail);
      context.globalAlpha = 1;
    }
    for (const cluster of clusters) {
      const pen = Math.round(width * ratio) * (cluster.strong ? 2 : 1);
      if (show.box) this.#box(cluster, pen, dash);
      if (show.inner && cluster.inner !== null) this.#frame(cluster, cluster.inner, cluster.inner, ratio, INNER_DASH);
    }
    if (show.velocity) {
      context.lineWidth = width * ratio;
      for (const cluster of clusters) this.#arrow(cluster, ahead);
    }
    if (show.id) this.#writeIds(clusters, colour, corner);
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

  /** The way that a cluster goes in `ahead` seconds, as an arrow from its centre. */
  #arrow({ x, y, vx = 0, vy = 0 }, ahead) {
    const { context, scale, ratio } = this;
    const [wide, high] = [vx * ahead * scale, vy * ahead * scale];
    const length = Math.hypot(wide, high);
    if (length < ARROW_PX * ratio) return;
    const head = Math.min(ARROW_PX * ratio, length / 2) / length;
    const [left, top] = [x * scale + wide, y * scale + high];
    context.beginPath();
    context.moveTo(x * scale, y * scale);
    context.lineTo(left, top);
    for (const side of [-1, 1]) {
      context.moveTo(left, top);
      context.lineTo(left - head * (wide + side * high * 0.6), top - head * (high - side * wide * 0.6));
    }
    context.stroke();
  }

  #box({ x, y, angle = 0, halfWidth, halfHeight }, pen, dash) {
    if (!angle) return void this.#frame({ x, y }, halfWidth, halfHeight, pen, dash);
    const { context, scale } = this;
    context.save();
    context.translate(x * scale, y * scale);
    context.rotate(angle);
    this.#frame({ x: 0, y: 0 }, halfWidth, halfHeight, pen, dash);
    context.restore();
  }

  /** The outline of a rectangle. Drawn as rectangles: browsers are slow at dashed lines. */
  #frame({ x, y }, halfWidth, halfHeight, pen, dash) {
    const { scale } = this;
    const [left, right] = [Math.round((x - halfWidth) * scale), Math.round((x + halfWidth) * scale)];
    const [top, bottom] = [Math.round((y - halfHeight) * scale), Math.round((y + halfHeight) * scale)];
    for (const edge of [top, bottom - pen]) this.#edge(left, right, dash, (at, length) => this.context.fillRect(at, edge, length, pen));
    for (const edge of [left, right - pen]) this.#edge(top, bottom, dash, (at, length) => this.context.fillRect(edge, at, pen, length));
  }

  #edge(from, to, [on, off = 0] = [], fill) {
    if (!off) return void fill(from, to - from);
    const step = (on + off) * this.ratio;
    for (let at = from; at < to; at += step) fill(at, Math.min(on * this.ratio, to - at));
  }

  /** Above the box's left or right corner, or below it; inside, where there is no room above; else at a corner that is free. */
  #writeIds(clusters, colour, corner) {
    const { context, scale, ratio } = this;
    const top = -context.getTransform().f;
    for (const { id, x, y, halfWidth, halfHeight, strong } of clusters.toSorted((a, b) => b.strong - a.strong)) {
      const above = (y - halfHeight) * scale - 2 * ratio;
      const under = (y + halfHeight) * scale + ID_PX * ratio + 2 * ratio;
      const over = above - ID_PX * ratio < top ? above + (ID_PX + 4) * ratio : above;
      const [left, right] = [(x - halfWidth) * scale, (x + halfWidth) * scale];
      const places = [[left, over, "left"], [right, over, "right"], [left, under, "left"], [right, under, "right"]];
      const first = { left: 0, right: 1, below: 2 }[corner];
      const order = [...places.slice(first), ...places.slice(0, first)];
      const free = order.find(([at, bottom, align]) => this.#isFree(id, at, bottom, align)) ?? (strong ? order[0] : null);
      if (!free) continue; // no room: the box stays, its id is shown when one zooms in
      context.textAlign = free[2];
      this.#write(id, free[0], free[1], colour);
    }
    context.textAlign = "left";
  }

  /** The rectangle that a text takes: left, top, right, bottom. */
  #extent(text, at, bottom, align) {
    const { context, ratio } = this;
    context.font = `600 ${ID_PX * ratio}px ${this.font}`;
    const wide = context.measureText(text).width;
    const left = align === "right" ? at - wide : at;
    return [left, bottom - ID_PX * ratio, left + wide, bottom];
  }

  #isFree(text, at, bottom, align) {
    const [left, top, right, low] = this.#extent(text, at, bottom, align);
    const edge = this.context.getTransform().e; // beyond the picture nobody could read it
    if (left < -edge || right > this.canvas.width - edge) return false;
    return !this.taken.some(([l, t, r, b]) => left < r && l < right && top < b && t < low);
  }

  /** A merge as a diamond, a loss as a cross. */
  #mark({ colour, marks = [] }) {
    const { context, scale, ratio } = this;
    const size = 7 * ratio;
    for (const { x, y, kind, text, fresh = 1 } of marks) {
      context.globalAlpha = fresh;
      const [left, top] = [x * scale, y * scale];
      context.beginPath();
      if (kind === "merge") {
        context.moveTo(left - size, top);
        for (const [dx, dy] of [[0, -1], [1, 0], [0, 1], [-1, 0]]) context.lineTo(left + dx * size, top + dy * size);
      } else {
        for (const side of [-1, 1]) {
          context.moveTo(left - size, top - side * size);
          context.lineTo(left + size, top + side * size);
        }
      }
      for (const [pen, ink] of [[5, this.ground], [2, colour]]) {
        context.lineWidth = pen * ratio;
        context.strokeStyle = ink;
        context.stroke();
      }
      context.globalAlpha = 1;
      if (text && this.#isFree(text, left + size + 3 * ratio, top + 5 * ratio, "left")) {
        this.#write(text, left + size + 3 * ratio, top + 5 * ratio, colour);
      }
    }
  }

  #write(text, left, bottom, colour) {
    const { context, ratio } = this;
    const extent = this.#extent(text, left, bottom, context.textAlign);
    this.taken.push(extent);
    context.textBaseline = "bottom";
    context.fillStyle = this.ground;
    context.globalAlpha = 0.7;
    context.fillRect(extent[0], extent[1], extent[2] - extent[0], extent[3] - extent[1]);
    context.globalAlpha = 1;
    context.fillStyle = colour;
    context.fillText(text, left, bottom + ratio);
  }
}
