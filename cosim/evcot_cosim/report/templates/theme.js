// SPDX-License-Identifier: Apache-2.0
// Canvas colours from the style sheet, and the switch between dark and light theme.

// Engines differ in dash pattern too, not in colour alone.
const LINES = {
  hardware: { dash: [], width: 1.8, corner: "left" },
  software: { dash: [6, 4], width: 1.5, corner: "right" },
  model: { dash: [6, 4], width: 1.5, corner: "right" },
  other1: { dash: [3, 3], width: 1.5, corner: "left" },
  other2: { dash: [9, 3], width: 1.5, corner: "right" },
  other3: { dash: [2, 2, 6, 2], width: 1.5, corner: "below" },
  other4: { dash: [1, 2], width: 1.8, corner: "left" },
  truth: { dash: [2, 3], width: 1.5, corner: "below" },
};
const WORDS = { auto: "as the system", light: "light", dark: "dark" };
const NEXT = { auto: "light", light: "dark", dark: "auto" };

function rgb(text) {
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
}

/** The current colours of the style sheet; those of sides by name. */
export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(`--${name}`).trim();
  const sides = Object.fromEntries(Object.entries(LINES).map(([name, line]) => {
    return [name, { ...line, colour: of(name), text: of(`${name}-text`) }];
  }));
  return {
    sides, ink: of("ink"), panel: of("panel"), quiet: of("quiet"), line: of("line"), font: of("font"),
    stage: { ground: rgb(of("ground")), off: rgb(of("off")), on: rgb(of("on")), edge: of("edge"), font: of("font") },
  };
}

/** Calls `changed` whenever colours change: by the button, the system, or for printing. */
export function watchTheme(button, changed) {
  const root = document.documentElement;
  const name = () => root.dataset.theme ?? "auto";
  const label = () => {
    button.textContent = `Colours: ${WORDS[name()]}`;
    button.setAttribute("aria-label", `Colours: ${WORDS[name()]}. Change to ${WORDS[NEXT[name()]]}.`);
  };
  button.addEventListener("click", () => {
    const next = NEXT[name()];
    if (next === "auto") delete root.dataset.theme;
    else root.dataset.theme = next;
    label();
    changed();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  label();
  watchPrinter(root, changed);
}

/** Printing uses the light theme: canvases must be redrawn first. */
function watchPrinter(root, changed) {
  let before;
  addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    root.dataset.theme = "light";
    changed();
  });
  addEventListener("afterprint", () => {
    if (before === undefined) delete root.dataset.theme;
    else root.dataset.theme = before;
    changed();
  });
  matchMedia("print").addEventListener("change", changed);
}
