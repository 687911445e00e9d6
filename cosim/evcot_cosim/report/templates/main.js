// SPDX-License-Identifier: Apache-2.0
// Entry point of the page: one clock, one selection, and all views of them.
import { drawStrip, listCover, listDifferences } from "./agreement.js";
import { Axis, Clock, Steps, Transport } from "./clock.js";
import { Card, ObjectList } from "./list.js";
import { listenToKeys, listenToMenus, listenToSplitters, tabbed } from "./panes.js";
import { Objects, Recording, Tracks } from "./tracks.js";
import { Stage, zoomable } from "./stage.js";
import { objectColour, readTheme, watchTheme } from "./theme.js";
import { Timeline } from "./timeline.js";
import { unpack } from "./columns.js";

const PANEL_MS = 125; // between two updates of the panel while playing
const NUDGE_S = 0.1; // of playback that an arrow key moves by
const MARK_US = 120_000; // for which an end stays marked
const REACH_PX = 2; // beside a box that a click still hits
const TABS_OF_OBJECTS = ["objects", "differences", "agreement", "scores"]; // where a selection shows already
const OWNERS = { [-1]: "in no track", [-2]: "removed by a filter" };

const $ = (selector) => document.querySelector(selector);

async function start() {
  const facts = JSON.parse($("#facts").textContent);
  const columns = await unpack($("#columns").textContent, facts.columns, {
    x: Uint16Array, y: Uint16Array, p: Uint8Array, owner: facts.owners.length > 0x10000 ? Uint32Array : Uint16Array,
  });
  $("#columns").remove();
  const recording = new Recording(facts, columns);
  const sides = facts.sides.map((side) => new Tracks(side, columns));
  const engines = sides.filter((side) => side.name !== "truth");
  const objects = new Objects(sides, facts.duration);
  const steps = new Steps(recording, objects, facts.mismatch);
  for (const kind of $("#what").options) kind.disabled = steps.moments[kind.value]?.length === 0;
  $("#what").value = ["merge", "birth"].find((kind) => steps.moments[kind].length) ?? "event";
  const axis = new Axis(facts.duration);
  const stage = new Stage($("#picture"), recording.surface.width, recording.surface.height);
  const rail = $("#rail");
  let theme;
  let selected = 0;
  let following = false;
  let pixel = null; // a hot pixel that is marked
  let panelDrawn = 0;
  let present = new Map();

  const clock = new Clock(facts.duration, draw);
  const transport = new Transport(clock);
  const view = zoomable(stage, () => clock.invalidate(), (event) => select(objectUnder(event)));
  const timeline = new Timeline($("#timeline"), axis, recording, objects, facts.mismatch, { seek, select, changed: () => clock.invalidate() });
  const list = new ObjectList(objects, select);
  const card = new Card(objects, { seek });
  const tabs = tabbed(() => drawPanel());

  const option = (name) => rail.elements[name].checked;
  const power = (name) => 1e3 * 10 ** Number(rail.elements[name].value); // sliders are logarithmic, in ms
  const shownSides = () => new Set(sides.map(({ name }) => name).filter((name) => rail.querySelector(`[data-side="${name}"]`).checked));

  /** Update everything that depends on the time, once a frame. */
  function draw() {
    const { now } = clock;
    const shown = shownSides();
    const fade = power("fade") / 5;
    present = objects.at(now);
    if (following && selected) follow(now);
    recording.show(now, fade, (option("off") ? 1 : 0) | (option("on") ? 2 : 0));
    stage.draw(recording.surface, now, fade, layersAt(now, shown), option("numbers") ? tagsAt(now, shown) : []);
    if (clock.playing && axis.zoomed && axis.follow(now)) timeline.stale = true;
    timeline.draw(now, theme, selected, shown);
    transport.draw();
    const at = performance.now();
    if (!clock.playing || at - panelDrawn > PANEL_MS) {
      panelDrawn = at;
      drawPanel();
    }
  }

  function drawPanel() {
    if (!$("#panel-objects")?.hidden) {
      list.draw(clock.now, present, selected);
      card.draw(clock.now, theme);
    }
    if ($("#strip")?.offsetParent) drawStrip($("#strip"), objects, clock.now, facts.duration, theme);
  }

  function layersAt(now, shown) {
    const layers = sides.filter((side) => shown.has(side.name)).map((side, i) => {
      const boxes = side.livesAt(now).map((life) => {
        const number = side.object[life];
        return {
          ...inCells(side.boxAt(life, now)), strong: number === selected,
          colour: option("colours") ? objectColour(number) : null,
          trail: option("trails") && !side.moving ? side.trail(life, now, power("trail")).map((value) => value / recording.cell) : null,
        };
      });
      const marks = side.moving ? [] : side.marks(now - MARK_US, now).map((mark) => ({ ...mark, ...inCells(mark) }));
      return { ...theme.sides[side.look], filled: i === 0, boxes, marks };
    });
    if (pixel) layers.push({ colour: theme.accent, dash: [], width: 2, boxes: [], marks: [{ ...inCells(pixel), merge: true }] });
    return layers;
  }

  /** A number for each object; the selected one says whose tracks it has. */
  function tagsAt(now, shown) {
    const tags = [];
    for (const [number, lives] of present) {
      const first = lives.findIndex((life, i) => life >= 0 && shown.has(sides[i].name));
      if (first < 0) continue;
      const parts = [String(number)];
      const label = lives.map((life, i) => (life >= 0 && shown.has(sides[i].name) ? sides[i].classAt(life, now) : "")).find(Boolean);
      if (label) parts.push(label);
      if (number === selected) lives.forEach((life, i) => { if (life >= 0) parts.push(`${sides[i].short} ${sides[i].ids[life]}`); });
      tags.push({ box: inCells(sides[first].boxAt(lives[first], now)), parts: parts.map((text) => [text]), strong: number === selected });
    }
    return tags;
  }

  /** Positions are in pixels of the sensor; for very large sensors the stage merges several pixels into one. */
  function inCells(thing) {
    if (recording.cell === 1) return thing;
    const scaled = { ...thing };
    for (const name of ["x", "y", "halfWidth", "halfHeight"]) if (name in thing) scaled[name] = thing[name] / recording.cell;
    return scaled;
  }

  function boxOf(number, now) {
    const lives = present.get(number);
    return lives ? objects.boxes(lives, now).find(Boolean) : null;
  }

  function follow(now) {
    const box = boxOf(selected, now);
    if (!box) return;
    const { x, y } = inCells(box);
    if (stage.zoom === 1) stage.zoom = 2;
    stage.moveTo(x, y);
  }

  /** The number of the object with the smallest box under the pointer, 0 if there is none. */
  function objectUnder(event) {
    const place = stage.toSensor(event.clientX, event.clientY);
    const [x, y] = [place.x * recording.cell, place.y * recording.cell];
    const shown = shownSides();
    let [best, area] = [0, Infinity];
    for (const [number, lives] of present) {
      objects.boxes(lives, clock.now).forEach((box, i) => {
        if (!box || !shown.has(sides[i].name)) return;
        const inside = Math.abs(x - box.x) <= box.halfWidth + REACH_PX && Math.abs(y - box.y) <= box.halfHeight + REACH_PX;
        if (inside && box.halfWidth * box.halfHeight < area) [best, area] = [number, box.halfWidth * box.halfHeight];
      });
    }
    return best;
  }

  function restyle() {
    timeline.stale = true;
    clock.invalidate();
  }

  function address() {
    history.replaceState(null, "", `#at=${Math.round(clock.now)}${selected ? `&see=${selected}` : ""}`);
  }

  function seek(time) {
    clock.pause();
    clock.seek(time);
    if (axis.follow(clock.now)) timeline.stale = true;
  }

  /** Select an object by its number, everywhere; 0 selects none. */
  function select(number) {
    selected = objects.byNumber.has(number) ? number : 0;
    card.show(selected);
    if (selected && !TABS_OF_OBJECTS.some((name) => $(`#panel-${name}`)?.hidden === false)) tabs.show("objects");
    restyle();
    requestAnimationFrame(() => {
      list.reveal(selected);
      address();
    });
  }

  function step(kind, direction) {
    const found = steps.find(kind, clock.now, direction, shownSides());
    $("#said").textContent = found ? `${kind} at ${(found.at / 1e6).toFixed(6)} s` : `No ${kind} ${direction > 0 ? "after" : "before"} this time.`;
    if (!found) return;
    seek(found.at);
    if (found.number) select(found.number);
  }

  function hover(event) {
    const place = stage.toSensor(event.clientX, event.clientY);
    const [x, y] = [Math.round(place.x), Math.round(place.y)];
    const { surface, cell } = recording;
    if (x < 0 || y < 0 || x >= surface.width || y >= surface.height) return;
    const number = objectUnder(event);
    const found = surface.nearest(x, y, clock.now, power("fade") / 5);
    stage.canvas.style.cursor = number ? "pointer" : "crosshair";
    const label = number ? objects.classOf(objects.byNumber.get(number), present.get(number), clock.now) : "";
    const lines = [found < 0 ? `${x * cell}, ${y * cell} px` : `${recording.x[found] * cell}, ${recording.y[found] * cell} px`, number ? `object ${number} ${label}`.trim() : "no object"];
    if (found >= 0) {
      lines.push(`${recording.p[found] ? "brighter" : "darker"} at ${(recording.t[found] / 1e6).toFixed(6)} s`);
      engines.forEach((side, i) => {
        const slot = recording.owners[recording.owner[found]][i];
        const life = slot < 0 ? -1 : side.lifeIn(slot, recording.t[found]);
        lines.push(`${side.short}: ${OWNERS[slot] ?? (life < 0 ? `slot ${slot}` : `track ${side.ids[life]}`)}`);
      });
    }
    $("#read").replaceChildren(...lines.flatMap((line) => [line, document.createElement("br")]));
  }

  function layOut() {
    stage.resize();
    timeline.stale = true;
    draw();
  }

  function dress() {
    theme = readTheme();
    stage.dress(theme);
    layOut(); // at once: a printer does not wait for the next frame
  }

  function label() {
    for (const name of ["fade", "trail"]) {
      const ms = power(name) / 1e3;
      rail.elements[name].previousElementSibling.textContent = ms >= 1e3 ? `${(ms / 1e3).toPrecision(2)} s` : `${Number(ms.toPrecision(2))} ms`;
    }
  }

  /** Times of the clocks that the simulation has counted, at a clock frequency. */
  function showTimes() {
    const megahertz = Number($("#megahertz")?.value) || 100;
    for (const one of document.querySelectorAll("[data-clocks]")) one.textContent = `${Number((one.dataset.clocks / megahertz).toPrecision(3))} µs`;
    for (const one of document.querySelectorAll("[data-per-event]")) one.textContent = `${Number((megahertz / one.dataset.perEvent).toPrecision(3))} M/s`;
  }

  /** The address may name a time, and an object or a track: #at=385978&see=4, or see=hardware-14. */
  function goToAddress(hash) {
    const parts = new URLSearchParams(hash.replace(/^#/, ""));
    const [at, see] = [Number(parts.get("at") ?? NaN), parts.get("see") ?? ""];
    if (Number.isFinite(at)) seek(at);
    const [, name, id] = /^([a-z0-9_]+)-(.*)$/s.exec(see) ?? [];
    const side = sides.find((one) => one.name === name);
    const life = side ? side.ids.indexOf(id) : -1;
    if (see) select(life >= 0 ? side.object[life] : Number(see));
  }

  const acts = {
    toggle: () => clock.toggle(), begin: () => seek(0), end: () => seek(facts.duration),
    nudge: (direction) => seek(clock.now + direction * NUDGE_S * 1e6 * clock.speed),
    faster: (direction) => transport.faster(direction),
    back: () => step($("#what").value, -1), forward: () => step($("#what").value, 1), step,
    zoomIn: () => view.zoom(1.5), zoomOut: () => view.zoom(1 / 1.5), fit: () => { following = false; view.fit(); },
    timeIn: () => { axis.zoomAt(2, clock.now); restyle(); }, timeOut: () => { axis.zoomAt(0.5, clock.now); restyle(); },
    timeFit: () => { axis.fit(); restyle(); },
    zoomTo: () => {
      const object = objects.byNumber.get(selected);
      if (!object) return;
      axis.place(0, Math.min(Math.max(1.1 * (object.end - object.birth), 1000), axis.duration));
      axis.place(object.birth - 0.05 * axis.span);
      restyle();
    },
    fade: (direction) => { rail.elements.fade.stepUp(3 * direction); rail.dispatchEvent(new Event("input")); },
    side: (i) => { const box = rail.querySelectorAll("[data-side]")[i]; if (box && !box.disabled) box.click(); },
    next: (direction) => {
      const numbers = [...present.keys()].sort((a, b) => a - b);
      const at = numbers.indexOf(selected);
      if (numbers.length) select(numbers[(at + direction + (at < 0 && direction < 0 ? 1 : 0) + numbers.length) % numbers.length]);
    },
    follow: () => { following = !following; clock.invalidate(); },
    find: () => { tabs.show("objects"); list.find?.focus(); },
    theme: () => $("#theme").click(), unselect: () => select(0), keys: () => $("#keys").togglePopover(),
    tab: (letter) => tabs.show(tabs.initial(letter)),
    layers: () => rail.classList.toggle("open"),
  };

  document.addEventListener("click", (event) => {
    const button = event.target.closest("[data-act], [data-at], [data-heat], [data-pixel], #cover tr, a[href^='#at=']");
    if (!button) return;
    if (button.dataset.act) acts[button.dataset.act]();
    if (button.dataset.at) seek(Number(button.dataset.at));
    if (button.dataset.number) select(Number(button.dataset.number));
    if (button.matches("a")) { event.preventDefault(); goToAddress(button.getAttribute("href")); }
    if (button.dataset.pixel) {
      const [x, y] = button.dataset.pixel.split(" ").map(Number);
      pixel = pixel?.x === x && pixel?.y === y ? null : { x, y };
      clock.invalidate();
    }
    if ("heat" in button.dataset) {
      const on = button.ariaPressed !== "true";
      for (const one of document.querySelectorAll("[data-heat]")) one.ariaPressed = String(on && one === button);
      stage.overlay = on ? button.querySelector("img") : null;
      clock.invalidate();
    }
  });
  rail.addEventListener("input", () => { label(); restyle(); });
  rail.addEventListener("submit", (event) => event.preventDefault());
  for (const kind of ["pointermove", "pointerdown"]) stage.canvas.addEventListener(kind, hover);
  stage.canvas.addEventListener("pointerdown", () => rail.classList.remove("open"));
  $("#strip")?.addEventListener("pointerdown", (event) => seek((event.offsetX / $("#strip").clientWidth) * facts.duration));
  $("#megahertz")?.addEventListener("input", showTimes);
  addEventListener("hashchange", () => goToAddress(location.hash));
  listenToKeys(acts);
  listenToMenus();
  watchTheme($("#theme"), dress);
  theme = readTheme();
  stage.dress(theme);
  clock.seek(facts.start);
  listDifferences(objects, facts.merged);
  listCover(objects);
  label();
  showTimes();
  listenToSplitters(layOut);
  layOut();
  new ResizeObserver(layOut).observe(stage.canvas);
  goToAddress(location.hash);
  document.documentElement.dataset.ready = "true";
  if (parent !== window) parent.postMessage("evcot-ready", "*"); // to the overview of a long run
  window.report = { clock, axis, stage, sides, objects, recording, steps, timeline, selected: () => selected, draw };
}

start().catch((error) => {
  document.documentElement.dataset.broken = "true";
  $("#broken").textContent = `This page cannot be shown: the file is damaged (${error.message}).`;
});
