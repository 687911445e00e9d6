// SPDX-License-Identifier: Apache-2.0
// Keyboard shortcuts; inactive while an input or a slider has the focus.

const STEPS = { e: "event", u: "update", m: "merge", b: "birth", l: "loss", d: "difference" };

/** `acts`: actions by name. */
export function listenToKeys(acts) {
  const plain = {
    " ": acts.toggle, ArrowLeft: () => acts.nudge(-1), ArrowRight: () => acts.nudge(1), Home: () => acts.jump(0),
    End: () => acts.jump(1), "<": () => acts.faster(-1), ">": () => acts.faster(1), "+": () => acts.zoom(1.5),
    "=": () => acts.zoom(1.5), "-": () => acts.zoom(1 / 1.5), 0: acts.fit, "[": () => acts.decay(-1), "]": () => acts.decay(1),
    1: () => acts.side(0), 2: () => acts.side(1), 3: () => acts.side(2), Escape: acts.unselect, "?": acts.help,
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const field = event.target.closest("input, select, textarea, button, a, summary, .places");
    const own = field && (field.matches("input[type=range], select, textarea, .places") || event.key === " ");
    if (own) return;
    const step = STEPS[event.key.toLowerCase()];
    if (step) acts.step(step, event.shiftKey ? -1 : 1);
    else if (plain[event.key]) plain[event.key]();
    else return;
    event.preventDefault();
  });
}
