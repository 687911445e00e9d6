// SPDX-License-Identifier: Apache-2.0
// Time surface: the latest event of every pixel, drawn with decay. The cost of drawing does not depend on the event rate.

const LEVELS = 256;
const CUT = 5; // decay times after which an event is no longer visible

/** Colours of one polarity from fresh to faded, as 32-bit words of an ImageData. */
export function fading(rgb, ground) {
  const words = new Uint32Array(LEVELS + 1);
  for (let level = 0; level <= LEVELS; level++) {
    const cover = (Math.exp((-CUT * level) / LEVELS) - Math.exp(-CUT)) / (1 - Math.exp(-CUT)); // the last is the bare ground
    const [r, g, b] = rgb.map((value, i) => Math.round(value * cover + ground[i] * (1 - cover)));
    words[level] = (255 << 24) | (b << 16) | (g << 8) | r; // all machines that run browsers are little-endian
  }
  return words;
}

export class EventSurface {
  constructor(width, height) {
    this.width = width;
    this.height = height;
    this.stamp = new Float64Array(width * height); // time of the pixel's latest event
    this.index = new Int32Array(width * height); // and its number
    this.polarity = new Uint8Array(width * height);
    this.clear();
  }

  clear() {
    this.stamp.fill(-Infinity);
    this.index.fill(-1);
  }

  /** Events `from` to `to` - 1 of four columns, in order of time; `shown` has bit 0 set for OFF and bit 1 for ON. */
  add(t, x, y, p, from, to, shown = 3) {
    const { stamp, index, polarity, width } = this;
    for (let i = from; i < to; i++) {
      if (!((shown >> p[i]) & 1)) continue;
      const cell = y[i] * width + x[i];
      stamp[cell] = t[i];
      index[cell] = i;
      polarity[cell] = p[i];
    }
  }

  /** Render the surface at time `now` to one word per pixel, with colours of `fading` for OFF and ON. */
  paint(words, now, decay, colours) {
    const { stamp, polarity } = this;
    const scale = LEVELS / (CUT * decay);
    const ground = colours[0][LEVELS];
    for (let cell = 0; cell < stamp.length; cell++) {
      const level = (now - stamp[cell]) * scale;
      words[cell] = level < LEVELS ? colours[polarity[cell]][level | 0] : ground;
    }
  }

  /** Age up to which an event is visible. */
  static reach(decay) {
    return CUT * decay;
  }

  /** Number of the visible event nearest to (x, y), at most `reach` pixels away on either axis; -1 if there is none. */
  nearest(x, y, now, decay, reach = 1) {
    let found = -1;
    let best = Infinity;
    for (let row = Math.max(0, y - reach); row <= Math.min(this.height - 1, y + reach); row++) {
      for (let column = Math.max(0, x - reach); column <= Math.min(this.width - 1, x + reach); column++) {
        const cell = row * this.width + column;
        const distance = Math.hypot(row - y, column - x);
        if (distance < best && now - this.stamp[cell] < EventSurface.reach(decay)) {
          best = distance;
          found = this.index[cell];
        }
      }
    }
    return found;
  }
}
