// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Series, fieldTree, ticks, valueAt} from '../../../components/look/page/plot.js';
import {layersOf} from '../../../components/look/page/layers.js';
import {streamRows} from '../../../components/look/page/statistics.js';
import {schemaOf} from './schemas.mjs';

test('the fields of an odometry that are numbers', () => {
  const tree = fieldTree(schemaOf('nav_msgs/msg/Odometry'));
  const paths = [];
  const walk = (nodes) => nodes.forEach((node) => (node.isNumber ? paths.push(node.path) : walk(node.children)));
  walk(tree);
  assert.ok(paths.includes('twist.twist.linear.x'));
  assert.ok(paths.includes('pose.covariance[35]'));
  assert.ok(!paths.includes('child_frame_id'));
  assert.equal(fieldTree(schemaOf('std_msgs/msg/String')).length, 0);
});

test('values of paths', () => {
  const message = {a: {b: [{c: 5n}], d: Float32Array.of(0.5), e: true}};
  assert.equal(valueAt(message, 'a.b[0].c'), 5);
  assert.equal(valueAt(message, 'a.d[0]'), 0.5);
  assert.equal(valueAt(message, 'a.e'), 1);
  assert.ok(Number.isNaN(valueAt(message, 'a.b[7].c')));
  assert.ok(Number.isNaN(valueAt(message, 'a')));
});

test('a series forgets what is old, and all when time goes back', () => {
  const series = new Series(10);
  for (let time = 0; time <= 20; ++time) series.add(time, time);
  assert.deepEqual([series.times[0], series.times.at(-1)], [10, 20]);
  series.add(21, NaN);
  series.add(22, -Infinity);
  assert.deepEqual(series.range(), {low: 12, high: 20});
  series.add(3, 1);
  assert.deepEqual(series.times, [3]);
  assert.equal(new Series().range(), null);
});

test('columns keep peaks', () => {
  const series = new Series(100);
  [
    [0, 1],
    [1, 9],
    [2, 2],
    [60, 5],
  ].forEach(([time, value]) => series.add(time, value));
  const columns = series.columns(0, 100, 10);
  assert.deepEqual(columns[0], {low: 1, high: 9, last: 2});
  assert.equal(columns[3], undefined);
  assert.equal(columns[6].last, 5);
});

test('ticks are round', () => {
  assert.deepEqual(ticks(0, 1, 5), [0, 0.2, 0.4, 0.6, 0.8, 1]);
  assert.deepEqual(ticks(-3, 12, 4), [0, 5, 10]);
  assert.deepEqual(ticks(1, 1, 4), []);
});

test('writers stand left of their readers, and loops end', () => {
  const edges = [
    ['camera', 'detector'],
    ['detector', 'monitor'],
    ['camera', 'monitor'],
    ['base', 'ekf'],
    ['ekf', 'base'],
  ].map(([from, to]) => ({from, to}));
  const layers = layersOf(['base', 'camera', 'detector', 'ekf', 'monitor', 'alone'].sort(), edges);
  const column = (name) => layers.findIndex((layer) => layer.includes(name));
  assert.ok(column('camera') < column('detector') && column('detector') < column('monitor'));
  assert.notEqual(column('base'), column('ekf'));
  assert.equal(layers.flat().length, 6);
});

test('rates, drops and late readers of two answers', () => {
  const drops = {overwritten: 2n, full: 0n};
  const stream = (published) => ({
    name: '/scan',
    type: 't',
    published,
    last_ns: 900000000n,
    dropped: drops,
    latency_p99_us: 1500,
    writers: 1n,
    readers: 1n,
  });
  const reader = (lost) => ({
    topic: '/scan',
    type: 't',
    node: '/slow',
    open: true,
    waiting: 0n,
    depth: 5n,
    lost,
    deadline_missed: 0n,
    latency_p99_us: 30000,
  });
  const before = {now_ns: 0n, streams: [stream(0n)], readers: [reader(0n)]};
  const after = {now_ns: 1000000000n, streams: [stream(10n)], readers: [reader(3n)]};
  const [row] = streamRows(before, after);
  assert.equal(row.rate, 10);
  assert.ok(Math.abs(row.age - 0.1) < 1e-9);
  assert.deepEqual([row.dropped, row.causes, row.p99, row.late], [2, 'overwritten 2', 1.5, '/slow: lost 3, 30 ms']);
  assert.ok(Number.isNaN(streamRows(null, after)[0].rate));
});
