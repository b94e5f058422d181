// SPDX-License-Identifier: Apache-2.0
// What the page knows of the robot, and the questions that it asks its container's services.
import {Emitter} from './emitter.js';
import {parseSchema} from './ros2msg.js';

const BOOL = parseSchema('std_msgs/msg/Bool', 'bool data\n');
const COMPONENTS = '/_container/get_components';
const HEARTBEAT_MS = 1000;
const SILENCE_MS = 6000;

/** Emits: right (view, operate or empty), stops (topics on which an emergency stop is set), words (a text for the user, and whether it is an
 * error). */
export class Robot extends Emitter {
  constructor(connection, clock = {setTimeout: (...w) => setTimeout(...w), clearTimeout: (id) => clearTimeout(id), now: () => performance.now()}) {
    super();
    Object.assign(this, {connection, clock});
    this.right = '';
    this.name = '';
    this.stops = [];
    this.polls = new Map();
    this.isAwake = true;
    connection.on('serverInfo', ({name, metadata = {}}) => {
      this.right = metadata['nacelle.right'] ?? 'view';
      this.name = name || '';
      this.emit('right', this.right);
    });
    connection.on('state', (state) => {
      if (state === 'open') return;
      this.right = '';
      this.emit('right', '');
    });
    connection.on('status', ({message, level}) => this.emit('words', message, level > 0));
    connection.watchGraph(); // says which topics stop a base
    this.poll('get_emergency_stops', {}, HEARTBEAT_MS, (answer) => this.noteStops(answer), {alsoAsleep: true});
  }

  get mayOperate() {
    return this.right === 'operate';
  }

  /** Why a control that needs `operate` is disabled; empty: it is not. */
  get whyNot() {
    if (this.right === 'operate') return '';
    if (this.right === '') return 'Not connected to the robot.';
    return 'This link may only look. Open the link with the right to operate, which `nacelle look` prints.';
  }

  /** The full name of the container's node; empty: not known yet. */
  get container() {
    const given = this.connection.info?.metadata?.['nacelle.container'];
    if (given) return given;
    const found = [...this.connection.services.keys()].find((name) => name.endsWith(COMPONENTS));
    return found ? found.slice(0, -COMPONENTS.length) : '';
  }

  /** The full name of a service of the container: service('get_statistics') or service('/lidar/get_parameters'). */
  service(name) {
    return name.startsWith('/') ? name : `${this.container}/_container/${name}`;
  }

  /** Calls a service. Rejects if its answer has `success: false`, with the reason. */
  async call(name, request = {}, limitMs = undefined) {
    const answer = await this.connection.call(this.service(name), request, limitMs);
    if (answer.success === false) {
      const {problem} = answer;
      const words = problem ? [problem.where, problem.what].filter(Boolean).join(': ') + (problem.way_out ? `; ${problem.way_out}` : '') : '';
      throw new Error(words || answer.error_message || answer.reason || `${name} was refused`);
    }
    return answer;
  }

  /** Calls a service for a button: a failure is shown to the user. Returns the answer, or null. */
  async order(what, name, request, limitMs = 60000) {
    try {
      const answer = await this.call(name, request, limitMs);
      this.emit('words', `${what}: done`, false);
      return answer;
    } catch (problem) {
      this.emit('words', `${what}: ${problem.message}`, true);
      return null;
    }
  }

  /** Asks a service again and again; all that ask the same share the answers. `callback` gets (answer, error). Returns a function that ends it. */
  poll(name, request, periodMs, callback, {alsoAsleep = false} = {}) {
    const key = `${name} ${JSON.stringify(request)}`;
    let poll = this.polls.get(key);
    if (!poll) {
      poll = {name, request, periodMs, callbacks: new Set(), timer: null, alsoAsleep};
      this.polls.set(key, poll);
      this.ask(poll);
    } else if (poll.last) {
      callback(poll.last, null);
    }
    poll.callbacks.add(callback);
    return () => {
      poll.callbacks.delete(callback);
      if (poll.callbacks.size > 0) return;
      this.clock.clearTimeout(poll.timer);
      poll.ended = true;
      if (this.polls.get(key) === poll) this.polls.delete(key);
    };
  }

  async ask(poll) {
    if (this.connection.hasService(this.service(poll.name)) && (this.isAwake || poll.alsoAsleep)) {
      try {
        poll.last = await this.call(poll.name, poll.request, SILENCE_MS);
        for (const callback of [...poll.callbacks]) callback(poll.last, null);
      } catch (problem) {
        if (this.connection.isOpen && this.clock.now() - this.connection.lastReceived > SILENCE_MS) this.connection.giveUp();
        for (const callback of [...poll.callbacks]) callback(null, problem);
      }
    }
    if (!poll.ended) poll.timer = this.clock.setTimeout(() => this.ask(poll), this.connection.isOpen ? poll.periodMs : 300);
  }

  // --- the emergency stop ---

  noteStops(answer) {
    if (!answer) return;
    this.stops = answer.topics;
    this.emit('stops', this.stops);
  }

  /** The topics that an emergency stop is set on. */
  stopTopics() {
    const topics = new Set();
    for (const {topic, schemaName} of this.connection.channels.values()) {
      if (schemaName === 'std_msgs/msg/Bool' && /(^|\/)emergency_stop$/.test(topic)) topics.add(topic);
    }
    for (const topic of this.connection.graph.subscribed.keys()) {
      if (/(^|\/)emergency_stop$/.test(topic)) topics.add(topic);
    }
    return topics.size > 0 ? [...topics] : ['/emergency_stop'];
  }

  /** Sets the emergency stop. Needs no right but `view`. */
  stop() {
    const sent = this.stopTopics().filter((topic) => this.connection.publish(topic, BOOL, {data: true}));
    if (sent.length === 0) this.emit('words', 'Emergency stop: NOT SENT, the robot is not connected.', true);
    return sent.length > 0;
  }

  releaseStops() {
    return this.order('Release the emergency stop', 'release_emergency_stops', {topics: []});
  }
}
