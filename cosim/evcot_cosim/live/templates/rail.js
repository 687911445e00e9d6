// SPDX-License-Identifier: Apache-2.0
// What stands beside the picture: the figures and the table of clusters; and what is played: engine, preset, hardware beside it,
// and the place in a file. A change is a wish; a new `hello` grants it.

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

const choice = document.getElementById("choice");
const field = (name) => choice.elements[name];
const played = { engines: {}, dragging: false, place: 0 };

function fill(select, names, chosen) {
  select.replaceChildren(...names.map((name) => new Option(name, name, false, name === chosen)));
}

/** Show what a `hello` says is played; a page that may not change it sees why. */
function showChoice({ engines, engine, preset, lanes, seekable, changes, fixed }) {
  played.engines = engines;
  choice.hidden = false;
  fill(field("engine"), Object.keys(engines), engine);
  showPresets(preset);
  field("hardware").checked = lanes.includes("hardware");
  choice.querySelector(".seek").hidden = !seekable;
  for (const control of choice.elements) control.disabled = !changes;
  field("place").disabled = true; // until its length is known
  played.changes = changes;
  document.getElementById("note").textContent = fixed;
}

function showPresets(chosen) {
  const presets = played.engines[field("engine").value];
  field("preset").replaceChildren(new Option("default", "", false, chosen === null));
  field("preset").append(...presets.map((name) => new Option(name, name, false, name === chosen)));
}

/** The trackers by the lines of their boxes. */
function showLanes(lanes, kinds) {
  const items = lanes.map((name, lane) => element("span", { class: "layer" }, element("i", { class: `line ${kinds[lane]}` }), name));
  document.getElementById("lanes").replaceChildren(...items);
}

/** Show where in the file a figures message is, and what is being prepared. */
function showPlace({ place_s: place, length_s: length, note, running }) {
  if (note || played.changes) document.getElementById("note").textContent = note;
  if (place === null) return;
  played.place = running ? place : 0; // from where another engine goes on: at the end, from the beginning
  const slider = field("place");
  slider.disabled = !played.changes || length === null;
  if (length !== null) slider.max = length;
  if (!played.dragging) slider.value = place;
  const shown = played.dragging ? Number(slider.value) : place;
  document.getElementById("place").textContent = `${shown.toFixed(1)} s${length === null ? "" : ` of ${length.toFixed(1)} s`}`;
}

/** Call `send` with every wish: what to play, and where to begin. */
function onWish(send) {
  const wish = (at) => send({
    engine: field("engine").value, preset: field("preset").value || null, hardware: field("hardware").checked, at,
  });
  field("engine").addEventListener("change", () => showPresets(null));
  choice.addEventListener("change", ({ target }) => {
    played.dragging = false;
    wish(target === field("place") ? Number(target.value) : played.place);
  });
  field("place").addEventListener("input", () => { played.dragging = true; });
  document.getElementById("replay").addEventListener("click", () => wish(0));
  choice.addEventListener("submit", (event) => event.preventDefault());
}
