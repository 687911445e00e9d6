// SPDX-License-Identifier: Apache-2.0
// The figures beside the picture.

function rate(perSecond) {
  if (perSecond >= 1e6) return `${(perSecond / 1e6).toFixed(2)} M/s`;
  return perSecond >= 1e3 ? `${(perSecond / 1e3).toFixed(1)} k/s` : `${perSecond.toFixed(0)} /s`;
}

function milliseconds({ p50, p99 }) {
  return p50 === null ? "–" : `${p50.toFixed(1)} · ${p99.toFixed(1)} ms`;
}

function put(id, text, bad = false) {
  const place = document.getElementById(id);
  if (place.textContent !== text) place.textContent = text;
  place.classList.toggle("bad", bad);
}

/** Display a figures message. */
function showFigures(figures) {
  put("events_per_s", rate(figures.events_per_s));
  put("clusters", figures.clusters.toLocaleString("en"));
  put("tracks", `${figures.tracks.toLocaleString("en")}${figures.merged ? `, ${figures.merged} merged` : ""}`);
  put("tracked_ms", milliseconds(figures.tracked_ms));
  put("drawn_ms", milliseconds(figures.drawn_ms));
  put("dropped", figures.dropped.toLocaleString("en"), figures.dropped > 0);
  put("undrawn", figures.undrawn.toLocaleString("en"), figures.undrawn > 0);
  put("slipped_s", `${figures.slipped_s.toFixed(1)} s`, figures.slipped_s > 0);
  put("recording_s", `${figures.recording_s.toFixed(1)} s`);
  put("saved", figures.saved === null ? "no" : figures.saved.toLocaleString("en"));
}

const ROWS_MAX = 50;

/** Update the table of clusters, oldest first; rows are reused. */
function showClusters(clusters) {
  const rows = document.getElementById("rows");
  const shown = [...clusters].sort((a, b) => b.age - a.age || a.id - b.id).slice(0, ROWS_MAX);
  while (rows.children.length > shown.length) rows.lastChild.remove();
  while (rows.children.length < shown.length) {
    const row = rows.insertRow();
    for (let i = 0; i < 6; i++) row.insertCell();
  }
  shown.forEach(({ id, age, x, y, width, height, vx, vy }, i) => {
    const size = `${width.toFixed(0)}×${height.toFixed(0)}`;
    const texts = [String(id), `${age.toFixed(1)} s`, x.toFixed(0), y.toFixed(0), size, Math.hypot(vx, vy).toFixed(0)];
    texts.forEach((text, cell) => { rows.children[i].children[cell].textContent = text; });
  });
}
