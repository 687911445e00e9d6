// SPDX-License-Identifier: Apache-2.0
// The selected object: its tracks, the command for its waveform, curves, and moments to go to.
import { numberText, objectName } from "./list.js";
import { apart } from "./objects.js";
import { element, fitted } from "./panes.js";
import { ALIVE, LOST, MERGED } from "./tracks.js";

const MOMENTS_MAX = 12;
const ENDS = { [MERGED]: "merge", [LOST]: "loss" };
const PAD_PX = 4;
const POINTS = 180;
const MOST = 0.985; // of the values: higher ones are clipped

/** Small curves over time, with a cursor; a click goes to the time. */
class Plot {
  /** `curves`: [{style, value(time)}], null where there is no value; `least`: of the scale's top. */
  constructor(canvas, from, to, curves, least, seek) {
    Object.assign(this, { canvas, from, to, curves });
    const times = Array.from({ length: POINTS }, (_, i) => from + ((to - from) * i) / (POINTS - 1));
    this.values = curves.map(({ value }) => times.map(value));
    const known = this.values.flat().filter((value) => value !== null).sort((a, b) => a - b);
    this.top = 1.1 * Math.max(known[Math.floor(known.length * MOST)] ?? 0, least);
    canvas.addEventListener("pointerdown", (event) => {
      const { left, width } = canvas.getBoundingClientRect();
      seek(from + ((to - from) * (event.clientX - left - PAD_PX)) / (width - 2 * PAD_PX));
    });
  }

  draw(now, theme) {
    const { context, width, height } = fitted(this.canvas);
    context.clearRect(0, 0, width, height);
    const x = (part) => PAD_PX + (width - 2 * PAD_PX) * part;
    this.values.forEach((values, k) => {
      const { colour, dash } = theme.sides[this.curves[k].look] ?? { colour: theme.ink, dash: [] };
      context.strokeStyle = colour;
      context.setLineDash(dash);
      context.lineWidth = 1.5;
      context.beginPath();
      let drawing = false;
      values.forEach((value, i) => {
        const y = height - PAD_PX - (height - 2 * PAD_PX) * Math.min(1, (value ?? 0) / this.top);
        if (value !== null) context[drawing ? "lineTo" : "moveTo"](x(i / (POINTS - 1)), y);
        drawing = value !== null;
      });
      context.stroke();
    });
    context.setLineDash([]);
    if (now < this.from || now > this.to) return;
    context.fillStyle = theme.accent;
    context.fillRect(x((now - this.from) / (this.to - this.from || 1)) - 1, 0, 2, height);
  }
}

export class Card {
  /** `acts`: seek(time). */
  constructor(objects, acts) {
    this.objects = objects;
    this.acts = acts;
    this.root = document.getElementById("card");
    this.blank = this.root?.innerHTML;
    this.plots = [];
  }

  /** Show an object by its number, or none. */
  show(number) {
    if (!this.root) return;
    this.plots = [];
    const object = this.objects.byNumber.get(number);
    if (!object) {
      this.root.innerHTML = this.blank;
      return;
    }
    this.root.replaceChildren(this.#title(object), ...this.#fate(object), this.#waveform(object), ...this.#curves(object), this.#moments(object));
  }

  /** Update the cursors and the values at a time. */
  draw(now, theme) {
    for (const { plot, values, digits } of this.plots) {
      plot.draw(now, theme);
      const texts = plot.curves.map(({ value, look }) => [value(now), look]).filter(([value]) => value !== null);
      values.replaceChildren(...texts.flatMap(([value, look], i) => [i ? " · " : "", element("span", { class: look ? `${look}-name` : "" }, numberText(value, digits))]), ` of ${numberText(plot.top)}`);
    }
  }

  #title(object) {
    const sides = this.objects.sides.map((side, i) => {
      const ids = this.objects.ids(object, i);
      if (!ids.length) return element("span", { class: "quiet" }, `no ${side.label}`);
      return element("span", { class: `${side.look}-name` }, element("i", { class: `line ${side.look}` }), `${side.label} ${ids.join(", ")}`);
    });
    return element("div", { class: "title" }, objectName(object.number, "Object "), ...sides);
  }

  /** Where a part of another object has gone. */
  #fate(object) {
    for (const [i, side] of this.objects.sides.entries()) {
      const life = object.lives[i].find((one) => side.ended[one] === MERGED && side.other[one] >= 0 && side.object[side.other[one]] !== object.number);
      if (life === undefined) continue;
      const ms = numberText((side.end[life] - side.birth[life]) / 1e3);
      const into = side.object[side.other[life]];
      return [element("p", { class: "small quiet" }, `${side.label} ${side.ids[life]} merged into object ${into} after ${ms} ms.`)];
    }
    return [];
  }

  #waveform(object) {
    for (const [i, side] of this.objects.sides.entries()) {
      if (!side.waves || !object.lives[i].length) continue;
      const text = `evcot waves ${side.waves} --around birth:${side.ids[object.lives[i][0]]}`;
      const copy = element("button", { type: "button", "data-copy": text, title: "Copy", "aria-label": "Copy the command" });
      copy.innerHTML = '<svg class="icon" aria-hidden="true"><use href="#icon-copy"/></svg>';
      return element("div", { class: "command" }, element("code", {}, text), copy);
    }
    const known = this.objects.sides.some((side) => side.waves);
    return element("p", { class: "small quiet" }, known ? "No hardware track: there is no waveform." : "");
  }

  #curves(object) {
    const { sides } = this.objects;
    const life = (i, time) => object.lives[i].find((one) => sides[i].isAlive(one, time)) ?? -1;
    const box = (i, time) => (life(i, time) < 0 ? null : sides[i].boxAt(life(i, time), time));
    const with0 = sides.map((_, i) => i).filter((i) => object.lives[i].length);
    const [first, ...others] = with0;
    const distances = others.map((i) => ({ look: sides[i].look, value: (time) => apart(box(first, time), box(i, time)) }));
    const each = (value) => with0.map((i) => ({ look: sides[i].look, value: (time) => value(i, time) }));
    const size = (i, time) => {
      const found = box(i, time);
      return found && 2 * Math.sqrt(found.halfWidth * found.halfHeight);
    };
    const speed = (i, time) => (life(i, time) < 0 ? null : sides[i].speedAt(life(i, time), time));
    const plots = [
      [`distance of centres from ${sides[first].label}, px`, distances, 4, 1],
      ["size, px (root of the area)", each(size), 1, 0],
      ["speed, px/s", each(speed), 1, 0],
    ];
    return plots.filter(([, curves]) => curves.length).flatMap(([name, curves, least, digits]) => {
      const [canvas, values] = [element("canvas", { role: "img", "aria-label": name }), element("span")];
      this.plots.push({ plot: new Plot(canvas, object.birth, object.end, curves, least, this.acts.seek), values, digits });
      return [element("p", { class: "plot" }, element("span", {}, name), values), canvas];
    });
  }

  #moments(object) {
    const found = this.objects.sides.flatMap((side, i) => object.lives[i].flatMap((life) => {
      const end = ENDS[side.ended[life]];
      const into = side.ended[life] === MERGED && side.other[life] >= 0 ? ` → ${side.ids[side.other[life]]}` : "";
      const verdicts = side.classesOf(life).map(({ at, label }) => ({ at, side, life, what: `class ${label}` }));
      return [{ at: side.birth[life], side, life, what: "birth" }, ...verdicts, side.ended[life] !== ALIVE && { at: side.end[life], side, life, what: `${end}${into}` }];
    })).filter((moment) => moment && moment.side.name !== "truth").sort((a, b) => a.at - b.at);
    const buttons = found.slice(0, MOMENTS_MAX).map(({ at, side, life, what }) => {
      return element("button", { type: "button", "data-at": at }, (at / 1e6).toFixed(3), element("span", { class: `${side.look}-name` }, `${side.short} ${side.ids[life]}`), what);
    });
    return element("div", { class: "moments" }, ...buttons);
  }
}
