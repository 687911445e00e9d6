// SPDX-License-Identifier: Apache-2.0
// What the window's panes share: tabs, splitters, menus under their buttons, commands to copy, canvases as large as their place.
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
