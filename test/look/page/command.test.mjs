// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {CommandSender, PERIOD_MS, commandTopics} from '../../../components/look/page/command.js';
import {Emitter} from '../../../components/look/page/emitter.js';
import {stickOf} from '../../../components/look/page/joystick.js';

class Clock {
  constructor() {
    Object.assign(this, {time: 0, tick: null});
  }
  now() {
    return this.time;
  }
  setInterval(callback, ms) {
    assert.equal(ms, PERIOD_MS);
    this.tick = callback;
    return 1;
  }
  clearInterval() {
    this.tick = null;
  }
  periods(count) {
    for (let i = 0; i < count && this.tick; ++i) {
      this.time += PERIOD_MS;
      this.tick();
    }
  }
}

function held({right = 'operate', channels = []} = {}) {
  const connection = Object.assign(new Emitter(), {
    isOpen: true,
    lastReceived: 0,
    unsentBytes: 0,
    channels: new Map(channels.map((one, i) => [i, one])),
    graph: {subscribed: new Map()},
    sent: [],
  });
  connection.publish = (topic, schema, message) => connection.sent.push([schema.name, message.twist ?? message]);
  const robot = Object.assign(new Emitter(), {connection, right});
  Object.defineProperties(robot, {
    mayOperate: {
      get() {
        return this.right === 'operate';
      },
    },
    whyNot: {
      get() {
        return this.right === 'operate' ? '' : 'no right';
      },
    },
  });
  const clock = new Clock();
  const sender = new CommandSender(robot, clock);
  sender.topic = '/cmd_vel_teleop';
  const reasons = [];
  sender.onRelease = (why) => reasons.push(why);
  return {connection, robot, clock, sender, reasons, speeds: () => connection.sent.map(([, twist]) => twist.linear.x)};
}

test('sends at 20 Hz while it is held, then zero, then nothing', () => {
  const {clock, sender, connection, speeds} = held();
  assert.equal(1000 / PERIOD_MS, 20);
  assert.ok(sender.grip());
  sender.set(0.3, -0.5);
  clock.periods(3);
  sender.release();
  clock.periods(10);
  assert.deepEqual(speeds(), [0, 0.3, 0.3, 0.3, 0]);
  assert.equal(connection.sent[1][1].angular.z, -0.5);
  assert.equal(sender.isHeld, false);
});

test('a grip begins with no speed, whatever the last one had', () => {
  const {clock, sender, speeds} = held();
  sender.grip();
  sender.set(0.3, 0);
  clock.periods(1);
  sender.release();
  sender.grip();
  clock.periods(1);
  assert.deepEqual(speeds(), [0, 0.3, 0, 0, 0]);
});

test('without the right to operate nothing is sent', () => {
  const {sender, speeds, reasons} = held({right: 'view'});
  assert.equal(sender.grip(), false);
  assert.deepEqual([speeds(), reasons], [[], ['no right']]);
});

for (const [what, happen, reason] of [
  ['the connection is lost', ({connection}) => connection.emit('state', 'lost'), /connection was lost/],
  [
    'the right is gone',
    ({robot}) => {
      robot.right = 'view';
      robot.emit('right', 'view');
    },
    /no right/,
  ],
  ['nothing comes from the robot', ({clock}) => clock.periods(11), /Nothing came/],
  [
    'commands wait in the socket',
    ({connection, clock}) => {
      connection.unsentBytes = 4000;
      clock.periods(1);
    },
    /too slow/,
  ],
]) {
  test(`the grip ends when ${what}`, () => {
    const all = held();
    all.sender.isHeard = true;
    all.sender.grip();
    all.sender.set(0.3, 0);
    all.clock.periods(2);
    happen(all);
    const count = all.connection.sent.length;
    all.clock.periods(20);
    assert.equal(all.sender.isHeld, false);
    assert.equal(all.connection.sent.length, count);
    assert.equal(all.speeds().at(-1), 0);
    assert.match(all.reasons.at(-1), reason);
  });
}

test('sends the type that the topic has', () => {
  const channel = (schemaName) => ({topic: '/cmd_vel_teleop', schemaName});
  const typeFor = (channels) => {
    const {sender, connection} = held({channels});
    sender.grip();
    return connection.sent[0][0];
  };
  assert.equal(typeFor([]), 'geometry_msgs/Twist');
  assert.equal(typeFor([channel('geometry_msgs/msg/TwistStamped')]), 'geometry_msgs/TwistStamped');
  assert.equal(typeFor([channel('geometry_msgs/msg/TwistStamped'), channel('geometry_msgs/msg/Twist')]), 'geometry_msgs/Twist');
});

test('a topic for a person comes before that of navigation', () => {
  const connection = {
    channels: new Map([[1, {topic: '/cmd_vel', schemaName: 'geometry_msgs/msg/Twist'}]]),
    graph: {
      subscribed: new Map([
        ['/cmd_vel_teleop', []],
        ['/cmd_vel', []],
        ['/scan', []],
      ]),
    },
  };
  assert.deepEqual(commandTopics(connection), ['/cmd_vel_teleop', '/cmd_vel']);
});

test('the stick has a dead zone and ends at the rim', () => {
  assert.deepEqual(stickOf(0.05, 0.05), [0, 0]);
  assert.deepEqual(stickOf(0, 3), [0, 1]);
  const [x, y] = stickOf(0.6, 0.8);
  assert.ok(Math.abs(Math.hypot(x, y) - 1) < 1e-12 && x > 0);
  assert.deepEqual(stickOf(NaN, 0), [0, 0]);
});
