// SPDX-License-Identifier: Apache-2.0
// What the window's panes share: tabs, splitters, menus under their buttons, commands to copy, canvases as large as their place,
// and keyboard shortcuts, which are inactive while one types.
import { kept } from "./theme.js";

const LEAST = { "--time-height": [120, 560], "--panel-width": [360, 900] };

/** Adapt a canvas to its place; returns its context, in pixels of the page, with its width and height. */
export function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [wide, high] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}

/** An element with text and attributes; a child that is falsy is left out. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children.filter(Boolean));
  return made;
}

/** Shows a tab by its name; calls `changed(name)`. */
export function tabbed(changed) {
  const tabs = [...document.querySelectorAll("#tabs [role=tab]")];
  const show = (name) => {
    const tab = tabs.find((one) => one.dataset.tab === name);
    if (!tab) return;
    for (const one of tabs) {
      one.setAttribute("aria-selected", String(one === tab));
      document.getElementById(`panel-${one.dataset.tab}`).hidden = one !== tab;
    }
    tab.scrollIntoView({ block: "nearest", inline: "nearest" });
    changed(name);
  };
  document.addEventListener("click", (event) => {
    const name = event.target.closest("[data-tab]")?.dataset.tab;
    if (name) show(name);
  });
  return { show, initial: (letter) => tabs.find((tab) => tab.textContent.trim()[0].toLowerCase() === letter)?.dataset.tab };
}

/** Menus open below their buttons; commands are copied. */
export function listenToMenus() {
  for (const menu of document.querySelectorAll(".pop")) {
    const button = document.querySelector(`[popovertarget="${menu.id}"]`);
    menu.addEventListener("toggle", ({ newState }) => {
      button?.setAttribute("aria-expanded", String(newState === "open"));
      if (newState !== "open" || !button || menu.id === "keys") return;
      const box = button.getBoundingClientRect();
      menu.style.left = `${Math.max(8, Math.min(box.left, innerWidth - menu.offsetWidth - 8))}px`;
      menu.style.top = `${box.bottom + 6}px`;
    });
  }
  document.addEventListener("click", (event) => {
    const button = event.target.closest("[data-copy]");
    if (!button) return;
    const done = () => { button.title = "Copied"; };
    navigator.clipboard?.writeText(button.dataset.copy).then(done, () => {});
  });
}

/** Panes are resized by dragging; a double-click restores the default. Calls `changed()`. */
export function listenToSplitters(changed) {
  const app = document.getElementById("app");
  for (const splitter of document.querySelectorAll("[data-split]")) {
    const name = splitter.dataset.split;
    const [least, most] = LEAST[name];
    const across = name === "--time-height";
    const place = (size) => {
      app.style.setProperty(name, `${Math.min(Math.max(size, least), most)}px`);
      changed();
    };
    const stored = Number(kept(`evcot${name}`));
    if (stored) place(stored);
    splitter.addEventListener("pointerdown", (event) => {
      splitter.setPointerCapture(event.pointerId);
      const begin = parseFloat(getComputedStyle(app).getPropertyValue(name));
      const from = across ? event.clientY : event.clientX;
      splitter.onpointermove = (move) => place(begin + from - (across ? move.clientY : move.clientX));
    });
    splitter.addEventListener("pointerup", () => {
      splitter.onpointermove = null;
      kept(`evcot${name}`, String(parseFloat(app.style.getPropertyValue(name)) || ""));
    });
    splitter.addEventListener("dblclick", () => {
      app.style.removeProperty(name);
      kept(`evcot${name}`, "");
      changed();
    });
  }
}

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
