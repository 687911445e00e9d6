// SPDX-License-Identifier: Apache-2.0
// The page of a sweep: unpacks the columns, draws the plots, and keeps them in the colours of the theme.
import { unpack } from "./columns.js";
import { readTheme, watchTheme } from "./theme.js";
import { Lines } from "./lines.js";
import { parallel } from "./parallel.js";
import { scatter } from "./scatter.js";

const facts = JSON.parse(document.getElementById("facts").textContent);
const draws = [];
let theme = readTheme();
const redraw = () => {
  theme = readTheme();
  for (const draw of draws) draw();
};
watchTheme(document.getElementById("theme"), redraw);
if (facts.count) await start();
document.documentElement.dataset.ready = "true";

async function start() {
  const text = document.getElementById("columns").textContent;
  const lines = new Lines(facts, await unpack(text, facts.columns, {}));
  const [across, up] = ["across", "up"].map((id) => document.getElementById(id));
  lines.axes.forEach((axis, k) => {
    for (const select of [across, up]) select.add(new Option(axis.name, String(k)));
  });
  const objectives = lines.axes.flatMap((axis, k) => (axis.objective ? [k] : []));
  up.value = String(objectives[0]);
  across.value = String(objectives[1] ?? 0);
  const pointed = document.getElementById("pointed");
  const draw = scatter(
    document.getElementById("scatter"), lines, facts.front, () => theme,
    () => [lines.axes[Number(across.value)], lines.axes[Number(up.value)]],
    (i) => { if (i !== null) pointed.textContent = lines.words(i); },
  );
  for (const select of [across, up]) select.addEventListener("change", draw);
  draws.push(draw, parallel(document.getElementById("parallel"), lines, () => theme, list));
  redraw();
  addEventListener("resize", redraw);

  function list(chosen, count) {
    document.getElementById("kept").textContent = `${count.toLocaleString("en")} of ${lines.count.toLocaleString("en")} configurations; the best of them:`;
    const table = document.getElementById("lines");
    table.replaceChildren();
    const row = (cells, kind) => {
      const tr = table.insertRow();
      for (const text of cells) {
        const cell = document.createElement(kind);
        cell.textContent = text;
        tr.append(cell);
      }
    };
    row(lines.axes.map((axis) => axis.name), "th");
    for (const i of chosen) row(lines.axes.map((axis) => lines.text(axis, i)), "td");
  }
}
