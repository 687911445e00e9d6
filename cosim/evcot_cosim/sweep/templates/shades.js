// SPDX-License-Identifier: Apache-2.0
// Colours by a figure, and a canvas that is as sharp as the screen.

// Steps of the viridis map: even in lightness, so that they order themselves without colour, too.
const STEPS = [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];

/** A colour for a share from 0 to 1. */
export function shade(share, alpha = 1) {
  const at = Math.min(Math.max(share, 0), 1) * (STEPS.length - 1);
  const low = Math.min(Math.floor(at), STEPS.length - 2);
  const mixed = STEPS[low].map((value, i) => Math.round(value + (STEPS[low + 1][i] - value) * (at - low)));
  return `rgba(${mixed.join(",")},${alpha})`;
}

/** The context of a canvas with as many pixels as it covers; its units are those of the page. */
export function sharp(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}

/** A number as people write it. */
export function short(value) {
  if (!Number.isFinite(value)) return "–";
  return Math.abs(value) >= 1e5 || (value !== 0 && Math.abs(value) < 1e-3) ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}

const NAMED = 16; // choices; of more, only the first and the last are named

/** What stands along an axis, each with its place from 0 to 1: both ends of a range, or every choice. */
export function ticks(axis) {
  if (!axis.titles) return [[short(axis.low), 0], [short(axis.high), 1]];
  const last = axis.titles.length - 1;
  const all = axis.titles.map((title, i) => [title, last ? i / last : 0]);
  return last < NAMED ? all : [all[0], all[last]];
}
