// SPDX-License-Identifier: Apache-2.0
// All configurations by two of their figures, with the front; the nearest point to the pointer is told.
import { shade, sharp, ticks } from "./shades.js";

const LEFT = 64;
const REST = 44;

/** Draws; `axes()` gives the two axes, `told(i)` hears of the point under the pointer, null for none. */
export function scatter(canvas, lines, front, theme, axes, told) {
  const objective = lines.objectives[0];
  let points = [];

  function draw() {
    const { context, width, height } = sharp(canvas);
    const [across, up] = axes();
    const colours = theme();
    const x = (i) => LEFT + lines.place(across, i) * (width - LEFT - 16);
    const y = (i) => height - REST - lines.place(up, i) * (height - REST - 16);
    context.strokeStyle = colours.line;
    context.strokeRect(LEFT - 6, 8, width - LEFT, height - REST);
    context.font = `11px ${colours.font}`;
    context.fillStyle = colours.quiet;
    for (const [text, part] of ticks(across)) {
      context.textAlign = part === 0 ? "left" : part === 1 ? "right" : "center";
      context.fillText(text, LEFT + part * (width - LEFT - 16), height - REST + 22);
    }
    context.textAlign = "right";
    for (const [text, part] of ticks(up)) context.fillText(text, LEFT - 10, height - REST - part * (height - REST - 16));
    context.textAlign = "center";
    context.fillStyle = colours.ink;
    context.fillText(across.name, (LEFT + width) / 2, height - 4);
    context.save();
    context.translate(14, (height - REST) / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(up.name, 0, 0);
    context.restore();
    points = [];
    const size = lines.count > 5000 ? 2 : 4;
    for (let i = 0; i < lines.count; i++) {
      if (Number.isNaN(x(i)) || Number.isNaN(y(i))) continue;
      points.push([x(i), y(i), i]);
      context.fillStyle = shade(lines.merit(objective, i), 0.8);
      context.fillRect(x(i) - size / 2, y(i) - size / 2, size, size);
    }
    if (front.length > 1) {
      const ordered = [...front].sort((a, b) => x(a) - x(b));
      context.strokeStyle = colours.ink;
      context.lineWidth = 1.5;
      context.beginPath();
      ordered.forEach((i, k) => (k ? context.lineTo(x(i), y(i)) : context.moveTo(x(i), y(i))));
      context.stroke();
      for (const i of ordered) {
        context.beginPath();
        context.arc(x(i), y(i), 4.5, 0, 2 * Math.PI);
        context.stroke();
      }
    }
  }

  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    let best = null;
    let nearest = 144;
    for (const [x, y, i] of points) {
      const gap = (x - px) ** 2 + (y - py) ** 2;
      if (gap < nearest) [nearest, best] = [gap, i];
    }
    told(best);
  });
  return draw;
}
