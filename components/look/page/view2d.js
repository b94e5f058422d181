// SPDX-License-Identifier: Apache-2.0
// The world from above.
import {apply, ellipseOf, hull, yawOf} from './geometry.js';

const FRAME_AXIS_PX = 16;

export class View2d {
  constructor() {
    this.scale = 90; // pixels per metre
    this.centre = [0, 0]; // in the fixed frame
  }

  zoom(factor) {
    this.scale = Math.min(2000, Math.max(4, this.scale * factor));
  }
  /** Moves the picture by pixels. */
  drag(dx, dy) {
    this.centre = [this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale];
  }

  /** `options`: follow (the robot stays in the middle), names (of frames). */
  draw(context, width, height, scene, colour, options) {
    const {fixed} = scene;
    const base = scene.poseOf(scene.base, fixed);
    if (options.follow && base) this.centre = [base.p[0], base.p[1]];
    const toScreen = ([x, y]) => [width / 2 + (x - this.centre[0]) * this.scale, height / 2 - (y - this.centre[1]) * this.scale];
    const polygon = (points) => {
      context.beginPath();
      points.forEach((point, i) => context[i ? 'lineTo' : 'moveTo'](...toScreen(point)));
    };
    this.grid(context, width, height, colour, toScreen);
    for (const {frame, points, time} of scene.scans.values()) {
      const pose = scene.poseOf(frame, fixed, time);
      if (!pose) continue;
      context.fillStyle = colour('--scan');
      for (const point of points) {
        const [x, y] = toScreen(apply(pose, point));
        context.fillRect(x - 1.5, y - 1.5, 3, 3);
      }
    }
    this.shapes(context, scene, fixed, polygon);
    const outline = scene.outline();
    const at = outline && scene.poseOf(outline.frame, fixed);
    if (at) {
      polygon(outline.points.map((point) => apply(at, point)));
      context.closePath();
      context.strokeStyle = colour('--footprint');
      context.lineWidth = 1.5;
      context.stroke();
    }
    for (const path of scene.paths.values()) this.path(context, scene, fixed, path, colour, toScreen, polygon);
    this.frames(context, scene, fixed, colour, toScreen, options.names);
  }

  grid(context, width, height, colour, toScreen) {
    const step = [0.1, 0.25, 0.5, 1, 2, 5, 10, 50].find((size) => size * this.scale > 40) ?? 100;
    context.lineWidth = 1;
    context.strokeStyle = colour('--grid');
    context.beginPath();
    const halfX = width / 2 / this.scale,
      halfY = height / 2 / this.scale;
    for (let x = Math.ceil((this.centre[0] - halfX) / step) * step; x <= this.centre[0] + halfX; x += step) {
      const [at] = toScreen([x, 0]);
      context.moveTo(at, 0);
      context.lineTo(at, height);
    }
    for (let y = Math.ceil((this.centre[1] - halfY) / step) * step; y <= this.centre[1] + halfY; y += step) {
      const [, at] = toScreen([0, y]);
      context.moveTo(0, at);
      context.lineTo(width, at);
    }
    context.stroke();
    context.fillStyle = colour('--dim');
    context.font = '11px sans-serif';
    context.fillText(`grid ${step} m`, 8, height - 8);
  }

  shapes(context, scene, fixed, polygon) {
    const flat = [];
    for (const link of scene.links) {
      const pose = scene.poseOf(link.name, fixed);
      if (!pose) continue;
      for (const {
        faces,
        colour: [r, g, b, a],
      } of link.visuals) {
        const points = faces.flat().map((corner) => apply(pose, corner));
        if (points.length === 0) continue;
        flat.push({
          top: Math.max(...points.map(([, , z]) => z)),
          points: hull(points.map(([x, y]) => [x, y])),
          style: `rgba(${255 * r}, ${255 * g}, ${255 * b}, ${0.9 * a})`,
        });
      }
    }
    flat.sort((one, other) => one.top - other.top);
    for (const {points, style} of flat) {
      polygon(points);
      context.closePath();
      context.fillStyle = style;
      context.fill();
      context.strokeStyle = 'rgba(128, 128, 128, 0.7)';
      context.lineWidth = 1;
      context.stroke();
    }
  }

  path(context, scene, fixed, path, colour, toScreen, polygon) {
    const pose = scene.poseOf(path.frame, fixed);
    if (!pose) return;
    polygon([...path.points, path.pose.p].map((point) => apply(pose, point)));
    context.strokeStyle = colour(path.colour);
    context.lineWidth = 2;
    context.stroke();
    const ellipse = ellipseOf(...path.covariance);
    const [x, y] = toScreen(apply(pose, path.pose.p));
    if (!ellipse || !(ellipse.a > 0)) return;
    context.beginPath(); // two standard deviations
    const most = 1e4;
    context.ellipse(
      x,
      y,
      Math.min(most, 2 * ellipse.a * this.scale),
      Math.min(most, 2 * ellipse.b * this.scale),
      -(ellipse.angle + yawOf(pose.q)),
      0,
      2 * Math.PI,
    );
    context.lineWidth = 1;
    context.stroke();
  }

  frames(context, scene, fixed, colour, toScreen, names) {
    context.font = '11px sans-serif';
    const used = [];
    for (const name of scene.tf.names()) {
      const pose = scene.poseOf(name, fixed);
      if (!pose) continue;
      const origin = toScreen(pose.p);
      [
        ['--axis-x', [1, 0, 0]],
        ['--axis-y', [0, 1, 0]],
      ].forEach(([own, axis]) => {
        const end = toScreen(
          apply(
            pose,
            axis.map((part) => (part * FRAME_AXIS_PX) / this.scale),
          ),
        );
        context.strokeStyle = colour(own);
        context.lineWidth = 1.5;
        context.beginPath();
        context.moveTo(...origin);
        context.lineTo(...end);
        context.stroke();
      });
      if (!names) continue;
      let y = origin[1] - 4;
      while (used.some((other) => Math.abs(other.x - origin[0]) < 90 && Math.abs(other.y - y) < 11)) y += 11;
      used.push({x: origin[0], y});
      context.fillStyle = colour('--text');
      context.fillText(name, origin[0] + 5, y);
    }
  }
}
