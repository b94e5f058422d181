// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {decode, encode} from '../../../components/look/page/cdr.js';
import {Connection} from '../../../components/look/page/connection.js';
import {parseSchema} from '../../../components/look/page/ros2msg.js';
import {Robot} from '../../../components/look/page/robot.js';

/** Time that tests move. */
class Clock {
  constructor() {
    Object.assign(this, {time: 0, timers: new Map(), next: 1});
  }
  now() {
    return this.time;
  }
  setTimeout(callback, ms) {
    this.timers.set(this.next, {at: this.time + ms, callback});
    return this.next++;
  }
  clearTimeout(id) {
    this.timers.delete(id);
  }
  advance(ms) {
    const end = this.time + ms;
    for (;;) {
      const due = [...this.timers].filter(([, timer]) => timer.at <= end).sort((a, b) => a[1].at - b[1].at)[0];
      if (!due) break;
      this.timers.delete(due[0]);
      this.time = due[1].at;
      due[1].callback();
    }
    this.time = end;
  }
}

class Server {
  constructor(right = 'operate') {
    this.sockets = [];
    this.right = right;
    this.clock = new Clock();
    this.connection = new Connection('ws://robot', {clock: this.clock, open: (url, protocols) => this.accept(url, protocols)});
  }
  accept(url, protocols) {
    const socket = {
      protocols,
      readyState: 0,
      bufferedAmount: 0,
      sent: [],
      send: (data) => socket.sent.push(typeof data === 'string' ? JSON.parse(data) : data),
      close: () => {
        socket.readyState = 3;
      },
    };
    this.sockets.push(socket);
    return socket;
  }
  get socket() {
    return this.sockets.at(-1);
  }
  greet() {
    this.socket.readyState = 1;
    this.say({op: 'serverInfo', name: 'nacelle', capabilities: [], metadata: {'nacelle.right': this.right, 'nacelle.container': '/robot'}});
  }
  say(message) {
    this.socket.onmessage({data: message.op ? JSON.stringify(message) : message.buffer});
  }
  message(id, body) {
    const frame = new Uint8Array(13 + body.length);
    frame[0] = 1;
    new DataView(frame.buffer).setUint32(1, id, true);
    frame.set(body, 13);
    this.say(frame);
  }
  ops() {
    return this.socket.sent.map((one) => one.op ?? `binary ${one[0]}`);
  }
}

const NUMBER = parseSchema('std_msgs/msg/Int32', 'int32 data');
const CHANNEL = {id: 5, topic: '/n', encoding: 'cdr', schemaName: 'std_msgs/msg/Int32', schemaEncoding: 'ros2msg', schema: 'int32 data'};
const SERVICE = {
  id: 9,
  name: '/robot/_container/get_emergency_stops',
  type: 'nacelle_interfaces/srv/GetEmergencyStops',
  requestSchema: '',
  responseSchema: 'string[] topics',
};

function connected(right) {
  const server = new Server(right);
  server.connection.connect();
  server.greet();
  return server;
}

test('two readers of a topic share one subscription, which ends with the second', () => {
  const server = connected();
  const seen = [];
  const ends = [1, 2].map((n) => server.connection.subscribe('/n', (message, topic) => seen.push([n, topic, message.data])));
  assert.deepEqual(server.ops(), []);

  server.say({op: 'advertise', channels: [CHANNEL]});
  server.message(server.socket.sent[0].subscriptions[0].id, encode(NUMBER, {data: 42}));
  ends[0]();
  assert.deepEqual(server.ops(), ['subscribe']);
  ends[1]();

  assert.deepEqual(seen, [
    [1, '/n', 42],
    [2, '/n', 42],
  ]);
  assert.deepEqual(server.ops(), ['subscribe', 'unsubscribe']);
});

test('a lost connection is opened again, later each time, and subscribes anew', () => {
  const server = connected();
  const states = [];
  server.connection.on('state', (state) => states.push(state));
  server.connection.subscribe('/n', () => {});
  server.say({op: 'advertise', channels: [CHANNEL]});

  server.socket.onclose();
  server.clock.advance(499);
  assert.equal(server.sockets.length, 1);
  server.clock.advance(1);
  assert.equal(server.sockets.length, 2);
  server.socket.onclose();
  server.clock.advance(999);
  assert.equal(server.sockets.length, 2);
  server.clock.advance(1);
  server.greet();
  server.say({op: 'advertise', channels: [{...CHANNEL, id: 6}]});

  assert.deepEqual(states, ['lost', 'lost', 'open']);
  assert.equal(server.socket.sent[0].subscriptions[0].channelId, 6);
});

test('a channel that ends and comes back is subscribed again', () => {
  const server = connected();
  server.connection.subscribe('/n', () => {});
  server.say({op: 'advertise', channels: [CHANNEL]});
  server.say({op: 'unadvertise', channelIds: [5]});
  server.say({op: 'advertise', channels: [{...CHANNEL, id: 7}]});
  assert.deepEqual(server.ops(), ['subscribe', 'subscribe']);
  assert.deepEqual(server.connection.subscriptions.size, 1);
});

test('a call is answered, fails, or times out', async () => {
  const server = connected();
  server.say({op: 'advertiseServices', services: [SERVICE]});
  const calls = [1, 2, 3].map(() => server.connection.call(SERVICE.name, {}));
  const ids = server.socket.sent.map((frame) => new DataView(frame.buffer).getUint32(5, true));
  const body = encode(parseSchema('a/msg/B', 'string[] topics'), {topics: ['/emergency_stop']});
  const answer = new Uint8Array(16 + body.length);
  answer[0] = 3;
  new DataView(answer.buffer).setUint32(5, ids[0], true);
  new DataView(answer.buffer).setUint32(9, 3, true);
  answer.set(body, 16);
  server.say(answer);
  server.say({op: 'serviceCallFailure', serviceId: 9, callId: ids[1], message: 'no right'});
  server.clock.advance(15000);

  assert.deepEqual(await calls[0], {topics: ['/emergency_stop']});
  await assert.rejects(calls[1], /no right/);
  await assert.rejects(calls[2], /does not answer/);
  await assert.rejects(server.connection.call('/none'), /no service \/none/);
});

test('what waits for an answer fails when the connection is lost', async () => {
  const server = connected();
  server.say({op: 'advertiseServices', services: [SERVICE]});
  const call = server.connection.call(SERVICE.name);
  server.socket.onclose();
  await assert.rejects(call, /connection was lost/);
});

test('the emergency stop is published with the right to view, and what operates is disabled', () => {
  const server = new Server('view');
  const robot = new Robot(server.connection, server.clock);
  const words = [];
  robot.on('words', (text, isError) => words.push([text, isError]));
  server.connection.connect();

  assert.equal(robot.stop(), false);
  server.greet();
  assert.equal(robot.stop(), true);

  assert.match(words[0][0], /NOT SENT/);
  assert.equal(robot.mayOperate, false);
  assert.match(robot.whyNot, /may only look/);
  const [graph, advertised, frame] = server.socket.sent;
  assert.equal(graph.op, 'subscribeConnectionGraph');
  assert.deepEqual(
    advertised.channels.map(({topic, schemaName}) => [topic, schemaName]),
    [['/emergency_stop', 'std_msgs/msg/Bool']],
  );
  assert.deepEqual(decode(parseSchema('std_msgs/msg/Bool', 'bool data'), frame.subarray(5)), {data: true});
});

test('every topic that stops a base is published', () => {
  const server = new Server('view');
  const robot = new Robot(server.connection, server.clock);
  server.connection.connect();
  server.greet();
  server.say({
    op: 'connectionGraphUpdate',
    publishedTopics: [],
    subscribedTopics: [
      {name: '/a/emergency_stop', subscriberIds: ['/a/base']},
      {name: '/scan', subscriberIds: []},
    ],
    advertisedServices: [],
    removedTopics: [],
    removedServices: [],
  });
  server.say({op: 'advertise', channels: [{...CHANNEL, topic: '/b/emergency_stop', schemaName: 'std_msgs/msg/Bool'}]});
  assert.deepEqual(robot.stopTopics().sort(), ['/a/emergency_stop', '/b/emergency_stop']);
});

test('a robot that answers nothing is given up', async () => {
  const server = new Server();
  new Robot(server.connection, server.clock);
  server.connection.connect();
  server.greet();
  server.say({op: 'advertiseServices', services: [SERVICE]});
  server.clock.advance(300);
  await Promise.resolve();
  assert.deepEqual(server.ops(), ['subscribeConnectionGraph', 'binary 2']);
  server.clock.advance(7000);
  for (let i = 0; i < 10; ++i) await Promise.resolve();
  assert.equal(server.connection.state, 'lost');
});
