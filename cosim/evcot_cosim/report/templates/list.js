// SPDX-License-Identifier: Apache-2.0
// The table of objects (those of the moment, all of them, or those that differ; sorted, searched, and selected by a click), and
// the card of the selected object: its tracks, the command for its waveform, curves, and moments to go to.
import { element, fitted } from "./panes.js";
import { objectColour } from "./theme.js";
import { ALIVE, apart, LOST, MERGED } from "./tracks.js";

const ROWS_MAX = 400;

/** A number as text, with a dash for what is unknown. */
export function numberText(value, digits = 0) {
  return value === null ? "–" : value.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

/** An object's number with its colour. */
export function objectName(number, prefix = "") {
  return element("span", { class: "object" }, element("i", { style: `background: ${objectColour(number)}` }), `${prefix}${number}`);
}

/** Order of two numbers or texts; null comes last. */
function inOrder(one, other) {
  if (one === null || other === null) return (one === null) - (other === null);
  return typeof one === "string" ? one.localeCompare(other, "en", { numeric: true }) : one - other;
}

export class ObjectList {
  constructor(objects, select) {
    Object.assign(this, { objects, filter: "now", sort: "number", descending: false, wanted: "" });
    this.table = document.getElementById("objects");
    if (!this.table) return; // nothing was tracked
    this.body = this.table.tBodies[0];
    this.rows = new Map();
    this.body.addEventListener("click", (event) => select(Number(event.target.closest("tr")?.dataset.number ?? 0)));
    this.body.addEventListener("keydown", (event) => { if (event.key === "Enter") select(Number(event.target.dataset.number)); });
    this.find = document.getElementById("find");
    this.find.addEventListener("input", () => {
      this.wanted = this.find.value.toLowerCase().trim();
      this.redraw();
    });
    for (const button of document.querySelectorAll("[data-filter]")) button.addEventListener("click", () => this.#filterBy(button.dataset.filter));
    for (const button of this.table.querySelectorAll("[data-sort]")) button.addEventListener("click", () => this.#sortBy(button));
  }

  redraw() {
    if (this.last) this.draw(...this.last);
  }

  /** Show the objects at a time; `present` as of `Objects.at`. */
  draw(now, present, selected) {
    this.last = [now, present, selected];
    if (!this.table) return;
    const { list } = this.objects;
    const differing = list.filter((object) => this.objects.differs(object));
    const counts = { now: present.size, all: list.length, differ: differing.length };
    for (const button of document.querySelectorAll("[data-filter]")) button.querySelector("span").textContent = counts[button.dataset.filter];
    const candidates = this.wanted ? list.filter((object) => this.#matches(object)) : { now: list.filter(({ number }) => present.has(number) || number === selected), all: list, differ: differing }[this.filter];
    const shown = candidates.map((object) => this.#facts(object, present.get(object.number), now));
    if (this.sort !== "number") shown.sort((a, b) => inOrder(a[this.sort], b[this.sort]));
    if (this.descending) shown.reverse();
    shown.length = Math.min(shown.length, ROWS_MAX);
    document.getElementById("more").textContent = candidates.length > ROWS_MAX ? `${ROWS_MAX} of ${numberText(candidates.length)} are listed; find narrows them.` : "";
    const wanted = shown.map((facts) => this.#row(facts, selected));
    const inPlace = wanted.length === this.body.rows.length && wanted.every((row, i) => this.body.rows[i] === row);
    if (!inPlace) {
      const focused = document.activeElement;
      this.body.replaceChildren(...wanted);
      if (wanted.includes(focused)) focused.focus({ preventScroll: true });
    }
  }

  /** Scroll to the selected object. */
  reveal(number) {
    const card = matchMedia("(max-width: 900px)").matches && document.getElementById("card"); // on phones above the list
    (card || this.rows?.get(number))?.scrollIntoView({ block: "nearest" });
  }

  #matches(object) {
    if (String(object.number) === this.wanted) return true;
    return this.objects.sides.some((side, i) => object.lives[i].some((life) => this.#hasClass(side, life) || [side.short, side.label].some((name) => `${name} ${side.ids[life]}`.toLowerCase() === this.wanted)));
  }

  #hasClass(side, life) {
    return side.classesOf(life).some(({ label }) => label.toLowerCase() === this.wanted);
  }

  #facts(object, lives, now) {
    const boxes = lives ? this.objects.boxes(lives, now) : [];
    const own = lives ? lives.findIndex((life) => life >= 0) : -1;
    const box = own < 0 ? null : boxes[own];
    const [word, grade] = this.objects.status(object, lives, now);
    const ids = this.objects.sides.map((_, i) => this.objects.ids(object, i));
    return {
      number: object.number, ids, word, grade, box,
      class: this.objects.classOf(object, lives, now) || null,
      size: box && 4 * box.halfWidth * box.halfHeight,
      speed: box && this.objects.sides[own].speedAt(lives[own], now),
      age: box && (now - object.birth) / 1e6,
      apart: apart(boxes[0], boxes[1]),
      ...Object.fromEntries(this.objects.sides.map((side, i) => [side.name, ids[i].length ? Number(ids[i][0]) || 0 : null])),
    };
  }

  #row({ number, ids, class: label, box, speed, age, apart: distance, word, grade }, selected) {
    if (!this.rows.has(number)) this.rows.set(number, this.#made(number, ids));
    const row = this.rows.get(number);
    const texts = [box ? `${Math.round(2 * box.halfWidth)}×${Math.round(2 * box.halfHeight)}` : "–", numberText(speed), numberText(age, 2), numberText(distance, 1), word];
    if (this.objects.sides.length < 2) texts.splice(3, 1);
    if (this.objects.classified) texts.unshift(label ?? "–");
    texts.forEach((text, i) => { if (row.changing[i].textContent !== text) row.changing[i].textContent = text; });
    row.changing.at(-1).className = `chip ${grade}`;
    row.classList.toggle("gone", !box);
    row.setAttribute("aria-selected", String(number === selected));
    return row;
  }

  #made(number, ids) {
    const row = element("tr", { "data-number": number, tabindex: "0" }, element("td", {}, objectName(number)));
    ids.forEach((own, i) => row.append(element("td", { class: `number ${this.objects.sides[i].look}-name` }, own.length > 3 ? `${own.length} tracks` : own.join(", ") || "–")));
    const cells = ["number wide", "number wide", "number wide", ...(ids.length > 1 ? ["number"] : [])].map((name) => element("td", { class: name }));
    if (this.objects.classified) cells.unshift(element("td"));
    const status = element("span", { class: "chip" });
    row.append(...cells, element("td", {}, status));
    row.changing = [...cells, status];
    return row;
  }

  #filterBy(name) {
    this.filter = name;
    for (const button of document.querySelectorAll("[data-filter]")) button.setAttribute("aria-pressed", String(button.dataset.filter === name));
    this.redraw();
  }

  #sortBy(button) {
    const name = button.dataset.sort;
    this.descending = this.sort === name && !this.descending;
    this.sort = name;
    for (const head of this.table.tHead.rows[0].cells) head.removeAttribute("aria-sort");
    button.parentElement.setAttribute("aria-sort", this.descending ? "descending" : "ascending");
    this.redraw();
  }
}

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
