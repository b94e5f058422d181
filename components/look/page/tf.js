// SPDX-License-Identifier: Apache-2.0
import {IDENTITY, compose, inverse, poseOf} from './geometry.js';

const DEEPEST = 100;
const SAMPLES = 100; // two seconds at 50 Hz

/** The transform of each frame to its parent, for the last seconds. */
export class TransformTree {
  constructor() {
    this.frames = new Map();
  }

  /** Takes a tf2_msgs/TFMessage. */
  add(message) {
    for (const {header, child_frame_id: child, transform} of message.transforms) {
      const name = plain(child);
      const parent = plain(header.frame_id);
      let frame = this.frames.get(name);
      if (!frame || frame.parent !== parent) this.frames.set(name, (frame = {parent, samples: []}));
      const sample = {time: secondsOf(header.stamp), pose: poseOf(transform)};
      if (frame.samples.length > 0 && sample.time < frame.samples.at(-1).time) frame.samples.length = 0; // time went back
      frame.samples.push(sample);
      if (frame.samples.length > SAMPLES) frame.samples.shift();
    }
  }

  clear() {
    this.frames.clear();
  }
  get size() {
    return this.frames.size;
  }

  /** Returns the frame at the top, and the pose of `frame` in it, at a time in s; without one, the newest. */
  rooted(frame, time) {
    let name = plain(frame);
    let pose = IDENTITY;
    for (let depth = 0; depth < DEEPEST; ++depth) {
      const found = this.frames.get(name);
      if (!found) return {root: name, pose};
      pose = compose(poseAt(found.samples, time), pose);
      name = found.parent;
    }
    return {root: '', pose}; // a loop
  }

  /** Returns the pose of `source` in `target` at a time in s, without one the newest; null: they are not connected. */
  lookup(target, source, time) {
    const a = this.rooted(target, time);
    const b = this.rooted(source, time);
    if (a.root !== b.root || a.root === '') return null;
    return compose(inverse(a.pose), b.pose);
  }

  /** Returns every frame name, parents included. */
  names() {
    const names = new Set(this.frames.keys());
    for (const {parent} of this.frames.values()) names.add(parent);
    return [...names].sort();
  }

  /** Returns the frame that a map is drawn in: map, else odom, else the top of the largest tree, else empty. */
  fixedFrame() {
    const names = new Set(this.names());
    for (const wanted of ['map', 'odom']) {
      if (names.has(wanted)) return wanted;
    }
    const counts = new Map();
    for (const name of this.frames.keys()) {
      const {root} = this.rooted(name);
      counts.set(root, (counts.get(root) ?? 0) + 1);
    }
    return [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? '';
  }
}

export function secondsOf({sec, nanosec}) {
  return sec + nanosec * 1e-9;
}

/** The sample that is nearest to the time. */
function poseAt(samples, time) {
  let best = samples.at(-1);
  if (time === undefined) return best.pose;
  for (let i = samples.length - 2; i >= 0 && Math.abs(samples[i].time - time) <= Math.abs(best.time - time); --i) best = samples[i];
  return best.pose;
}

function plain(name) {
  return name.startsWith('/') ? name.slice(1) : name;
}
