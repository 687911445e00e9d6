// SPDX-License-Identifier: Apache-2.0
// Where a value stands in ascending numbers.

/** How many of values[from] to values[to - 1] are at most `value`, counted from 0: the first place with more. */
export function after(values, value, from = 0, to = values.length) {
  while (from < to) {
    const middle = (from + to) >> 1;
    if (values[middle] <= value) from = middle + 1;
    else to = middle;
  }
  return from;
}

/** The first place with `value` or more. */
export function notBefore(values, value, from = 0, to = values.length) {
  while (from < to) {
    const middle = (from + to) >> 1;
    if (values[middle] < value) from = middle + 1;
    else to = middle;
  }
  return from;
}
