// SPDX-License-Identifier: Apache-2.0
import {IDENTITY, compose, inverse, poseOf} from './geometry.js';

const DEEPEST = 100;

/** The newest transform of each frame to its parent. */
export class TransformTree {
  constructor() { this.frames = new Map(); }

  /** Takes a tf2_msgs/TFMessage. */
  add(message) {
    for (const {header, child_frame_id: child, transform} of message.transforms) {
      this.frames.set(plain(child), {parent: plain(header.frame_id), pose: poseOf(transform)});
    }
  }

  clear() { this.frames.clear(); }
  get size() { return this.frames.size; }

  /** Returns the frame at the top, and the pose of `frame` in it. */
  rooted(frame) {
    let name = plain(frame);
    let pose = IDENTITY;
    for (let depth = 0; depth < DEEPEST; ++depth) {
      const found = this.frames.get(name);
      if (!found) return {root: name, pose};
      pose = compose(found.pose, pose);
      name = found.parent;
    }
    return {root: '', pose};  // a loop
  }

  /** Returns the pose of `source` in `target`; null: they are not connected. */
  lookup(target, source) {
    const a = this.rooted(target);
    const b = this.rooted(source);
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

function plain(name) { return name.startsWith('/') ? name.slice(1) : name; }
