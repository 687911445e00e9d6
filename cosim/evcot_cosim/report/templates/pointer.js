// SPDX-License-Identifier: Apache-2.0
// Zoom, pan and clicks of a Stage by mouse, wheel and touch.

const CLICK_PX = 4; // a pointer that moves further drags

/** Calls `changed()` after the stage's view has moved, and `clicked(event)`. */
export function zoomable(stage, changed, clicked = () => {}) {
  const { canvas } = stage;
  const fingers = new Map();
  let moved = 0;
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    stage.zoomAt(Math.exp(-event.deltaY / 300), event.clientX, event.clientY);
    changed();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (!fingers.size) moved = 0;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : null;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    moved += Math.hypot(event.clientX - last.x, event.clientY - last.y);
    if (before) {
      const after = spread();
      stage.pan(after.x - before.x, after.y - before.y);
      stage.zoomAt(after.apart / Math.max(before.apart, 1), after.x, after.y);
    } else if (moved > CLICK_PX) {
      stage.pan(event.clientX - last.x, event.clientY - last.y);
    }
    changed();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (fingers.size === 1 && moved <= CLICK_PX) clicked(event);
    fingers.delete(event.pointerId);
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
  return {
    zoom(factor) {
      const box = canvas.getBoundingClientRect();
      stage.zoomAt(factor, box.left + box.width / 2, box.top + box.height / 2);
      changed();
    },
    fit() {
      stage.fit();
      changed();
    },
  };
}
