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
  place.classList.toggle("poor", bad);
}

/** The figures of the trackers beside it, one block each. */
function showBeside(beside) {
  const place = document.getElementById("beside");
  place.hidden = !beside.length;
  if (!beside.length) return;
  const [{ about, clusters, tracks, merged, dropped, tracked_ms }] = beside;
  put("beside_about", about);
  put("beside_clusters", clusters.toLocaleString("en"));
  put("beside_tracks", `${tracks.toLocaleString("en")}${merged ? `, ${merged} merged` : ""}`);
  put("beside_tracked_ms", milliseconds(tracked_ms));
  put("beside_dropped", dropped.toLocaleString("en"), dropped > 0);
}

/** Display a figures message. */
function showFigures(figures) {
  put("events_per_s", rate(figures.events_per_s));
  showBeside(figures.beside);
  put("clusters", figures.clusters.toLocaleString("en"));
  put("tracks", `${figures.tracks.toLocaleString("en")}${figures.merged ? `, ${figures.merged} merged` : ""}`);
  put("tracked_ms", milliseconds(figures.tracked_ms));
  put("drawn_ms", milliseconds(figures.drawn_ms));
  put("dropped", figures.dropped.toLocaleString("en"), figures.dropped > 0);
  put("undrawn", figures.undrawn.toLocaleString("en"), figures.undrawn > 0);
  put("slipped_s", `${figures.slipped_s.toFixed(1)} s`, figures.slipped_s > 0);
  put("recording_s", `${figures.recording_s.toFixed(1)} s`);
  document.getElementById("saved").parentElement.hidden = figures.saved === null;
  put("saved", (figures.saved ?? 0).toLocaleString("en"));
}

const ROWS_MAX = 50;

/** Update the table of clusters, oldest first; rows are reused. `labels`: of the classes, fewer than three without a classifier. */
function showClusters(clusters, labels) {
  const rows = document.getElementById("rows");
  const shown = [...clusters].sort((a, b) => a.lane - b.lane || b.age - a.age || a.id - b.id).slice(0, ROWS_MAX);
  while (rows.children.length > shown.length) rows.lastChild.remove();
  while (rows.children.length < shown.length) {
    const row = rows.insertRow();
    for (let i = 0; i < 7; i++) row.insertCell().className = i > 1 ? "number" : "";
  }
  document.getElementById("tracked").classList.toggle("unclassified", labels.length < 3);
  shown.forEach(({ id, lane, label, age, x, y, width, height, vx, vy }, i) => {
    const size = `${width.toFixed(0)}×${height.toFixed(0)}`;
    const speed = vx || vy ? Math.hypot(vx, vy).toFixed(0) : "–"; // not every tracker measures it
    const texts = [String(id), labels[label] || "–", `${age.toFixed(1)} s`, x.toFixed(0), y.toFixed(0), size, speed];
    rows.children[i].cells[0].className = lane ? "hardware-name" : "";
    texts.forEach((text, cell) => { rows.children[i].children[cell].textContent = text; });
  });
}
