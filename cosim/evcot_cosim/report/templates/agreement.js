// SPDX-License-Identifier: Apache-2.0
// Where two sides differ: the numbers of tracks over time, objects of one side only, merges; and how much of each true object
// every side has covered.
import { objectName } from "./list.js";
import { element, fitted } from "./panes.js";
import { MERGED } from "./tracks.js";

const PLACES_MAX = 200;
const STRIP_STEPS = 240;
const COVER_STEPS = 60;

/** A line that goes to a moment and selects its object. */
function place({ at, number, side, text, more }) {
  const name = element("span", { class: `${side.look}-name` }, text);
  return element("button", { type: "button", class: "place", "data-at": at, "data-number": number }, element("span", {}, objectName(number), " ", name), element("span", { class: "quiet" }, more));
}

function fill(root, places, unit) {
  root.replaceChildren(...places.slice(0, PLACES_MAX).map(place));
  if (places.length > PLACES_MAX) root.append(element("p", { class: "small quiet" }, `and ${(places.length - PLACES_MAX).toLocaleString("en")} more ${unit}`));
}

/** The lists of the agreement and the difference tab, where the page has them; `merged`: pairs of ids that merged on both sides. */
export function listDifferences(objects, merged) {
  const [lone, merges] = ["lone", "merges"].map((id) => document.getElementById(id));
  const pair = objects.sides.slice(0, 2);
  const seconds = (us) => `${(us / 1e6).toFixed(3)} s`;
  if (lone) {
    const found = objects.list.filter((object) => objects.differs(object)).map((object) => {
      const i = object.lives[0].length ? 0 : 1;
      return { at: object.birth, number: object.number, side: pair[i], text: `${pair[i].short} ${objects.ids(object, i).join(", ")}`, more: `${seconds(object.birth)}, ${Math.round((object.end - object.birth) / 1e3)} ms` };
    });
    fill(lone, found, "objects");
    lone.previousElementSibling.querySelector("span").textContent = found.length || "none";
  }
  if (!merges) return;
  const both = pair.map((_, i) => new Set(merged.map((ids) => String(ids[i]))));
  const found = pair.flatMap((side, i) => side.ids.flatMap((id, life) => {
    if (side.ended[life] !== MERGED) return [];
    const into = side.other[life] < 0 ? "" : ` into ${side.ids[side.other[life]]}`;
    return [{ at: side.end[life], number: side.object[life], side, text: `${side.short} ${id}${into}`, more: `${seconds(side.end[life])}${both[i].has(id) ? ", both" : ""}` }];
  }));
  fill(merges, found.sort((a, b) => a.at - b.at), "merges");
}

/** The share of each true object's time in which every side has a track of it. */
export function listCover(objects) {
  const root = document.querySelector("#cover tbody");
  if (!root) return;
  const last = objects.sides.length - 1; // the truth
  const truth = objects.sides[last];
  root.replaceChildren(...objects.list.filter((object) => object.lives[last].length).map((object) => {
    const times = object.lives[last].flatMap((life) => Array.from({ length: COVER_STEPS }, (_, i) => truth.birth[life] + ((truth.end[life] - truth.birth[life]) * (i + 0.5)) / COVER_STEPS));
    const shares = objects.sides.slice(0, last).map((side, i) => times.filter((time) => object.lives[i].some((life) => side.isAlive(life, time))).length / times.length);
    const bars = shares.map((share, i) => element("span", { class: "cover" }, element("i", { class: objects.sides[i].look, style: `width: ${100 * share}%` })));
    const texts = shares.map((share, i) => element("td", { class: `number ${objects.sides[i].look}-name` }, `${Math.round(100 * share)} %`));
    return element("tr", { "data-number": object.number }, element("td", {}, objectName(object.number)), element("td", { class: "quiet" }, `truth ${objects.ids(object, last).join(", ")}`), element("td", {}, ...bars), ...texts);
  }));
}

/** Draw by how many tracks the first side has more than the second. */
export function drawStrip(canvas, objects, now, duration, theme) {
  const { context, width, height } = fitted(canvas);
  const [one, other] = objects.sides;
  const middle = height / 2;
  context.clearRect(0, 0, width, height);
  context.fillStyle = theme.line;
  context.fillRect(0, middle, width, 1);
  for (let i = 0; i < STRIP_STEPS; i++) {
    const time = (duration * (i + 0.5)) / STRIP_STEPS;
    const more = one.countAt(time) - other.countAt(time);
    const high = Math.min(middle - 2, Math.abs(more) * 8);
    context.fillStyle = theme.sides[(more > 0 ? one : other).look].colour;
    context.fillRect((i * width) / STRIP_STEPS, more > 0 ? middle - high : middle, width / STRIP_STEPS - 0.5, high);
  }
  context.fillStyle = theme.accent;
  context.fillRect((now / Math.max(duration, 1)) * width - 1, 0, 2, height);
}
