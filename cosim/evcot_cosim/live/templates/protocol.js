// SPDX-License-Identifier: Apache-2.0
// Messages from and to the server; live/messages.py specifies the layout.

const FRAME = 1;
const DRAWN = 2;
const HEAD_BYTES = 32;
const CLUSTER_BYTES = 48;

/** Decode a FRAME message to {number, t, hidden, clusters, events: {t, x, y, p, filtered}}, times in ms since the first event; null
 * for another kind or version. */
function parseFrame(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== FRAME || view.getUint8(1) !== 4) return null;
  const [count, number] = [view.getUint16(2, true), view.getUint32(4, true)];
  const [n, hidden] = [view.getUint32(8, true), view.getUint32(12, true)];
  const t = view.getFloat64(16, true) / 1e3;
  const unit = view.getFloat32(24, true) / 1e3;
  const clusters = [];
  let at = HEAD_BYTES;
  for (let i = 0; i < count; i++, at += CLUSTER_BYTES) {
    const numbers = Array.from({ length: 9 }, (_, k) => view.getFloat32(at + 4 + 4 * k, true));
    const [x, y, width, height, angle, vx, vy, confidence, age] = numbers;
    const [id, lane, label] = [at, at + 40, at + 44].map((place) => view.getUint32(place, true));
    clusters.push({ id, x, y, width, height, angle, vx, vy, confidence, age, lane, label });
  }
  const words = () => {
    const column = new Uint16Array(buffer, at, n);
    at += Math.ceil((2 * n) / 4) * 4;
    return column;
  };
  const [x, y, age] = [words(), words(), words()];
  const flags = new Uint8Array(buffer, at, n);
  const events = { t: new Float64Array(n), x, y, p: new Uint8Array(n), filtered: new Uint8Array(n) };
  for (let i = 0; i < n; i++) {
    events.t[i] = t - age[i] * unit;
    events.p[i] = flags[i] & 1;
    events.filtered[i] = flags[i] >> 1;
  }
  return { number, t, hidden, clusters, events };
}

/** The `play` message: what to play next. */
function playMessage({ engine, preset, hardware, at }) {
  return JSON.stringify({ type: "play", engine, preset, hardware, at_s: at });
}

/** The DRAWN message that acknowledges a frame. */
function drawnMessage(number) {
  const view = new DataView(new ArrayBuffer(8));
  view.setUint8(0, DRAWN);
  view.setUint32(4, number, true);
  return view.buffer;
}
