// SPDX-License-Identifier: Apache-2.0
// A client of the Foxglove WebSocket protocol. Subscriptions, watched parameters and the watched graph outlive the connection: a lost one is
// opened again, and they are asked for anew.
import {decode, encode} from './cdr.js';
import {Emitter} from './emitter.js';
import {parseSchema} from './ros2msg.js';

const PROTOCOLS = ['foxglove.sdk.v1', 'foxglove.websocket.v1'];
const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 10000;
const CALL_LIMIT_MS = 15000;
const UTF8 = new TextDecoder();
const TO_UTF8 = new TextEncoder();

/** Emits: state (connecting, open, lost), serverInfo, channels, services, graph, parameters (changed ones), status. */
export class Connection extends Emitter {
  /** `open(url, protocols)` makes a WebSocket, `clock` has setTimeout, clearTimeout and now: tests give their own. */
  constructor(url, {open = (...words) => new WebSocket(...words), clock = systemClock()} = {}) {
    super();
    Object.assign(this, {url, openSocket: open, clock});
    this.state = 'connecting';
    this.info = null;
    this.channels = new Map(); // id -> channel
    this.services = new Map(); // name -> service
    this.graph = emptyGraph();
    this.lastReceived = -Infinity;
    this.failures = 0; // attempts in a row without a serverInfo
    this.wishes = new Set(); // of subscribe()
    this.subscriptions = new Set();
    this.byId = new Map(); // id on the wire -> subscription
    this.calls = new Map();
    this.assets = new Map();
    this.adverts = new Map(); // client channels by topic and type
    this.graphWatchers = 0;
    this.watchedParameters = new Map(); // name -> count
    this.nextId = 1;
  }

  connect() {
    this.clock.clearTimeout(this.retry);
    const socket = this.openSocket(this.url, PROTOCOLS);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onmessage = (event) => {
      if (socket === this.socket) this.receive(event.data);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lose();
    };
    socket.onerror = () => {}; // onclose follows
  }

  /** Opens it anew at once: the user asked for it, or the machine has its network back. */
  reconnect() {
    if (this.state === 'open') return;
    this.drop();
    this.connect();
  }

  /** Gives a connection up that answers nothing. */
  giveUp() {
    if (!this.socket) return;
    this.drop();
    this.lose();
  }

  drop() {
    const socket = this.socket;
    this.socket = null;
    if (socket) socket.close();
  }

  lose() {
    this.socket = null;
    ++this.failures;
    this.channels.clear();
    this.services.clear();
    this.graph = emptyGraph();
    this.byId.clear();
    this.adverts.clear();
    for (const subscription of this.subscriptions) subscription.channel = null;
    for (const waiting of [this.calls, this.assets]) {
      for (const {reject, timer} of waiting.values()) {
        this.clock.clearTimeout(timer);
        reject(new Error('the connection was lost'));
      }
      waiting.clear();
    }
    this.retryMs = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** (this.failures - 1));
    this.setState('lost');
    this.clock.clearTimeout(this.retry);
    this.retry = this.clock.setTimeout(() => this.connect(), this.retryMs);
  }

  setState(state) {
    this.state = state;
    this.emit('state', state);
  }

  get isOpen() {
    return this.state === 'open';
  }
  get unsentBytes() {
    return this.socket ? this.socket.bufferedAmount : 0;
  }
  send(message) {
    if (this.socket && this.socket.readyState === 1) this.socket.send(JSON.stringify(message));
  }

  // --- what arrives ---

  receive(data) {
    this.lastReceived = this.clock.now();
    if (typeof data !== 'string') return this.receiveBinary(new Uint8Array(data));
    const message = JSON.parse(data);
    const handler = HANDLERS[message.op];
    if (handler) handler.call(this, message);
  }

  receiveBinary(bytes) {
    if (bytes.length < 9) return;
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    if (bytes[0] === 1 && bytes.length >= 13) this.receiveMessage(view.getUint32(1, true), view.getBigUint64(5, true), bytes.subarray(13));
    else if (bytes[0] === 3 && bytes.length >= 13) this.receiveResponse(view.getUint32(5, true), bytes.subarray(13 + view.getUint32(9, true)));
    else if (bytes[0] === 4 && bytes.length >= 10) this.receiveAsset(view, bytes);
  }

  receiveMessage(id, time, bytes) {
    const subscription = this.byId.get(id);
    if (!subscription) return;
    let message;
    try {
      message = decode(this.schemaOf(subscription.channel), bytes);
    } catch (problem) {
      return this.emit('status', {level: 2, message: `${subscription.channel.topic}: ${problem.message}`});
    }
    for (const callback of [...subscription.callbacks]) callback(message, subscription.channel.topic, time, bytes.length);
  }

  receiveResponse(callId, bytes) {
    const call = this.take(this.calls, callId);
    if (!call) return;
    try {
      call.resolve(decode(call.schema, bytes));
    } catch (problem) {
      call.reject(problem);
    }
  }

  receiveAsset(view, bytes) {
    const asset = this.take(this.assets, view.getUint32(1, true));
    const end = 10 + view.getUint32(6, true);
    if (!asset) return;
    if (bytes[5] === 0) asset.resolve(bytes.slice(end));
    else asset.reject(new Error(UTF8.decode(bytes.subarray(10, end))));
  }

  schemaOf(channel) {
    channel.parsed ??= parseSchema(channel.schemaName, channel.schema);
    return channel.parsed;
  }

  take(waiting, id) {
    const found = waiting.get(id);
    if (found) this.clock.clearTimeout(found.timer);
    waiting.delete(id);
    return found;
  }

  // --- subscriptions ---

  /** Subscribes to the channel that `pick` (a topic, or a function of an array of channels that returns one) selects, now and whenever channels
   * change. `callback` gets (message, topic, time in ns, size). Returns a function that ends it. */
  subscribe(pick, callback) {
    const chosen = typeof pick === 'string' ? (channels) => channels.find((channel) => channel.topic === pick) : pick;
    const own = {pick: chosen, callback, shared: null};
    this.wishes.add(own);
    this.join(own);
    return () => {
      this.wishes.delete(own);
      this.leave(own);
    };
  }

  join(own) {
    const channel = this.isOpen ? own.pick([...this.channels.values()]) : null;
    if (own.shared && own.shared.channel === channel) return;
    this.leave(own);
    if (!channel) return;
    let shared = [...this.subscriptions].find((one) => one.channel === channel);
    if (!shared) {
      shared = {id: this.nextId++, channel, callbacks: new Set()};
      this.subscriptions.add(shared);
      this.byId.set(shared.id, shared);
      this.send({op: 'subscribe', subscriptions: [{id: shared.id, channelId: channel.id}]});
    }
    shared.callbacks.add(own.callback);
    own.shared = shared;
  }

  leave(own) {
    const shared = own.shared;
    own.shared = null;
    if (!shared) return;
    shared.callbacks.delete(own.callback);
    if (shared.callbacks.size > 0) return;
    this.subscriptions.delete(shared);
    this.byId.delete(shared.id);
    if (shared.channel) this.send({op: 'unsubscribe', subscriptionIds: [shared.id]});
  }

  rejoin() {
    for (const own of this.wishes) this.join(own);
  }

  // --- services ---

  hasService(name) {
    return this.services.has(name);
  }

  /** Calls a service; what `request` leaves out has its default. */
  call(name, request = {}, limitMs = CALL_LIMIT_MS) {
    const service = this.services.get(name);
    if (!service) return Promise.reject(new Error(this.isOpen ? `the robot has no service ${name}` : 'not connected'));
    let body;
    try {
      service.requestParsed ??= parseSchema(`${service.type}_Request`, service.request?.schema ?? service.requestSchema ?? '');
      service.responseParsed ??= parseSchema(`${service.type}_Response`, service.response?.schema ?? service.responseSchema ?? '');
      body = encode(service.requestParsed, request);
    } catch (problem) {
      return Promise.reject(problem);
    }
    const callId = this.nextId++;
    const frame = new Uint8Array(16 + body.length);
    const view = new DataView(frame.buffer);
    frame[0] = 2;
    view.setUint32(1, service.id, true);
    view.setUint32(5, callId, true);
    view.setUint32(9, 3, true);
    frame.set(TO_UTF8.encode('cdr'), 13);
    frame.set(body, 16);
    return this.ask(this.calls, callId, limitMs, `${name} does not answer`, () => this.socket.send(frame), {schema: service.responseParsed});
  }

  fetchAsset(uri) {
    const requestId = this.nextId++;
    return this.ask(this.assets, requestId, CALL_LIMIT_MS, `${uri} does not come`, () => this.send({op: 'fetchAsset', uri, requestId}));
  }

  ask(waiting, id, limitMs, words, send, more = {}) {
    if (!this.isOpen) return Promise.reject(new Error('not connected'));
    return new Promise((resolve, reject) => {
      const timer = this.clock.setTimeout(() => {
        waiting.delete(id);
        reject(new Error(words));
      }, limitMs);
      waiting.set(id, {resolve, reject, timer, ...more});
      send();
    });
  }

  // --- publishing ---

  /** Publishes a message. Returns false if there is no connection. */
  publish(topic, schema, message) {
    if (!this.isOpen || this.socket.readyState !== 1) return false;
    const key = `${topic} ${schema.name}`;
    let id = this.adverts.get(key);
    if (id === undefined) {
      id = this.nextId++;
      this.adverts.set(key, id);
      this.send({op: 'advertise', channels: [{id, topic, encoding: 'cdr', schemaName: schema.name.replace('/', '/msg/')}]});
    }
    const body = encode(schema, message);
    const frame = new Uint8Array(5 + body.length);
    frame[0] = 1;
    new DataView(frame.buffer).setUint32(1, id, true);
    frame.set(body, 5);
    this.socket.send(frame);
    return true;
  }

  /** Ends what publish() began on the topic. */
  unpublish(topic) {
    for (const [key, id] of this.adverts) {
      if (!key.startsWith(`${topic} `)) continue;
      this.adverts.delete(key);
      this.send({op: 'unadvertise', channelIds: [id]});
    }
  }

  // --- parameters and the graph ---

  watchParameters(names) {
    const added = names.filter((name) => !this.watchedParameters.has(name));
    for (const name of names) this.watchedParameters.set(name, (this.watchedParameters.get(name) ?? 0) + 1);
    if (added.length > 0) this.send({op: 'subscribeParameterUpdates', parameterNames: added});
    return () => {
      const removed = [];
      for (const name of names) {
        const count = this.watchedParameters.get(name) - 1;
        if (count > 0) this.watchedParameters.set(name, count);
        else if (this.watchedParameters.delete(name)) removed.push(name);
      }
      if (removed.length > 0) this.send({op: 'unsubscribeParameterUpdates', parameterNames: removed});
    };
  }

  watchGraph() {
    if (++this.graphWatchers === 1) this.send({op: 'subscribeConnectionGraph'});
    return () => {
      if (--this.graphWatchers === 0) this.send({op: 'unsubscribeConnectionGraph'});
    };
  }
}

const HANDLERS = {
  serverInfo(message) {
    this.info = message;
    this.failures = 0;
    this.setState('open');
    this.emit('serverInfo', message);
    if (this.graphWatchers > 0) this.send({op: 'subscribeConnectionGraph'});
    if (this.watchedParameters.size > 0) this.send({op: 'subscribeParameterUpdates', parameterNames: [...this.watchedParameters.keys()]});
  },
  advertise({channels}) {
    for (const channel of channels) this.channels.set(channel.id, channel);
    this.rejoin();
    this.emit('channels');
  },
  unadvertise({channelIds}) {
    for (const id of channelIds) {
      const channel = this.channels.get(id);
      this.channels.delete(id);
      for (const one of this.subscriptions) {
        if (one.channel === channel) one.channel = undefined; // the server has ended it
      }
    }
    this.rejoin();
    this.emit('channels');
  },
  advertiseServices({services}) {
    for (const service of services) this.services.set(service.name, service);
    this.emit('services');
  },
  unadvertiseServices({serviceIds}) {
    for (const [name, {id}] of this.services) {
      if (serviceIds.includes(id)) this.services.delete(name);
    }
    this.emit('services');
  },
  serviceCallFailure({callId, message}) {
    this.take(this.calls, callId)?.reject(new Error(message));
  },
  parameterValues({parameters}) {
    this.emit('parameters', parameters);
  },
  connectionGraphUpdate(update) {
    const {graph} = this;
    for (const {name, publisherIds} of update.publishedTopics ?? []) graph.published.set(name, publisherIds);
    for (const {name, subscriberIds} of update.subscribedTopics ?? []) graph.subscribed.set(name, subscriberIds);
    for (const {name, providerIds} of update.advertisedServices ?? []) graph.services.set(name, providerIds);
    for (const name of update.removedTopics ?? []) {
      graph.published.delete(name);
      graph.subscribed.delete(name);
    }
    for (const name of update.removedServices ?? []) graph.services.delete(name);
    this.emit('graph', graph);
  },
  status(message) {
    this.emit('status', message);
  },
};

function emptyGraph() {
  return {published: new Map(), subscribed: new Map(), services: new Map()};
}

function systemClock() {
  return {setTimeout: (...words) => setTimeout(...words), clearTimeout: (id) => clearTimeout(id), now: () => performance.now()};
}
