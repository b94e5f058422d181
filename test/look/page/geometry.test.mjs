// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {apply, compose, ellipseOf, fromRpy, hull, inverse, yawOf} from '../../../components/look/page/geometry.js';
import {TransformTree} from '../../../components/look/page/tf.js';
import {facesOf, readStl} from '../../../components/look/page/urdf.js';

const near = (a, b, words) => a.forEach((part, i) => assert.ok(Math.abs(part - b[i]) < 1e-9, `${words ?? ''} ${a} is not ${b}`));

/** Repeatable numbers between -1 and 1. */
function random(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 31 - 1;
  };
}

test('a pose and its inverse bring each point back', () => {
  const next = random(7);
  for (let i = 0; i < 100; ++i) {
    const pose = {p: [next(), next(), next()], q: fromRpy([3 * next(), 1.5 * next(), 3 * next()])};
    const point = [next(), next(), next()];
    near(apply(inverse(pose), apply(pose, point)), point, `case ${i}`);
    near(apply(compose(pose, inverse(pose)), point), point, `case ${i}`);
  }
});

test('rpy turns about fixed axes, as URDF says', () => {
  near(apply({p: [0, 0, 0], q: fromRpy([-Math.PI / 2, 0, -Math.PI / 2])}, [0, 0, 1]), [1, 0, 0]); // z of a camera looks ahead
  assert.ok(Math.abs(yawOf(fromRpy([0, 0, 0.7])) - 0.7) < 1e-12);
});

test('the ellipse of a covariance', () => {
  near(Object.values(ellipseOf(4, 0, 1)), [2, 1, 0]);
  near(Object.values(ellipseOf(1, 0, 4)), [2, 1, Math.PI / 2]);
  assert.equal(ellipseOf(-1, 0, 1), null);
  assert.equal(ellipseOf(NaN, 0, 1), null);
});

test('the hull leaves out what is inside', () => {
  assert.deepEqual(
    hull([
      [0, 0],
      [1, 1],
      [2, 0],
      [2, 2],
      [0, 2],
      [1, 0],
    ]),
    [
      [0, 0],
      [2, 0],
      [2, 2],
      [0, 2],
    ],
  );
});

const transform = (parent, child, x, sec = 0) => ({
  header: {frame_id: parent, stamp: {sec, nanosec: 0}},
  child_frame_id: child,
  transform: {translation: {x, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}},
});

test('frames are looked up across the tree, and loops are none', () => {
  const tree = new TransformTree();
  tree.add({
    transforms: [
      transform('odom', 'base', 3),
      transform('base', 'lidar', 1),
      transform('/odom', 'camera', 5),
      transform('a', 'b', 1),
      transform('b', 'a', 1),
    ],
  });
  assert.equal(tree.fixedFrame(), 'odom');
  near(tree.lookup('camera', 'lidar').p, [-1, 0, 0]);
  assert.equal(tree.lookup('odom', 'nowhere'), null);
  assert.equal(tree.lookup('a', 'b'), null);
  assert.deepEqual(tree.names(), ['a', 'b', 'base', 'camera', 'lidar', 'odom']);
});

test('a frame that moves is looked up at its time', () => {
  const tree = new TransformTree();
  for (let sec = 1; sec <= 300; ++sec) tree.add({transforms: [transform('odom', 'base', sec, sec)]});
  tree.add({transforms: [transform('base', 'lidar', 0.5)]});
  near(tree.lookup('odom', 'lidar').p, [300.5, 0, 0]);
  near(tree.lookup('odom', 'lidar', 250.2).p, [250.5, 0, 0]);
  near(tree.lookup('odom', 'lidar', 2).p, [201.5, 0, 0], 'what is too old is the oldest');
  tree.add({transforms: [transform('odom', 'base', 7, 1)]});
  near(tree.lookup('odom', 'lidar', 250).p, [7.5, 0, 0], 'time went back');
});

test('shapes have faces', () => {
  const pose = {p: [1, 0, 0], q: [0, 0, 0, 1]};
  const xs = facesOf({kind: 'box', pose, size: [2, 4, 6]})
    .flat()
    .map(([x]) => x);
  assert.deepEqual([Math.min(...xs), Math.max(...xs)], [0, 2]);
  const zs = facesOf({kind: 'sphere', pose, radius: 0.5})
    .flat()
    .map(([, , z]) => z);
  near([Math.min(...zs), Math.max(...zs)], [-0.5, 0.5]);
  assert.equal(facesOf({kind: 'mesh', pose, scale: [1, 1, 1]}).length, 0);
});

test('a binary STL is read, a wrong count is refused', () => {
  const bytes = new Uint8Array(84 + 50);
  const view = new DataView(bytes.buffer);
  view.setUint32(80, 1, true);
  view.setFloat32(84 + 12 + 24, 2.5, true);
  assert.deepEqual(readStl(bytes), [
    [
      [0, 0, 0],
      [0, 0, 0],
      [2.5, 0, 0],
    ],
  ]);
  view.setUint32(80, 2, true);
  assert.throws(() => readStl(bytes), /no binary STL/);
});
