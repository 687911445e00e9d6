// SPDX-License-Identifier: Apache-2.0
// Recent positions of each cluster.

const POINTS_MAX = 400;

class Trails {
  constructor() {
    this.byId = new Map();
  }

  /** Add a frame's clusters; trails of clusters that are no longer visible are removed. */
  add(clusters) {
    const now = new Map();
    for (const { id, x, y } of clusters) {
      const trail = this.byId.get(id) ?? [];
      const n = trail.length;
      if (!n || Math.hypot(trail[n - 2] - x, trail[n - 1] - y) > 0.5) trail.push(x, y);
      if (trail.length > 2 * POINTS_MAX) trail.splice(0, trail.length - 2 * POINTS_MAX);
      now.set(id, trail);
    }
    this.byId = now;
  }

  of(id) {
    return this.byId.get(id) ?? null;
  }
}
