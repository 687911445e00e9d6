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

/** Show a message of figures. */
function showFigures(told) {
  put("events_per_s", rate(told.events_per_s));
  put("clusters", told.clusters.toLocaleString("en"));
  put("tracks", `${told.tracks.toLocaleString("en")}${told.merged ? `, ${told.merged} merged` : ""}`);
  put("tracked_ms", milliseconds(told.tracked_ms));
  put("drawn_ms", milliseconds(told.drawn_ms));
  put("dropped", told.dropped.toLocaleString("en"), told.dropped > 0);
  put("undrawn", told.undrawn.toLocaleString("en"), told.undrawn > 0);
  put("recording_s", `${told.recording_s.toFixed(1)} s`);
  put("saved", told.saved === null ? "no" : told.saved.toLocaleString("en"));
}

const ROWS_MAX = 50;

/** The table of clusters, the oldest first; rows are used again. */
function showClusters(clusters) {
  const rows = document.getElementById("rows");
  const shown = [...clusters].sort((a, b) => b.age - a.age || a.id - b.id).slice(0, ROWS_MAX);
  while (rows.children.length > shown.length) rows.lastChild.remove();
  while (rows.children.length < shown.length) {
    const row = rows.insertRow();
    for (let i = 0; i < 5; i++) row.insertCell();
  }
  shown.forEach(({ id, age, x, y, radius }, i) => {
    const texts = [String(id), `${age.toFixed(1)} s`, x.toFixed(0), y.toFixed(0), radius.toFixed(1)];
    texts.forEach((text, cell) => { rows.children[i].children[cell].textContent = text; });
  });
}
