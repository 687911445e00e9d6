// SPDX-License-Identifier: Apache-2.0
// The table of objects: those of the moment, all of them, or those that differ; sorted, searched, and selected by a click.
import { apart } from "./objects.js";
import { element } from "./panes.js";
import { objectColour } from "./theme.js";

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
