// SPDX-License-Identifier: Apache-2.0
// Received frames are drawn at the next animation frame and acknowledged; without a server the page reconnects by itself.

const POINTS_MAX = 400; // of a trail

const key = (lane, id) => lane * 2 ** 32 + id;

/** Recent positions of each cluster. */
class Trails {
  constructor() {
    this.byId = new Map();
  }

  /** Add a frame's clusters; trails of clusters that are no longer visible are removed. */
  add(clusters) {
    const now = new Map();
    for (const { id, lane, x, y } of clusters) {
      const trail = this.of(lane, id) ?? [];
      const n = trail.length;
      if (!n || Math.hypot(trail[n - 2] - x, trail[n - 1] - y) > 0.5) trail.push(x, y);
      if (trail.length > 2 * POINTS_MAX) trail.splice(0, trail.length - 2 * POINTS_MAX);
      now.set(key(lane, id), trail);
    }
    this.byId = now;
  }

  of(lane, id) {
    return this.byId.get(key(lane, id)) ?? null;
  }
}

const RECONNECT_MS = [500, 1000, 2000, 4000];
const TABLE_MS = 250;
const ENDED = "ended; a new run at this address is shown by itself";

const rail = document.getElementById("rail");
const canvas = document.getElementById("picture");
const pauseButton = document.getElementById("pause");
const live = { stage: null, surface: null, trails: new Trails(), waiting: [], clusters: [], now: 0, speed: 1, kinds: [], labels: [], socket: null, tries: 0, tabled: 0, ended: false };

function showState(state, text) {
  const place = document.getElementById("state");
  place.dataset.state = state;
  if (place.textContent !== text) place.textContent = text;
}

function dress() {
  live.theme = readTheme();
  live.stage?.dress(live.theme);
  draw();
}

function layOut() {
  live.stage?.resize();
  draw();
}

function begin(hello) {
  document.getElementById("title").textContent = hello.name;
  const preset = hello.preset ?? "default preset";
  document.getElementById("what").textContent = `${hello.engine}, ${preset} · ${hello.width}×${hello.height} px`;
  showChoice(hello);
  showLanes(hello.lanes, hello.kinds);
  document.title = `${hello.name} · evcot live`;
  for (const [name, size] of [["--wide", hello.width], ["--high", hello.height]]) document.getElementById("app").style.setProperty(name, size);
  Object.assign(live, { speed: hello.speed, kinds: hello.kinds, labels: hello.labels, trails: new Trails(), waiting: [], clusters: [], surface: new EventSurface(hello.width, hello.height) });
  const seen = live.stage?.sensor;
  if (!seen || seen.width !== hello.width || seen.height !== hello.height) {
    live.stage = new Stage(canvas, hello.width, hello.height);
    live.zoom = zoomable(live.stage, draw);
  }
  live.stage.resize();
  dress();
}

function onMessage(event) {
  if (typeof event.data !== "string") {
    const frame = parseFrame(event.data);
    if (frame) live.waiting.push(frame);
    if (live.waiting.length === 1) requestAnimationFrame(show);
    return;
  }
  const message = JSON.parse(event.data);
  if (message.type === "hello") begin(message);
  if (message.type !== "figures") return;
  showFigures(message);
  showPlace(message);
  live.ended = !message.running;
  showState(live.ended ? "ended" : "live", live.ended ? "ended" : "live");
}

/** Apply and draw all received frames, then acknowledge them. */
function show() {
  const frames = live.waiting.splice(0);
  for (const { t, clusters, events } of frames) {
    live.now = t;
    if (pauseButton.ariaPressed === "true") continue;
    addEvents(events);
    live.trails.add(clusters);
    live.clusters = clusters;
  }
  if (pauseButton.ariaPressed !== "true") draw();
  for (const { number } of frames) if (live.socket?.readyState === WebSocket.OPEN) live.socket.send(drawnMessage(number));
  if (performance.now() - live.tabled > TABLE_MS) {
    live.tabled = performance.now();
    showClusters(live.clusters, live.labels);
  }
}

function addEvents({ t, x, y, p, filtered }) {
  const all = rail.elements.filtered.checked;
  for (let i = 0, from = 0; i <= t.length; i++) {
    if (i < t.length && (all || !filtered[i])) continue;
    if (from < i) live.surface.add(t, x, y, p, from, i);
    from = i + 1;
  }
}

function draw() {
  if (!live.stage) return;
  const option = (name) => rail.elements[name].checked;
  const tags = [];
  const layers = live.kinds.map((kind, lane) => {
    const boxes = live.clusters.filter((cluster) => cluster.lane === lane).map(({ id, x, y, width, height, angle, label }) => {
      const trail = option("trails") ? live.trails.of(lane, id) : null;
      const box = { x, y, angle, halfWidth: width / 2, halfHeight: height / 2, trail, strong: false };
      const there = lane > 0 && tags.some((tag) => tag.parts[0][0] === String(id) && Math.hypot(tag.box.x - x, tag.box.y - y) < 1);
      if (option("numbers") && !there) tags.push({ box, parts: [String(id), live.labels[label]].filter(Boolean).map((text) => [text]), strong: false }); // one number where both agree
      return box;
    });
    return { ...live.theme.sides[kind], boxes: option("boxes") ? boxes : [], marks: [] };
  });
  live.stage.draw(live.surface, live.now, (fadeMs() / 5) * live.speed, layers, tags);
}

function fadeMs() {
  return 10 ** Number(rail.elements.fade.value);
}

function connect() {
  const socket = new WebSocket(`ws://${location.host}/events`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { live.tries = 0; };
  socket.onmessage = onMessage;
  socket.onclose = ({ reason }) => {
    choice.hidden = true; // without a server nothing can be chosen
    if (live.ended) showState("ended", ENDED); // what the last figures have said; the page goes on when a new run begins
    else showState("lost", reason || "no connection, trying again");
    setTimeout(connect, RECONNECT_MS[Math.min(live.tries++, RECONNECT_MS.length - 1)]);
  };
  live.socket = socket;
}

const acts = {
  toggle() {
    pauseButton.ariaPressed = String(pauseButton.ariaPressed !== "true");
    pauseButton.textContent = pauseButton.ariaPressed === "true" ? "Resume" : "Pause";
  },
  zoomIn: () => live.zoom?.zoom(1.5), zoomOut: () => live.zoom?.zoom(1 / 1.5), fit: () => live.zoom?.fit(),
  fade(direction) {
    rail.elements.fade.stepUp(3 * direction);
    rail.dispatchEvent(new Event("input"));
  },
  theme: () => document.getElementById("theme").click(),
  layers: () => rail.classList.toggle("open"),
};
for (const button of document.querySelectorAll("[data-act]")) button.addEventListener("click", () => acts[button.dataset.act]());
onWish((wish) => {
  if (live.socket?.readyState === WebSocket.OPEN) live.socket.send(playMessage(wish));
});
rail.addEventListener("input", () => {
  rail.querySelector("output").textContent = `${Number(fadeMs().toPrecision(2))} ms`;
  draw();
});
rail.addEventListener("submit", (event) => event.preventDefault());
rail.dispatchEvent(new Event("input"));
new ResizeObserver(layOut).observe(canvas);
listenToKeys(acts);
listenToSplitters(layOut);
watchTheme(document.getElementById("theme"), dress);
connect();
