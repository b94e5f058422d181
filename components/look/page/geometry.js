// SPDX-License-Identifier: Apache-2.0
// Poses are {p: [x, y, z] in m, q: [x, y, z, w]}; a pose X_AB maps points of B to A.

export const IDENTITY = {p: [0, 0, 0], q: [0, 0, 0, 1]};

export function rotate([x, y, z, w], [a, b, c]) {
  const tx = 2 * (y * c - z * b),
    ty = 2 * (z * a - x * c),
    tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

export function multiply([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

export function apply({p, q}, point) {
  const [x, y, z] = rotate(q, point);
  return [p[0] + x, p[1] + y, p[2] + z];
}

export function compose(a, b) {
  return {p: apply(a, b.p), q: multiply(a.q, b.q)};
}

export function inverse({p, q}) {
  const back = [-q[0], -q[1], -q[2], q[3]];
  return {p: rotate(back, [-p[0], -p[1], -p[2]]), q: back};
}

/** Returns the rotation of roll, pitch and yaw about fixed axes (URDF's rpy), in rad. */
export function fromRpy([roll, pitch, yaw]) {
  const half = (angle) => [Math.sin(angle / 2), Math.cos(angle / 2)];
  const [sr, cr] = half(roll),
    [sp, cp] = half(pitch),
    [sy, cy] = half(yaw);
  return multiply([0, 0, sy, cy], multiply([0, sp, 0, cp], [sr, 0, 0, cr]));
}

export function yawOf([x, y, z, w]) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/** Returns the pose of a geometry_msgs Pose or Transform. */
export function poseOf(message) {
  const at = message.position ?? message.translation;
  const turn = message.orientation ?? message.rotation;
  const q = [turn.x, turn.y, turn.z, turn.w];
  const length = Math.hypot(...q);
  return {p: [at.x, at.y, at.z], q: length > 1e-9 ? q.map((part) => part / length) : IDENTITY.q};
}

/** Returns the axes of the ellipse of a covariance of x and y: {a, b} standard deviations in m, and the angle of `a` in rad. Null: it is none. */
export function ellipseOf(xx, xy, yy) {
  if (![xx, xy, yy].every(Number.isFinite) || xx < 0 || yy < 0) return null;
  const mean = (xx + yy) / 2;
  const root = Math.hypot((xx - yy) / 2, xy);
  return {a: Math.sqrt(mean + root), b: Math.sqrt(Math.max(0, mean - root)), angle: Math.atan2(2 * xy, xx - yy) / 2};
}

/** Returns the convex hull of points [x, y], counter-clockwise. */
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  if (sorted.length < 3) return sorted;
  const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = (list) => {
    const line = [];
    for (const point of list) {
      while (line.length > 1 && turn(line.at(-2), line.at(-1), point) <= 1e-12) line.pop();
      line.push(point);
    }
    line.pop();
    return line;
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
