// SPDX-License-Identifier: Apache-2.0
// Canvas colours from the style sheet, and the switch between dark and light colours.

// Sides differ in dash pattern too, not in colour alone.
const LINES = {
  hardware: { dash: [], width: 1.75 }, software: { dash: [6, 3], width: 1.75 }, model: { dash: [6, 3], width: 1.75 },
  other1: { dash: [3, 3], width: 1.75 }, other2: { dash: [9, 3], width: 1.75 }, other3: { dash: [2, 2, 6, 2], width: 1.75 },
  other4: { dash: [1, 2], width: 1.75 }, truth: { dash: [2, 2.5], width: 1.75 },
};
const PLAIN = ["ink", "quiet", "line", "page", "panel", "raise", "accent", "on-accent", "tint", "poor", "edge"];
const OBJECTS = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#bbbbbb", "#997700", "#009988"];
const NEXT = { auto: "light", light: "dark", dark: "auto" };
const STORED = "evcot-theme";

/** The colour of an object, by its number. */
export function objectColour(number) {
  return OBJECTS[(number - 1) % OBJECTS.length];
}

/** The current colours of the style sheet; those of sides by name under `sides`, of the picture under `stage`. */
export function readTheme() {
  const probe = document.body.appendChild(document.createElement("i"));
  const of = (name) => {
    probe.style.color = `var(--${name})`;
    return getComputedStyle(probe).color;
  };
  const rgb = (name) => of(name).match(/[\d.]+/g).slice(0, 3).map(Number);
  const theme = Object.fromEntries(PLAIN.map((name) => [name.replace("-a", "A"), of(name)]));
  theme.font = getComputedStyle(document.body).fontFamily;
  theme.sides = Object.fromEntries(Object.entries(LINES).map(([name, line]) => [name, { ...line, colour: of(name) }]));
  theme.stage = { ground: rgb("ground"), off: rgb("off"), on: rgb("on") };
  probe.remove();
  return theme;
}

/** A value that the browser keeps for this kind of page; some browsers refuse to. */
export function kept(key, value) {
  try {
    if (value !== undefined) localStorage.setItem(key, value);
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

/** Calls `changed` whenever colours change: by the button, the system, or for printing. */
export function watchTheme(button, changed) {
  const root = document.documentElement;
  const apply = (name) => {
    if (name === "auto") delete root.dataset.theme;
    else root.dataset.theme = name;
    button.title = `Colours: ${name === "auto" ? "as the system" : name} (T)`;
    button.setAttribute("aria-label", button.title);
  };
  apply(kept(STORED) in NEXT ? kept(STORED) : "auto");
  button.addEventListener("click", () => {
    const next = NEXT[root.dataset.theme ?? "auto"];
    kept(STORED, next);
    apply(next);
    changed();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  let before;
  addEventListener("beforeprint", () => { // printing is light: canvases must be drawn again first
    before = root.dataset.theme ?? "auto";
    apply("light");
    changed();
  });
  addEventListener("afterprint", () => {
    apply(before);
    changed();
  });
}
