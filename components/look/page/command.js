// SPDX-License-Identifier: Apache-2.0
// Sends velocity commands while a grip is held, and never longer.
import {parseSchema} from './ros2msg.js';

const VECTOR = 'float64 x\nfloat64 y\nfloat64 z\n';
const LINE = `${'='.repeat(80)}\n`;
const TWIST_TEXT = `Vector3 linear\nVector3 angular\n${LINE}MSG: geometry_msgs/Vector3\n${VECTOR}`;
const TWIST = parseSchema('geometry_msgs/msg/Twist', TWIST_TEXT);
const STAMPED = parseSchema(
  'geometry_msgs/msg/TwistStamped',
  `std_msgs/Header header\nTwist twist\n${LINE}MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n` +
    `${LINE}MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n${LINE}MSG: geometry_msgs/Twist\n${TWIST_TEXT}`,
);
export const PERIOD_MS = 50;
// A command that waits in a socket would drive the robot when the network is back, so that commands end when nothing comes from there.
const SILENCE_MS = 500;
const MOST_UNSENT_BYTES = 2048;

/** Returns the topics that the base takes commands from, the best for a person first. */
export function commandTopics(connection) {
  const found = new Set();
  for (const {topic, schemaName} of connection.channels.values()) {
    if (/^geometry_msgs\/msg\/Twist(Stamped)?$/.test(schemaName)) found.add(topic);
  }
  for (const topic of connection.graph.subscribed.keys()) {
    if (/(^|\/)cmd_vel[^/]*$/.test(topic)) found.add(topic);
  }
  const rank = (topic) => (/teleop|joy|operator/.test(topic) ? 0 : /(^|\/)cmd_vel$/.test(topic) ? 1 : 2);
  return [...found].sort((a, b) => rank(a) - rank(b) || (a < b ? -1 : 1));
}

/** Sends while it is held. `clock` has setInterval, clearInterval and now: tests give their own. */
export class CommandSender {
  constructor(robot, clock = {setInterval: (...w) => setInterval(...w), clearInterval: (id) => clearInterval(id), now: () => performance.now()}) {
    Object.assign(this, {robot, clock, connection: robot.connection});
    this.topic = '';
    this.timer = null;
    this.velocity = {linear: 0, angular: 0};
    this.isHeard = false; // something is subscribed that comes often, so that silence means a lost network
    this.onRelease = () => {};
    this.connection.on('state', (state) => {
      if (state !== 'open') this.release('The connection was lost: the base stops by its own timeout.');
    });
    robot.on('right', () => {
      if (!robot.mayOperate) this.release(robot.whyNot);
    });
  }

  get isHeld() {
    return this.timer !== null;
  }

  /** Begins to send. Returns false, with the reason through onRelease, if it may not. */
  grip() {
    if (this.isHeld) return true;
    if (!this.robot.mayOperate || this.topic === '') {
      this.onRelease(this.robot.whyNot || 'The robot has no topic for commands.');
      return false;
    }
    this.velocity = {linear: 0, angular: 0};
    this.timer = this.clock.setInterval(() => this.tick(), PERIOD_MS);
    this.tick();
    return true;
  }

  /** Metres and radians per second. */
  set(linear, angular) {
    this.velocity = {linear, angular};
  }

  /** Ends: sends a command of zero, if it can, and nothing more. */
  release(why = '') {
    if (!this.isHeld) return;
    this.clock.clearInterval(this.timer);
    this.timer = null;
    this.velocity = {linear: 0, angular: 0};
    this.send();
    this.onRelease(why);
  }

  tick() {
    if (this.isHeard && this.clock.now() - this.connection.lastReceived > SILENCE_MS)
      return this.release('Nothing came from the robot for 0.5 s. Let go and grip again.');
    if (this.connection.unsentBytes > MOST_UNSENT_BYTES) return this.release('The network is too slow to drive. Let go and grip again.');
    this.send();
  }

  send() {
    const twist = {linear: {x: this.velocity.linear}, angular: {z: this.velocity.angular}};
    const types = new Set([...this.connection.channels.values()].filter(({topic}) => topic === this.topic).map(({schemaName}) => schemaName));
    if (types.size === 1 && types.has('geometry_msgs/msg/TwistStamped'))
      this.connection.publish(this.topic, STAMPED, {twist}); // a stamp of 0: now
    else this.connection.publish(this.topic, TWIST, twist);
  }
}
