// SPDX-License-Identifier: Apache-2.0
// Series of numbers over time: which fields of a message are numbers, their values, and the picture.
import {NUMERIC} from './ros2msg.js';

const SHOWN_OF_SEQUENCE = 4;
const SHOWN_OF_ARRAY = 36;
const DEEPEST = 8;

/** Returns the fields of a type as a tree: {name, path, isNumber, children}. Of a sequence it shows the first elements. */
export function fieldTree(schema, name = schema.name, path = '', depth = 0) {
  if (depth > DEEPEST) return [];
  return schema.types
    .get(name)
    .fields.map((field) => {
      const own = path === '' ? field.name : `${path}.${field.name}`;
      if (!field.array) return nodeOf(schema, field.name, own, field.type, depth);
      const count = field.array === 'fixed' ? Math.min(field.length, SHOWN_OF_ARRAY) : Math.min(field.bound ?? SHOWN_OF_SEQUENCE, SHOWN_OF_SEQUENCE);
      const children = Array.from({length: count}, (_, i) => nodeOf(schema, `[${i}]`, `${own}[${i}]`, field.type, depth)).filter(isUseful);
      return {name: `${field.name}[]`, path: own, isNumber: false, children};
    })
    .filter(isUseful);
}

function nodeOf(schema, name, path, type, depth) {
  if (schema.types.has(type)) return {name, path, isNumber: false, children: fieldTree(schema, type, path, depth + 1)};
  return {name, path, isNumber: NUMERIC.has(type), children: []};
}

function isUseful(node) {
  return node.isNumber || node.children.length > 0;
}

/** Returns the number at a path such as `pose.pose.position.x` or `ranges[0]`; NaN: there is none. */
export function valueAt(message, path) {
  let value = message;
  for (const step of path.split(/[.[]/)) {
    if (value === null || value === undefined) return NaN;
    value = value[step.endsWith(']') ? Number(step.slice(0, -1)) : step];
  }
  return typeof value === 'number' || typeof value === 'bigint' || typeof value === 'boolean' ? Number(value) : NaN;
}

/** The values of the last seconds. */
export class Series {
  constructor(seconds = 30, most = 6000) {
    Object.assign(this, {seconds, most});
    this.times = [];
    this.values = [];
  }

  add(time, value) {
    if (this.times.length > 0 && time < this.times.at(-1)) this.clear(); // a replay went back
    this.times.push(time);
    this.values.push(value);
    let old = 0;
    while (this.times[old] < time - this.seconds || this.times.length - old > this.most) ++old;
    if (old > 0) {
      this.times.splice(0, old);
      this.values.splice(0, old);
    }
  }

  clear() {
    this.times.length = 0;
    this.values.length = 0;
  }

  /** Returns {low, high} of the finite values; null without one. */
  range() {
    let low = Infinity,
      high = -Infinity;
    for (const value of this.values) {
      if (!Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return low <= high ? {low, high} : null;
  }

  /** Returns one {low, high} for each of `columns` equal parts of the time between begin and end; undefined where there is no value. */
  columns(begin, end, columns) {
    const result = new Array(columns);
    for (let i = 0; i < this.times.length; ++i) {
      const at = Math.floor(((this.times[i] - begin) / (end - begin)) * columns);
      const value = this.values[i];
      if (at < 0 || at >= columns || !Number.isFinite(value)) continue;
      const column = result[at];
      if (!column) result[at] = {low: value, high: value, last: value};
      else Object.assign(column, {low: Math.min(column.low, value), high: Math.max(column.high, value), last: value});
    }
    return result;
  }
}

/** Returns round numbers for an axis: at most `most` of them, within low and high. */
export function ticks(low, high, most) {
  const span = high - low;
  if (!(span > 0) || most < 1) return [];
  const power = 10 ** Math.floor(Math.log10(span / most));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => span / size <= most);
  const result = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * span; ++i) result.push(Number((i * step).toPrecision(12)));
  return result;
}

/** Draws the series of [{series, colour, name}] up to the time `now`. */
export function drawPlot(context, width, height, lines, now, seconds, colour) {
  const left = 46,
    bottom = 18,
    top = 6;
  const ranges = lines.map(({series}) => series.range()).filter(Boolean);
  let low = Math.min(...ranges.map((range) => range.low));
  let high = Math.max(...ranges.map((range) => range.high));
  if (ranges.length === 0) [low, high] = [-1, 1];
  const edge = high > low ? (high - low) * 0.08 : Math.max(0.5, Math.abs(high) * 0.1);
  [low, high] = [low - edge, high + edge];
  const y = (value) => top + ((high - value) / (high - low)) * (height - top - bottom);
  const x = (time) => left + ((time - now + seconds) / seconds) * (width - left);
  context.font = '11px sans-serif';
  context.lineWidth = 1;
  context.strokeStyle = colour('--grid');
  context.fillStyle = colour('--dim');
  for (const tick of ticks(low, high, Math.max(2, Math.floor(height / 40)))) {
    context.beginPath();
    context.moveTo(left, y(tick));
    context.lineTo(width, y(tick));
    context.stroke();
    context.fillText(String(tick), 2, y(tick) + 4);
  }
  for (let back = 0; back <= seconds; back += seconds / 3)
    context.fillText(`-${back.toFixed(0)} s`, Math.min(width - 28, x(now - back) + 2), height - 4);
  context.lineWidth = 1.6;
  const columns = Math.max(1, Math.floor(width - left));
  for (const {series, colour: own} of lines) {
    context.strokeStyle = colour(own);
    context.beginPath();
    let isDown = false;
    series.columns(now - seconds, now, columns).forEach((column, i) => {
      if (!column) return;
      const at = left + i;
      context[isDown ? 'lineTo' : 'moveTo'](at, y(column.low));
      if (column.high > column.low) context.lineTo(at, y(column.high));
      context.lineTo(at, y(column.last));
      isDown = true;
    });
    context.stroke();
  }
}
