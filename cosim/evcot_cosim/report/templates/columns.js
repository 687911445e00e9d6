// SPDX-License-Identifier: Apache-2.0
// The page's columns of numbers: decompression, the counterpart of pack.py, and binary search in ascending ones.

function bytesOf(base64) {
  const letters = atob(base64);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Decode byte planes, lowest first: undo zigzag, differences and scale. */
export function restore(bytes, { n, planes, signed, delta, scale }, Kind = Float64Array) {
  const values = new Kind(n);
  let last = 0;
  for (let i = 0; i < n; i++) {
    let value = 0;
    for (let plane = planes - 1; plane >= 0; plane--) value = value * 256 + bytes[plane * n + i];
    if (signed) value = value % 2 ? -(value + 1) / 2 : value / 2;
    if (delta) value = last += value;
    values[i] = value * scale;
  }
  return values;
}

/** All columns by name; `kinds` names the array types of those that are not Float64Array. */
export async function unpack(text, directory, kinds) {
  const bytes = bytesOf(text);
  const columns = {};
  await Promise.all(Object.entries(directory).map(async ([name, entry]) => {
    const content = await inflate(bytes.subarray(entry.at, entry.at + entry.bytes));
    columns[name] = restore(content, entry, kinds[name]);
  }));
  return columns;
}

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
