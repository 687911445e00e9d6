// SPDX-License-Identifier: Apache-2.0
// Description of the event under the pointer: time, position, polarity and owner.
import { timeText } from "./axis.js";

const SLOT_WORDS = { [-1]: "in no track", [-2]: "removed by a filter" };

function ownerText(side, slot, at) {
  if (slot < 0) return SLOT_WORDS[slot];
  const life = side.lifeIn(slot, at);
  return life < 0 ? `slot ${slot}, not yet visible` : `track ${side.ids[life]}`;
}

/** [label, value] pairs for an event by its number, or for a place without one. */
export function describe(recording, engines, event, x, y) {
  if (event < 0) return [["x", String(x)], ["y", String(y)], ["event", "none to be seen"]];
  const { t, p, owner, owners, cell } = recording;
  const slots = owners[owner[event]];
  return [
    ["t", timeText(t[event], 1)],
    ["x", String(recording.x[event] * cell)],
    ["y", String(recording.y[event] * cell)],
    ["polarity", p[event] ? "ON" : "OFF"],
    ...engines.map((side, i) => [side.name, ownerText(side, slots[i], t[event])]),
  ];
}
