// SPDX-License-Identifier: Apache-2.0
// The overview of a long run: curves over its parts, and the page of the part that is chosen.

const { parts, sides } = JSON.parse(document.getElementById("facts").textContent);
const number = document.getElementById("number");
const frame = document.querySelector("iframe.part");
const lost = document.getElementById("lost");
const WIDTH = 1000;
const HEIGHT = 64;
const CURVES = {
  rate: [["plain", (part) => (1e6 * part.events) / Math.max(part.to_us - part.from_us, 1)]],
  alive: sides.map((side) => [side.look, (part) => part[`alive_${side.name}`]]),
  paired: [["plain", (part) => part.paired_fraction]],
};
const READY_MS = 5000; // a page that does not say within so long after it has loaded that it is ready is missing or damaged
const end = Math.max(parts[parts.length - 1].to_us, 1);

function at(us) {
  return (WIDTH * us) / end;
}

function element(name, attributes) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

function draw(strip) {
  const curves = CURVES[strip.dataset.curve];
  const most = Math.max(...curves.flatMap(([, value]) => parts.map((part) => value(part) ?? 0)), 1e-9);
  for (const [look, value] of curves) {
    const steps = parts.map((part) => {
      const y = HEIGHT - 2 - ((HEIGHT - 4) * (value(part) ?? 0)) / most;
      return `L${at(part.from_us)} ${y}L${at(part.to_us)} ${y}`;
    });
    strip.append(element("path", { class: look, d: `M${steps.join("").slice(1)}` }));
  }
  strip.addEventListener("click", (event) => {
    const box = strip.getBoundingClientRect();
    const us = ((event.clientX - box.left) / box.width) * end;
    const found = parts.findIndex((part) => us < part.to_us);
    choose(found < 0 ? parts.length - 1 : found);
  });
}

let [timer, ready] = [0, false];

function showPage(page) {
  clearTimeout(timer);
  ready = false;
  lost.textContent = `${page} cannot be shown: it must be beside this page, whole, as evcot wrote it.`;
  showLost(false);
  frame.src = page;
}

function showLost(isLost) {
  frame.hidden = isLost;
  lost.hidden = !isLost;
}

frame.addEventListener("load", () => {
  clearTimeout(timer);
  if (!ready) timer = setTimeout(() => showLost(true), READY_MS);
});
addEventListener("message", ({ source, data }) => {
  if (source !== frame.contentWindow || data !== "evcot-ready") return;
  clearTimeout(timer);
  ready = true;
  showLost(false);
});

function choose(index) {
  const part = parts[Math.min(Math.max(index, 0), parts.length - 1)];
  number.value = parts.indexOf(part) + 1;
  showPage(part.page);
  document.getElementById("own").href = part.page;
  const seconds = [part.from_us, part.to_us].map((us) => (us / 1e6).toFixed(3));
  document.getElementById("said").textContent = `${seconds[0]} s to ${seconds[1]} s, ${part.events.toLocaleString("en")} events, ${part.grade}`;
  for (const strip of document.querySelectorAll(".strip")) {
    strip.querySelector(".chosen")?.remove();
    strip.prepend(element("rect", { class: "chosen", x: at(part.from_us), y: 0, width: Math.max(at(part.to_us - part.from_us), 1), height: HEIGHT }));
  }
}

document.querySelectorAll(".strip").forEach(draw);
number.addEventListener("change", () => choose(Number(number.value) - 1));
document.querySelectorAll("[data-step]").forEach((button) => {
  button.addEventListener("click", () => choose(Number(number.value) - 1 + Number(button.dataset.step)));
});
choose(0);
