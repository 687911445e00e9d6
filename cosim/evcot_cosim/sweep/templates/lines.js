// SPDX-License-Identifier: Apache-2.0
// The configurations: a column of numbers for each setting and figure. What one has none of is NaN.

/** `facts.axes` says of each column its name, its range, its titles if it has choices, and whether less is better. */
export class Lines {
  constructor(facts, columns) {
    this.count = facts.count;
    this.names = facts.names;
    this.axes = facts.axes.map((axis, i) => ({ ...axis, values: decoded(columns[`c${i}`], axis) }));
    this.objectives = this.axes.filter((axis) => axis.objective);
  }

  /** Place on an axis from 0 to 1. */
  place(axis, i) {
    return axis.high > axis.low ? (axis.values[i] - axis.low) / (axis.high - axis.low) : 0.5;
  }

  /** How good a configuration is in an objective, from 0 to 1. */
  merit(axis, i) {
    const place = this.place(axis, i);
    return axis.objective === "min" ? 1 - place : place;
  }

  /** A value as text. */
  text(axis, i) {
    const value = axis.values[i];
    return axis.titles ? axis.titles[value] ?? "–" : Number.isFinite(value) ? String(Number(value.toPrecision(5))) : "–";
  }

  /** A configuration in words. */
  words(i) {
    return this.axes.filter((axis) => Number.isFinite(axis.values[i])).map((axis) => `${axis.name} ${this.text(axis, i)}`).join(", ");
  }
}

/** 0 is no value; k is the (k - 1)-th choice, or a step of the range. */
function decoded(packed, axis) {
  const values = new Float64Array(packed.length);
  const step = (axis.high - axis.low) / 65534;
  for (let i = 0; i < packed.length; i++) {
    const k = packed[i];
    values[i] = k === 0 ? NaN : axis.titles ? k - 1 : axis.low + (k - 1) * step;
  }
  return values;
}
