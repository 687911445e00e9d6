// SPDX-License-Identifier: Apache-2.0
// A long list of places in the playback: a histogram over time, and only those rows in the document that can be seen.
import { timeText } from "./axis.js";

const ROW = 26; // pixels; as in the style sheet
const SPARE = 4; // rows beyond the edges

export class PlaceList {
  /**
   * @param root an element with `canvas.when` and `.places .rows`
   * @param rows {at, side, id, text}, in order of time; `side`: a Tracks
   * @param when [side, counts] of equal parts of the duration, of all places, listed or not
   */
  constructor(root, rows, when, duration) {
    Object.assign(this, { rows, when, duration, active: -1 });
    this.canvas = root.querySelector("canvas.when");
    this.box = root.querySelector(".places");
    this.inner = root.querySelector(".rows");
    this.name = root.dataset.list;
    this.inner.style.height = `${rows.length * ROW}px`;
    this.box.addEventListener("scroll", () => this.fill(), { passive: true });
    this.box.addEventListener("keydown", (event) => this.#key(event));
    this.box.addEventListener("click", (event) => this.#choose(Number(event.target.closest("a")?.dataset.row ?? this.active)));
    this.canvas.addEventListener("click", (event) => {
      const box = this.canvas.getBoundingClientRect();
      this.#choose(this.#after(((event.clientX - box.left) / box.width) * duration));
    });
  }

  #after(time) {
    const found = this.rows.findIndex(({ at }) => at >= time);
    return found < 0 ? this.rows.length - 1 : found;
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    this.canvas.height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    this.fill();
  }

  /** The histogram: one side stands on the other. */
  draw(theme) {
    const context = this.canvas.getContext("2d");
    const { width, height } = this.canvas;
    context.clearRect(0, 0, width, height);
    const bins = this.when[0]?.[1].length ?? 0;
    const sums = Array.from({ length: bins }, (_, i) => this.when.reduce((sum, [, counts]) => sum + counts[i], 0));
    const most = Math.max(1, ...sums);
    const foot = new Float64Array(bins);
    for (const [side, counts] of this.when) {
      context.fillStyle = theme.sides[side.look].colour;
      counts.forEach((count, i) => {
        const tall = (height * count) / most;
        context.fillRect((i * width) / bins, height - foot[i] - tall, Math.max(width / bins - 1, 1), tall);
        foot[i] += tall;
      });
    }
    this.canvas.title = `at most ${most.toLocaleString("en")} in ${timeText(this.duration / bins, this.duration / bins / 10)}`;
  }

  /** Put the rows into the document that can be seen. */
  fill() {
    const first = Math.max(Math.floor(this.box.scrollTop / ROW) - SPARE, 0);
    const end = Math.min(Math.ceil((this.box.scrollTop + this.box.clientHeight) / ROW) + SPARE, this.rows.length);
    this.inner.replaceChildren(...Array.from({ length: Math.max(end - first, 0) }, (_, i) => this.#row(first + i)));
    if (this.active >= first && this.active < end) this.box.setAttribute("aria-activedescendant", this.#id(this.active));
    else this.box.removeAttribute("aria-activedescendant");
  }

  #id(i) {
    return `${this.name}-row-${i}`;
  }

  #row(i) {
    const { at, side, id, text } = this.rows[i];
    const row = document.createElement("a");
    Object.assign(row, { id: this.#id(i), tabIndex: -1, href: `#at=${at}&see=${side.name}-${encodeURIComponent(id)}` });
    row.setAttribute("role", "option");
    row.setAttribute("aria-selected", String(i === this.active));
    row.setAttribute("aria-setsize", this.rows.length);
    row.setAttribute("aria-posinset", i + 1);
    row.dataset.row = i;
    row.style.top = `${i * ROW}px`;
    const swatch = document.createElement("i");
    swatch.className = `swatch ${side.look}`;
    const when = document.createElement("span");
    when.className = "quiet";
    when.textContent = timeText(at, 100);
    const what = document.createElement("span");
    what.className = "what";
    what.textContent = `${side.name} ${id}${text ? ` ${text}` : ""}`;
    row.append(swatch, what, " ", when);
    return row;
  }

  /** Mark a row, and scroll to it. */
  #choose(i) {
    if (!(i >= 0 && i < this.rows.length)) return;
    this.active = i;
    if (i * ROW < this.box.scrollTop) this.box.scrollTop = i * ROW;
    else if ((i + 1) * ROW > this.box.scrollTop + this.box.clientHeight) this.box.scrollTop = (i + 1) * ROW - this.box.clientHeight;
    this.fill();
  }

  #key(event) {
    const page = Math.max(Math.floor(this.box.clientHeight / ROW) - 1, 1);
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -this.rows.length, End: this.rows.length };
    if (event.key in steps) this.#choose(Math.min(Math.max(this.active + steps[event.key], 0), this.rows.length - 1));
    else if (event.key === "Enter" && this.active >= 0) this.inner.querySelector(`[data-row="${this.active}"]`)?.click();
    else return;
    event.preventDefault();
  }
}

/** The rows of a side's own lives, in order of birth. */
export function rowsOfLives(side, endings) {
  return side.ids.map((id, life) => {
    const lasted = timeText(side.end[life] - side.birth[life], 100);
    return { at: side.birth[life], side, id, text: `${lasted}${endings(life)},` };
  });
}

/** How many of ascending times lie in each of `bins` equal parts of a duration. */
export function countWhen(times, duration, bins = 160) {
  const counts = new Array(bins).fill(0);
  for (const time of times) counts[Math.min(Math.floor((time / Math.max(duration, 1)) * bins), bins - 1)] += 1;
  return counts;
}
