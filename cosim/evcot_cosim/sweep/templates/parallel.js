// SPDX-License-Identifier: Apache-2.0
// Parallel coordinates: the best lines are drawn first and each next one under them, a part in each frame, so that the page stays
// responsive; ranges kept by dragging.
import { shade, sharp, ticks } from "./shades.js";

const TOP = 44;
const BOTTOM = 24;
const FIRST = 500; // lines of the first frame; then as many as keep a frame near FRAME_MS
const FRAME_MS = 40;
const COLOURS = 64;
const LISTED = 12;

/** Draws, and tells `kept(indices)` after each change of the ranges. */
export function parallel(canvas, lines, theme, kept) {
  const ranges = new Map(); // axis -> [low, high] places
  let drawing = 0;
  let drag = null;
  const merits = Float64Array.from({ length: lines.count }, (_, i) => lines.merit(lines.objectives[0], i));
  const order = Array.from({ length: lines.count }, (_, i) => i).sort((a, b) => merits[b] - merits[a]);

  const x = (k, width) => 50 + (k * (width - 100)) / Math.max(lines.axes.length - 1, 1);
  const y = (place, height) => TOP + (1 - place) * (height - TOP - BOTTOM);
  const passes = (i) => [...ranges].every(([k, [low, high]]) => {
    const place = lines.place(lines.axes[k], i);
    return place >= low && place <= high;
  });

  function draw() {
    const { context, width, height } = sharp(canvas);
    const mine = ++drawing;
    const colours = theme();
    const chosen = order.filter(passes);
    kept(chosen.slice(0, LISTED), chosen.length);
    if (!canvas.width || !canvas.height) return;
    frame(context, width, height, colours);
    const alpha = Math.min(Math.max(10 / Math.sqrt(chosen.length + 1), 0.1), 0.9);
    const strokes = Array.from({ length: COLOURS }, (_, k) => shade(k / (COLOURS - 1), alpha));
    // Each part is drawn aside, and then put under all that is there: it looks as if the best had been drawn last.
    const aside = new OffscreenCanvas(canvas.width, canvas.height);
    const part = aside.getContext("2d");
    context.globalCompositeOperation = "destination-over";
    canvas.dataset.drawn = "0";
    let at = 0;
    let many = FIRST;
    let before = null;
    function some(now) {
      if (mine !== drawing) return;
      if (before !== null) many = Math.round(many * Math.min(Math.max(FRAME_MS / (now - before), 0.5), 2)) + 1;
      before = now;
      const end = Math.min(at + many, chosen.length);
      part.setTransform(1, 0, 0, 1, 0, 0);
      part.clearRect(0, 0, aside.width, aside.height);
      part.setTransform(context.getTransform());
      for (let k = end - 1; k >= at; k--) line(part, chosen[k], strokes, width, height);
      at = end;
      context.drawImage(aside, 0, 0, width, height);
      canvas.dataset.drawn = String(at);
      if (at < chosen.length) requestAnimationFrame(some);
    }
    requestAnimationFrame(some);
  }

  function line(context, i, strokes, width, height) {
    context.strokeStyle = strokes[Math.round(merits[i] * (COLOURS - 1))];
    context.beginPath();
    let open = false;
    lines.axes.forEach((axis, k) => {
      const place = lines.place(axis, i);
      if (Number.isNaN(place)) open = false;
      else if (open) context.lineTo(x(k, width), y(place, height));
      else { context.moveTo(x(k, width), y(place, height)); open = true; }
    });
    context.stroke();
  }

  function frame(context, width, height, colours) {
    context.font = `11px ${colours.font}`;
    context.textAlign = "center";
    lines.axes.forEach((axis, k) => {
      const at = x(k, width);
      context.strokeStyle = colours.ink;
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(at, TOP);
      context.lineTo(at, height - BOTTOM);
      context.stroke();
      context.fillStyle = colours.ink;
      context.fillText(axis.name, at, k % 2 ? 26 : 12);
      context.fillStyle = colours.quiet;
      for (const [text, part] of ticks(axis)) {
        const between = part > 0 && part < 1;
        context.textAlign = between ? "left" : "center";
        context.fillText(text, between ? at + 6 : at, part === 0 ? height - 10 : part === 1 ? TOP - 5 : y(part, height) + 4);
      }
      context.textAlign = "center";
      const range = ranges.get(k);
      if (range) {
        context.strokeRect(at - 6, y(range[1], height), 12, y(range[0], height) - y(range[1], height));
      }
    });
  }

  function where(event) {
    const box = canvas.getBoundingClientRect();
    const across = event.clientX - box.left;
    const place = 1 - (event.clientY - box.top - TOP) / (box.height - TOP - BOTTOM);
    const k = lines.axes.map((_, each) => Math.abs(x(each, box.width) - across)).reduce((best, gap, each, all) => (gap < all[best] ? each : best), 0);
    return { k, place: Math.min(Math.max(place, 0), 1), near: Math.abs(x(k, box.width) - across) < 24 };
  }

  canvas.addEventListener("pointerdown", (event) => {
    const at = where(event);
    if (!at.near) return;
    drag = at;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const { place } = where(event);
    if (Math.abs(place - drag.place) > 0.01) ranges.set(drag.k, [Math.min(place, drag.place), Math.max(place, drag.place)]);
    draw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (drag && Math.abs(where(event).place - drag.place) <= 0.01) ranges.delete(drag.k);
    drag = null;
    draw();
  });
  return draw;
}
