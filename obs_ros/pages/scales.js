'use strict';
/* Axes: steps, labels and the ranges that panels show. Times are in s since the origin. */

const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 4], [12, 4]];

function niceStep(range, count) {
  const rough = range / Math.max(count, 1);
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const part = rough / power;
  return power * (part > 5 ? 10 : part > 2 ? 5 : part > 1 ? 2 : 1);
}

function ticks(low, high, count) {
  const step = niceStep(high - low, count);
  const found = [];
  if (!(step > 0) || !isFinite(step)) return { step: 1, found };
  for (let k = Math.ceil(low / step); k * step <= high && found.length < 50; k++) {
    found.push(k * step);
  }
  return { step, found };
}

function label(value, step) {
  const size = Math.max(Math.abs(value), step);
  if (size >= 1e6 || size < 1e-4) return value === 0 ? '0' : value.toExponential(1);
  return value.toFixed(Math.min(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), 8));
}

/* From one time to another, or one where they are the same. */
function stretch(from, to) {
  return to > from ? `${from.toFixed(2)} to ${to.toFixed(2)}` : from.toFixed(2);
}

function figure(value, digits = 4) {
  if (value === null || value === undefined) return '?';
  const size = Math.abs(value);
  if (value !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(digits - 2);
  return String(Number(value.toPrecision(digits)));
}

function unitOf(panel) {
  return panel.unit ? ` (${panel.unit})` : '';
}

function median(values) {
  const sorted = values.filter(v => v !== null).sort((a, b) => a - b);
  return sorted.length ? sorted[sorted.length >> 1] : 0;
}

/* The values of a curve at times from `from` to `to`, and those next to them. */
function within(t, v, from, to) {
  const found = [];
  for (let k = 0; k < t.length; k++) {
    const after = k + 1 < t.length ? t[k + 1] : t[k];
    const before = k > 0 ? t[k - 1] : t[k];
    if (after >= from && before <= to && v[k] !== null) found.push(v[k]);
  }
  return found;
}

/* All values that are seen, and bands as far as they usually reach: a few wide ones flatten
   nothing. */
function valueRange(panel, from, to) {
  let low = Infinity, high = -Infinity, reach = 0;
  for (const curve of panel.curves) {
    for (const v of within(curve.t, curve.v, from, to)) {
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
    if (curve.band) {
      const widths = curve.band.t.map((t, k) => curve.band.lower[k] === null ||
        curve.band.upper[k] === null ? null : curve.band.upper[k] - curve.band.lower[k]);
      reach = Math.max(reach, median(within(curve.band.t, widths, from, to)) / 2);
    }
  }
  if (low > high) return [0, 1];
  if (panel.kind === 'residual') {
    const most = 1.1 * Math.max(Math.abs(low), Math.abs(high), reach);
    return most > 0 ? [-most, most] : [-1, 1];
  }
  const room = Math.max(0.08 * (high - low), 1.3 * reach) || 0.05 * Math.abs(high) || 1;
  return [low - room, high + room];
}

/* The last point of a curve at or before time t, as its place; -1 if there is none. */
function placeAt(times, t) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1; else high = middle;
  }
  return low - 1;
}

/* The value of the last point of a curve at or before t; null where that is not known. */
function valueAt(curve, t) {
  const place = placeAt(curve.t, t);
  return place < 0 ? null : curve.v[place];
}
