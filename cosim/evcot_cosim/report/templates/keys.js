// SPDX-License-Identifier: Apache-2.0
// Keyboard shortcuts; inactive while one types.

const STEPS = { e: "event", u: "update", m: "merge", b: "birth", l: "loss", d: "difference" };
const TAB_MS = 1200; // after G, in which an initial opens a tab

/** `acts`: actions by name; a key without one does nothing. */
export function listenToKeys(acts) {
  let asked = -Infinity; // when G was pressed
  const plain = {
    " ": acts.toggle, ArrowLeft: () => acts.nudge?.(-1), ArrowRight: () => acts.nudge?.(1), Home: acts.begin, End: acts.end,
    "<": () => acts.faster?.(-1), ">": () => acts.faster?.(1), "+": acts.zoomIn, "=": acts.zoomIn, "-": acts.zoomOut, 0: acts.fit,
    "[": () => acts.fade?.(-1), "]": () => acts.fade?.(1), 1: () => acts.side?.(0), 2: () => acts.side?.(1), 3: () => acts.side?.(2),
    j: () => acts.next?.(1), k: () => acts.next?.(-1), f: acts.follow, z: acts.zoomTo, "/": acts.find, t: acts.theme,
    Escape: acts.unselect, "?": acts.keys, g: () => { asked = performance.now(); },
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || (event.key === "Escape" && document.querySelector(":popover-open"))) return;
    const field = event.target.closest("input, select, button, a, summary");
    if (field?.matches("input[type=search], input[type=number]")) {
      if (event.key === "Escape") field.blur();
      return;
    }
    if (field && (field.matches("select, input[type=range]") || event.key === " ")) return;
    const letter = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (performance.now() - asked < TAB_MS && letter !== "g") {
      asked = -Infinity;
      acts.tab?.(letter);
    } else if (STEPS[letter]) acts.step?.(STEPS[letter], event.shiftKey ? -1 : 1);
    else if (plain[letter]) plain[letter]();
    else return;
    event.preventDefault();
  });
}
