// SPDX-License-Identifier: Apache-2.0
// Entry point of the page: one clock, one selection, and all views of them.
import { Axis, timeText } from "./axis.js";
import { Clock } from "./clock.js";
import { AlivePanel, PointPanel, QuietPanel, RatePanel } from "./curves.js";
import { describe } from "./hover.js";
import { listenToKeys } from "./keys.js";
import { Layers } from "./layers.js";
import { followLinks } from "./links.js";
import { LivesPanel } from "./lives.js";
import { PlaceList, countWhen, rowsOfLives } from "./places.js";
import { zoomable } from "./pointer.js";
import { Present } from "./present.js";
import { Recording } from "./recording.js";
import { Stage } from "./stage.js";
import { Steps } from "./steps.js";
import { readTheme, watchTheme } from "./theme.js";
import { Timeline } from "./timeline.js";
import { MERGED, Tracks } from "./tracks.js";
import { Transport } from "./transport.js";
import { unpack } from "./unpack.js";

const READ_EVERY = 120; // ms between two updates of the values as text
const NUDGE = 0.1; // seconds of playing that an arrow key moves by
const FLASH = 0.35; // seconds of playing for which an end stays marked

const $ = (selector) => document.querySelector(selector);

async function start() {
  const facts = JSON.parse($("#facts").textContent);
  const columns = await unpack($("#columns").textContent, facts.columns, {
    x: Uint16Array, y: Uint16Array, p: Uint8Array, owner: facts.owners.length > 0x10000 ? Uint32Array : Uint16Array,
  });
  $("#columns").remove();
  const recording = new Recording(facts, columns);
  const sides = facts.sides.map((side) => new Tracks(side, columns));
  const engines = sides.filter((side) => side.engine);
  const apart = ["merges", "lives"].flatMap((name) => facts.lists[name]?.rows ?? []);
  const steps = new Steps(recording, sides, apart, facts.mismatch);
  const axis = new Axis(facts.duration);
  const stage = new Stage($("#stage"), recording.surface.width, recording.surface.height);
  let theme = readTheme();
  stage.dress(theme.stage);
  let selected = null;
  let lastRead = 0;
  let frames = 0;

  const clock = new Clock(facts.duration, draw);
  const layers = new Layers($("#layers"), restyle);
  const transport = new Transport($("#transport"), clock, step);
  const view = zoomable(stage, () => clock.invalidate());
  const timeline = new Timeline($("#timeline"), axis, {
    rate: new RatePanel(recording, facts.duration),
    lives: new LivesPanel(sides, $("#lives").clientHeight),
    alive: new AlivePanel(sides),
    size: new PointPanel(sides, { value: (side) => side.meanSide, unit: " px" }),
    ...($("#nev") && { nev: new PointPanel(sides.filter((side) => side.hardware), { value: (side) => side.nEv, unit: "" }) }),
    quiet: new QuietPanel(sides),
  }, { seek: (time) => go(time), choose: ({ side, life, at }) => go(at, side, life), changed: restyle });

  const lists = placeLists();
  const present = new Present($("#alive-now"), $("#alive-count"), sides, (side, life) => go(clock.now, side, life));

  /** The lists of places that the page has: differences and merges of hardware and software, and every side's lives. */
  function placeLists() {
    const named = (name) => sides.find((side) => side.name === name);
    const ends = (side) => (life) => (side.ended[life] === MERGED && side.other[life] >= 0 ? `, into ${side.ids[side.other[life]]}` : "");
    return [...document.querySelectorAll("[data-list]")].filter((root) => root.querySelector(".places")).map((root) => {
      const given = facts.lists[root.dataset.list];
      if (given) {
        const rows = given.rows.map(([at, name, id, text]) => ({ at, side: named(name), id, text }));
        return new PlaceList(root, rows, Object.entries(given.when).map(([name, counts]) => [named(name), counts]), facts.duration);
      }
      const side = named(root.dataset.list);
      return new PlaceList(root, rowsOfLives(side, ends(side)), [[side, countWhen(side.birth, facts.duration)]], facts.duration);
    });
  }

  /** Update everything that depends on the time, once a frame. */
  function draw() {
    const { now } = clock;
    const seen = layers.seen(sides);
    recording.show(now, layers.decay, layers.polarities);
    stage.draw(recording.surface, now, layers.decay, layersAt(now));
    if (clock.playing && axis.zoomed && axis.follow(now)) timeline.stale = true;
    timeline.draw(now, theme, selected, seen);
    transport.draw(timeText(now));
    $("#time").textContent = timeText(now, 1);
    const at = performance.now();
    if (!clock.playing || at - lastRead > READ_EVERY) {
      lastRead = at;
      timeline.read(now, theme, selected, seen);
      present.draw(now, seen, selected);
      $("#number").textContent = `event ${recording.upTo(now).toLocaleString("en")} of ${recording.t.length.toLocaleString("en")}`;
    }
    frames += 1;
  }

  function layersAt(now) {
    const since = now - FLASH * 1e6 * clock.speed;
    return sides.map((side) => {
      const show = layers.of(side.name);
      const any = Object.values(show).some(Boolean);
      const style = theme.sides[side.look];
      const lives = any ? side.livesAt(now) : [];
      const clusters = lives.map((life) => {
        const strong = selected?.side === side && selected.life === life;
        return inCells(side.cluster(life, now, show.trail ? layers.trail : 0, strong));
      });
      return { ...style, show, clusters, ahead: layers.trail / 4e6, marks: any && side.engine ? side.marks(since, now).map(inCells) : [] };
    }); // dashed lines over the hardware's solid ones: where they coincide, both are visible
  }

  /** Positions are in pixels of the sensor; for very large sensors the stage merges several pixels into one. */
  function inCells(thing) {
    if (recording.cell === 1) return thing;
    const scaled = { ...thing };
    for (const name of ["x", "y", "inner", "halfWidth", "halfHeight", "vx", "vy"]) if (thing[name]) scaled[name] = thing[name] / recording.cell;
    if (thing.trail) scaled.trail = thing.trail.map((value) => value / recording.cell);
    return scaled;
  }

  function restyle() {
    timeline.stale = true;
    clock.invalidate();
  }

  /** Go to a time, and select a track if one is given. */
  function go(at, side = null, life = -1) {
    clock.pause();
    clock.seek(at);
    axis.follow(at);
    if (side && life >= 0) look(side, life);
    restyle();
  }

  function look(side, life) {
    selected = { side, life };
    const place = inCells(side.cluster(life, clock.now, 0, false));
    if (!stage.sees(place.x, place.y)) stage.moveTo(place.x, place.y);
    $("#chosen").textContent = `${side.name} ${side.ids[life]}`;
  }

  function step(kind, direction) {
    const found = steps.find(kind, clock.now, direction, layers.seen(sides));
    const named = kind === "update" ? (engines.some((side) => side.hardware) ? "update of a centre (CM)" : "move") : kind;
    if (!found) {
      $("#said").textContent = `No ${named} ${direction > 0 ? "after" : "before"} this time.`;
      return;
    }
    const side = sides.find((one) => one.name === found.side);
    go(found.at, side, found.life);
    $("#said").textContent = `${named} at ${timeText(found.at)}${side && found.life >= 0 ? `: ${side.name} ${side.ids[found.life]}` : ""}`;
  }

  function hover(event) {
    const place = stage.toSensor(event.clientX, event.clientY);
    const [x, y] = [Math.round(place.x), Math.round(place.y)];
    const { surface, cell } = recording;
    const inside = x >= 0 && y >= 0 && x < surface.width && y < surface.height;
    const found = inside ? surface.nearest(x, y, clock.now, layers.decay) : -1;
    const words = inside ? describe(recording, engines, found, x * cell, y * cell) : [];
    $("#hover").replaceChildren(...words.flatMap(([name, value]) => {
      const [term, text] = [document.createElement("dt"), document.createElement("dd")];
      [term.textContent, text.textContent] = [name, value];
      return [term, text];
    }));
  }

  function layOut() {
    stage.resize();
    timeline.resize();
    for (const list of lists) {
      list.resize();
      list.draw(theme);
    }
    draw();
  }

  function dress() {
    theme = readTheme();
    stage.dress(theme.stage);
    layOut(); // at once: a printer does not wait for the next frame
  }

  for (const kind of ["pointermove", "pointerdown"]) stage.canvas.addEventListener(kind, hover);
  stage.canvas.addEventListener("pointerleave", () => $("#hover").replaceChildren());
  for (const button of document.querySelectorAll("[data-act]")) {
    button.addEventListener("click", () => acts[button.dataset.act]());
  }
  const acts = {
    toggle: () => clock.toggle(),
    nudge: (direction) => go(clock.now + direction * NUDGE * 1e6 * clock.speed),
    jump: (part) => go(part * facts.duration),
    faster: (direction) => transport.faster(direction),
    zoom: (factor) => view.zoom(factor),
    zoomIn: () => view.zoom(1.5),
    zoomOut: () => view.zoom(1 / 1.5),
    fit: () => view.fit(),
    decay: (direction) => layers.slower(direction),
    side: (i) => sides[i] && layers.toggle(sides[i].name),
    unselect: () => {
      selected = null;
      $("#chosen").textContent = "none";
      restyle();
    },
    help: () => $("#help").showModal(),
    timeIn: () => { axis.zoomAt(2, clock.now); restyle(); },
    timeOut: () => { axis.zoomAt(0.5, clock.now); restyle(); },
    timeFit: () => { axis.fit(); restyle(); },
    copy: () => navigator.clipboard?.writeText($("#command").textContent).then(() => ($("#said").textContent = "Copied."), () => {}),
    step,
  };
  listenToKeys(acts);
  watchTheme($("#theme"), dress);
  new ResizeObserver(layOut).observe($("#workspace"));
  for (const details of document.querySelectorAll("details")) details.addEventListener("toggle", layOut);
  clock.seek(facts.start);
  layOut();
  followLinks(({ at, side, id }) => {
    const tracks = sides.find((one) => one.name === side);
    go(at, tracks, tracks?.rows.get(id) ?? -1);
    $("#playback").scrollIntoView({ block: "start" });
  });
  $("#workspace").dataset.ready = "true";
  window.report = { clock, axis, stage, sides, recording, steps, layers, lists, selection: () => selected, frames: () => frames };
}

start().catch((error) => {
  $("#said").textContent = `The playback cannot be shown: ${error.message}`;
  throw error;
});
