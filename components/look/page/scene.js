// SPDX-License-Identifier: Apache-2.0
// What the two views draw: frames, scans, paths and the robot's shapes.
import {apply, hull, poseOf} from './geometry.js';
import {TransformTree, secondsOf} from './tf.js';
import {facesOf, readStl, readUrdf} from './urdf.js';

const PATH_POINTS = 3000;
const PATH_STEP_M = 0.02;
const JUMP_M = 1.0;
const COLOURS = ['--path-1', '--path-2', '--path-3', '--path-4'];

/** Returns the channels of a type, those of well-known names first. */
export function ofType(channels, type, first = []) {
  const rank = (topic) => (first.indexOf(topic) + first.length + 1) % (first.length + 1);
  return channels.filter((channel) => channel.schemaName === type).sort((a, b) => rank(a.topic) - rank(b.topic) || (a.topic < b.topic ? -1 : 1));
}

export class Scene {
  constructor(connection) {
    this.connection = connection;
    this.tf = new TransformTree();
    this.scans = new Map(); // topic -> {frame, points, time}
    this.paths = new Map(); // topic -> {frame, points, pose, covariance, colour}
    this.links = [];
    this.footprint = null; // {frame, points}
    this.counts = {tf: 0, scan: 0, odometry: 0, description: 0};
    this.version = 0;
    this.ends = [];
    this.topics = new Map(); // subscribed one by one, since there may be several of a type
  }

  start() {
    const on = (pick, callback) => this.ends.push(this.connection.subscribe(pick, callback));
    const firstOf = (type, first) => (channels) => ofType(channels, type, first)[0];
    for (const name of ['tf', 'tf_static']) {
      // a namespace may be before them
      on(
        (channels) => ofType(channels, 'tf2_msgs/msg/TFMessage', [`/${name}`]).find(({topic}) => topic.endsWith(`/${name}`)),
        (message) => this.addTransforms(message),
      );
    }
    on(
      (channels) => channels.find(({topic, schemaName}) => /(^|\/)robot_description$/.test(topic) && schemaName === 'std_msgs/msg/String'),
      (message) => this.describe(message.data),
    );
    on(firstOf('geometry_msgs/msg/PolygonStamped'), (message) => this.addFootprint(message));
    this.ends.push(this.connection.on('channels', () => this.follow()));
    this.follow();
  }

  stop() {
    for (const end of this.ends.splice(0)) end();
    for (const end of this.topics.values()) end();
    this.topics.clear();
    this.scans.clear();
  }

  /** Subscribes to every scan and odometry that there is. */
  follow() {
    for (const {topic, schemaName} of this.connection.channels.values()) {
      if (this.topics.has(topic)) continue;
      const callback = {
        'sensor_msgs/msg/LaserScan': (message) => this.addScan(topic, message),
        'nav_msgs/msg/Odometry': (message) => this.addOdometry(topic, message),
      }[schemaName];
      if (callback) this.topics.set(topic, this.connection.subscribe(topic, callback));
    }
  }

  changed(what) {
    ++this.counts[what];
    ++this.version;
  }

  addTransforms(message) {
    this.tf.add(message);
    this.changed('tf');
  }

  addScan(topic, scan) {
    const points = [];
    for (let i = 0; i < scan.ranges.length; ++i) {
      const range = scan.ranges[i];
      if (!(range >= scan.range_min && range <= scan.range_max)) continue;
      const angle = scan.angle_min + i * scan.angle_increment;
      points.push([range * Math.cos(angle), range * Math.sin(angle), 0]);
    }
    const time = secondsOf(scan.header.stamp) + (scan.ranges.length / 2) * scan.time_increment; // the middle of its turn
    this.scans.set(topic, {frame: scan.header.frame_id, points, time});
    this.changed('scan');
  }

  addOdometry(topic, message) {
    let path = this.paths.get(topic);
    if (!path) {
      path = {points: []};
      this.paths = new Map([...this.paths, [topic, path]].sort(([a], [b]) => (a < b ? -1 : 1)));
      [...this.paths.values()].forEach((one, i) => {
        one.colour = COLOURS[i % COLOURS.length];
      });
    }
    path.frame = message.header.frame_id;
    path.child = message.child_frame_id;
    path.pose = poseOf(message.pose.pose);
    const {covariance} = message.pose;
    path.covariance = [covariance[0], covariance[1], covariance[7]];
    path.twist = message.twist.twist;
    const last = path.points.at(-1);
    const step = last ? Math.hypot(path.pose.p[0] - last[0], path.pose.p[1] - last[1]) : Infinity;
    if (last && step > JUMP_M) path.points.length = 0; // it was reset: a line across would be no path
    if (step > PATH_STEP_M) path.points.push(path.pose.p);
    if (path.points.length > PATH_POINTS) path.points.splice(0, path.points.length - PATH_POINTS);
    this.changed('odometry');
  }

  addFootprint(message) {
    this.footprint = {frame: message.header.frame_id, points: message.polygon.points.map(({x, y}) => [x, y, 0])};
    ++this.version;
  }

  describe(text) {
    if (text === this.description) return;
    this.description = text;
    const robot = readUrdf(new DOMParser().parseFromString(text, 'text/xml'));
    this.links = robot.links;
    this.joints = robot.joints;
    for (const link of this.links) {
      for (const shape of link.visuals) {
        if (shape.kind === 'mesh') this.fetchMesh(shape);
        shape.faces = facesOf(shape);
      }
    }
    this.changed('description');
  }

  async fetchMesh(shape) {
    try {
      shape.triangles = readStl(await this.connection.fetchAsset(shape.uri));
      shape.faces = facesOf(shape);
      ++this.version;
    } catch (problem) {
      this.connection.emit('status', {level: 1, message: `${shape.uri}: ${problem.message}`});
    }
  }

  clearPaths() {
    for (const path of this.paths.values()) path.points.length = 0;
    ++this.version;
  }

  /** The frame that everything is drawn in. */
  get fixed() {
    return this.tf.fixedFrame() || [...this.paths.values()][0]?.frame || '';
  }

  /** The pose of a frame in the fixed one, at a time in s or the newest; null: unknown. */
  poseOf(frame, fixed = this.fixed, time = undefined) {
    return this.tf.lookup(fixed, frame, time);
  }

  /** The frame that carries the robot: what the odometry moves, else the first link. */
  get base() {
    return [...this.paths.values()][0]?.child || this.links[0]?.name || '';
  }

  /** The outline of the robot on the ground in its base's frame: a published footprint, else the hull of its collision shapes. */
  outline() {
    if (this.footprint) return this.footprint;
    if (this.hullOf !== this.links) {
      const points = [];
      for (const link of this.links) {
        const pose = this.tf.lookup(this.base, link.name);
        if (!pose) return null;
        for (const shape of link.collisions) for (const face of facesOf(shape)) for (const corner of face) points.push(apply(pose, corner));
      }
      if (points.length === 0) return null;
      this.hullPoints = hull(points.map(([x, y]) => [x, y])).map(([x, y]) => [x, y, 0]);
      this.hullOf = this.links;
    }
    return this.hullPoints && this.hullPoints.length > 0 ? {frame: this.base, points: this.hullPoints} : null;
  }
}
