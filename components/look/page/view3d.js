// SPDX-License-Identifier: Apache-2.0
// The world in perspective: polygons that are sorted by depth, on a canvas.
import {apply} from './geometry.js';

const NEAR_M = 0.05;
const LIGHT = [0.36, -0.48, 0.8];
const GRID_M = 5;

export class View3d {
  constructor() {
    this.yaw = -2.4;
    this.pitch = 0.6;
    this.distance = 1.3;
    this.target = [0, 0, 0.05];
  }

  zoom(factor) {
    this.distance = Math.min(60, Math.max(0.2, this.distance / factor));
  }
  drag(dx, dy) {
    this.yaw -= dx * 0.008;
    this.pitch = Math.min(1.5, Math.max(0.03, this.pitch + dy * 0.008));
  }

  draw(context, width, height, scene, colour, options) {
    const {fixed} = scene;
    const base = scene.poseOf(scene.base, fixed);
    if (options.follow && base) this.target = [base.p[0], base.p[1], base.p[2] + 0.05];
    const camera = this.camera(width, height);
    const items = [];
    this.grid(context, camera, colour);
    this.points(items, scene, fixed, camera, colour('--scan'));
    this.paths(items, scene, fixed, camera, colour);
    this.faces(items, scene, fixed, camera);
    items.sort((a, b) => b.depth - a.depth);
    for (const item of items) item.draw(context);
    this.axes(context, scene, fixed, camera, colour, options.names);
  }

  /** Returns a function that brings a point to [x, y, depth] on the screen; null behind the camera. */
  camera(width, height) {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const back = [cp * cy, cp * sy, sp];
    const right = [-sy, cy, 0];
    const up = [-sp * cy, -sp * sy, cp];
    const eye = this.target.map((part, i) => part + this.distance * back[i]);
    const focal = 0.9 * Math.min(width, height);
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    return (point) => {
      const d = [point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]];
      const depth = -dot(d, back);
      if (depth < NEAR_M) return null;
      return [width / 2 + (focal * dot(d, right)) / depth, height / 2 - (focal * dot(d, up)) / depth, depth];
    };
  }

  line(context, camera, from, to) {
    const [a, b] = [camera(from), camera(to)];
    if (!a || !b) return;
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
  }

  grid(context, camera, colour) {
    const [x0, y0] = [Math.round(this.target[0]), Math.round(this.target[1])];
    context.strokeStyle = colour('--grid');
    context.lineWidth = 1;
    context.beginPath();
    for (let i = -GRID_M; i <= GRID_M; i += 0.5) {
      for (let j = -GRID_M; j < GRID_M; j += 0.5) {
        // in pieces, so that only those behind the camera are left out
        this.line(context, camera, [x0 + i, y0 + j, 0], [x0 + i, y0 + j + 0.5, 0]);
        this.line(context, camera, [x0 + j, y0 + i, 0], [x0 + j + 0.5, y0 + i, 0]);
      }
    }
    context.stroke();
  }

  points(items, scene, fixed, camera, style) {
    for (const {frame, points, time} of scene.scans.values()) {
      const pose = scene.poseOf(frame, fixed, time);
      if (!pose) continue;
      for (const point of points) {
        const at = camera(apply(pose, point));
        if (!at) continue;
        const size = Math.min(6, Math.max(2, 5 / at[2]));
        items.push({
          depth: at[2],
          draw(context) {
            context.fillStyle = style;
            context.fillRect(at[0] - size / 2, at[1] - size / 2, size, size);
          },
        });
      }
    }
  }

  paths(items, scene, fixed, camera, colour) {
    for (const path of scene.paths.values()) {
      const pose = scene.poseOf(path.frame, fixed);
      if (!pose) continue;
      const style = colour(path.colour);
      const points = [...path.points, path.pose.p].map((point) => camera(apply(pose, point)));
      for (let i = 1; i < points.length; ++i) {
        const [a, b] = [points[i - 1], points[i]];
        if (!a || !b) continue;
        items.push({
          depth: Math.max(a[2], b[2]) + 0.05,
          draw(context) {
            context.strokeStyle = style;
            context.lineWidth = 2;
            context.beginPath();
            context.moveTo(a[0], a[1]);
            context.lineTo(b[0], b[1]);
            context.stroke();
          },
        });
      }
    }
  }

  faces(items, scene, fixed, camera) {
    for (const link of scene.links) {
      const pose = scene.poseOf(link.name, fixed);
      if (!pose) continue;
      for (const shape of link.visuals)
        for (const face of shape.faces)
          this.face(
            items,
            face.map((corner) => apply(pose, corner)),
            shape.colour,
            camera,
          );
    }
  }

  face(items, corners, [r, g, b, a], camera) {
    const flat = corners.map(camera);
    if (flat.includes(null)) return;
    const u = corners[1].map((part, i) => part - corners[0][i]);
    const v = corners[2].map((part, i) => part - corners[0][i]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...normal) || 1;
    const light = 0.55 + (0.45 * Math.abs(normal.reduce((sum, part, i) => sum + part * LIGHT[i], 0))) / length;
    const style = `rgba(${[r, g, b].map((part) => Math.round(255 * Math.min(1, (part + 0.06) * light))).join(',')},${a})`;
    items.push({
      depth: flat.reduce((sum, [, , depth]) => sum + depth, 0) / flat.length,
      draw(context) {
        context.beginPath();
        flat.forEach(([x, y], i) => context[i ? 'lineTo' : 'moveTo'](x, y));
        context.closePath();
        context.fillStyle = style;
        context.strokeStyle = style;
        context.lineWidth = 0.7;
        context.fill();
        context.stroke();
      },
    });
  }

  axes(context, scene, fixed, camera, colour, names) {
    context.font = '11px sans-serif';
    for (const name of scene.tf.names()) {
      const pose = scene.poseOf(name, fixed);
      const origin = pose && camera(pose.p);
      if (!origin) continue;
      [
        ['--axis-x', [0.06, 0, 0]],
        ['--axis-y', [0, 0.06, 0]],
        ['--axis-z', [0, 0, 0.06]],
      ].forEach(([own, axis]) => {
        context.strokeStyle = colour(own);
        context.lineWidth = 1.5;
        context.beginPath();
        this.line(context, camera, pose.p, apply(pose, axis));
        context.stroke();
      });
      if (!names) continue;
      context.fillStyle = colour('--text');
      context.fillText(name, origin[0] + 4, origin[1] - 4);
    }
  }
}
