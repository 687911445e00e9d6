// SPDX-License-Identifier: Apache-2.0
// What is played: engine, preset, hardware beside it, and the place in a file. A change is a wish; a new `hello` grants it.

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
