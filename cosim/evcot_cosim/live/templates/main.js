// SPDX-License-Identifier: Apache-2.0
// Received frames are drawn at the next animation frame and acknowledged; without a server the page reconnects by itself.

const RECONNECT_MS = [500, 1000, 2000, 4000];
const TABLE_MS = 250;
const AHEAD_S = 0.1; // of the recording: the way that an arrow shows
const ENDED = "ended; a new run at this address is shown by itself";

const controls = document.getElementById("controls");
const canvas = document.getElementById("stage");
const pauseButton = document.getElementById("pause");
const live = { stage: null, surface: null, trails: new Trails(), waiting: [], clusters: [], now: 0, speed: 1, kinds: [], socket: null, tries: 0, tabled: 0, ended: false };

function showState(state, text) {
  const place = document.getElementById("state");
  place.dataset.state = state;
  if (place.textContent !== text) place.textContent = text;
}

function applyColours() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(`--${name}`).trim();
  const rgb = (name) => [1, 3, 5].map((at) => parseInt(of(name).slice(at, at + 2), 16));
  live.colours = { software: of("software"), model: of("model"), hardware: of("hardware") };
  live.stage?.dress({ ground: rgb("ground"), off: rgb("off"), on: rgb("on"), edge: of("edge"), font: of("font") });
}

function begin(hello) {
  document.getElementById("name").textContent = hello.name;
  const preset = hello.preset ?? "default preset";
  document.getElementById("what").textContent = `${hello.engine}, ${preset} · ${hello.width}×${hello.height} px`;
  showChoice(hello);
  showLanes(hello.lanes, hello.kinds);
  document.title = `${hello.name} · evcot live`;
  document.documentElement.style.setProperty("--sensor", `${hello.width} / ${hello.height}`);
  Object.assign(live, { speed: hello.speed, kinds: hello.kinds, trails: new Trails(), waiting: [], clusters: [], surface: new EventSurface(hello.width, hello.height) });
  const seen = live.stage?.sensor;
  if (!seen || seen.width !== hello.width || seen.height !== hello.height) {
    live.stage = new Stage(canvas, hello.width, hello.height);
    live.zoom = zoomable(live.stage, draw);
  }
  applyColours();
  live.stage.resize();
  draw();
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
    showClusters(live.clusters);
  }
}

function addEvents({ t, x, y, p, filtered }) {
  const all = controls.filtered.checked;
  for (let i = 0, from = 0; i <= t.length; i++) {
    if (i < t.length && (all || !filtered[i])) continue;
    if (from < i) live.surface.add(t, x, y, p, from, i);
    from = i + 1;
  }
}

function draw() {
  if (!live.stage) return;
  const show = { box: controls.boxes.checked, inner: false, id: controls.ids.checked, trail: controls.trails.checked, velocity: controls.velocity.checked };
  const layers = live.kinds.map((kind, lane) => {
    const clusters = live.clusters.filter((cluster) => cluster.lane === lane).map(({ id, x, y, width, height, angle, vx, vy }) => {
      const trail = live.trails.of(lane, id);
      return { id, x, y, angle, vx, vy, halfWidth: width / 2, halfHeight: height / 2, inner: null, trail, strong: false };
    });
    const dash = kind === "model" ? [6, 4] : []; // as in the report: solid is hardware
    return { colour: live.colours[kind], dash, width: 1.8, show, ahead: AHEAD_S, clusters, corner: kind === "hardware" ? "right" : "left" };
  });
  const decay = Number(controls.decay.value) * live.speed;
  live.stage.draw(live.surface, live.now, decay, layers);
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

pauseButton.addEventListener("click", () => {
  pauseButton.ariaPressed = String(pauseButton.ariaPressed !== "true");
  pauseButton.textContent = pauseButton.ariaPressed === "true" ? "Resume" : "Pause";
});
document.getElementById("fit").addEventListener("click", () => live.zoom?.fit());
onWish((wish) => {
  if (live.socket?.readyState === WebSocket.OPEN) live.socket.send(playMessage(wish));
});
controls.addEventListener("input", draw);
controls.addEventListener("submit", (event) => event.preventDefault());
new ResizeObserver(() => { if (live.stage?.resize()) draw(); }).observe(canvas);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { applyColours(); draw(); });
connect();
