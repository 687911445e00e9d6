// SPDX-License-Identifier: Apache-2.0
// Binary search in ascending numbers.

/** Index of the first of values[from] to values[to - 1] that is greater than `value`, else `to`. */
export function after(values, value, from = 0, to = values.length) {
  while (from < to) {
    const middle = (from + to) >> 1;
    if (values[middle] <= value) from = middle + 1;
    else to = middle;
  }
  return from;
}

/** Index of the first value that is at least `value`. */
export function notBefore(values, value, from = 0, to = values.length) {
  while (from < to) {
    const middle = (from + to) >> 1;
    if (values[middle] < value) from = middle + 1;
    else to = middle;
  }
  return from;
}
