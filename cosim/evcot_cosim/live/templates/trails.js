// SPDX-License-Identifier: Apache-2.0
// Recent positions of each cluster.

const POINTS_MAX = 400;

const key = (lane, id) => lane * 2 ** 32 + id;

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
