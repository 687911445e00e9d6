// SPDX-License-Identifier: Apache-2.0
// Zoom and pan of a Stage by mouse, wheel and touch. A plain wheel, and one finger without zoom, scroll the page.

const DOUBLE_CLICK = 2;

/** Calls `changed()` after the stage's view has moved. */
export function zoomable(stage, changed) {
  const { canvas } = stage;
  const fingers = new Map();
  const settle = () => {
    canvas.style.touchAction = stage.zoom > 1 ? "none" : "pan-y";
    canvas.style.cursor = stage.zoom > 1 ? "grab" : "crosshair";
    changed();
  };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    stage.zoomAt(Math.exp(-event.deltaY / 300), event.clientX, event.clientY);
    settle();
  }, { passive: false });
  canvas.addEventListener("dblclick", (event) => {
    stage.zoomAt(event.shiftKey ? 1 / DOUBLE_CLICK : DOUBLE_CLICK, event.clientX, event.clientY);
    settle();
  });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : null;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (before) {
      const after = spread();
      stage.pan(after.x - before.x, after.y - before.y);
      stage.zoomAt(after.apart / Math.max(before.apart, 1), after.x, after.y);
    } else {
      stage.pan(event.clientX - last.x, event.clientY - last.y);
    }
    settle();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  return {
    zoom(factor) {
      const box = canvas.getBoundingClientRect();
      stage.zoomAt(factor, box.left + box.width / 2, box.top + box.height / 2);
      settle();
    },
    fit() {
      stage.fit();
      settle();
    },
  };
}
