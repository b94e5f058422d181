// SPDX-License-Identifier: Apache-2.0
import {element, select, setText} from '../dom.js';
import {Panel} from '../panel.js';

const COMPRESSED = 'sensor_msgs/msg/CompressedImage';

/** One camera's image: the JPEG pictures that the server makes of a raw topic, or a topic of compressed images. */
export class CameraPanel extends Panel {
  constructor(robot) {
    super(robot, 'camera', 'Camera');
    this.image = element('img', {alt: 'The camera image, when it has come', onload: () => this.describe()});
    this.facts = element('p', {class: 'facts'});
    this.topics = select([], {'aria-label': 'Topic of images', onchange: () => this.choose(this.topics.value)});
    this.tools.append(this.topics);
    this.body.append(this.image, this.facts);
    this.topic = '';
    this.frames = 0;
    this.width = 0;
    this.times = [];
  }

  start() {
    this.on(this.connection, 'channels', () => this.list());
    this.list();
    this.subscribe(
      (channels) => this.pick(channels),
      (message, topic, time, size) => this.take(message, topic, size),
    );
  }

  stop() {
    super.stop();
    this.times = [];
    URL.revokeObjectURL(this.image.src);
    this.image.removeAttribute('src');
  }

  images(channels) {
    const found = channels.filter(({schemaName}) => schemaName === COMPRESSED);
    return found.sort((a, b) => b.topic.endsWith('/look') - a.topic.endsWith('/look') || (a.topic < b.topic ? -1 : 1));
  }

  pick(channels) {
    const found = this.images(channels);
    return found.find(({topic}) => topic === this.topic) ?? found[0];
  }

  list() {
    const names = this.images([...this.connection.channels.values()]).map(({topic}) => topic);
    if (names.join() === [...this.topics.options].map(({value}) => value).join()) return;
    this.topics.replaceChildren(...names.map((topic) => element('option', {value: topic}, topic.replace(/\/look$/, ''))));
    if (names.includes(this.topic)) this.topics.value = this.topic;
    this.say(names.length > 0 || !this.connection.isOpen ? '' : 'The robot has no image.');
  }

  choose(topic) {
    this.topic = topic;
    this.stop();
    this.start();
  }

  take(message, topic, size) {
    const type = /png/i.test(message.format) ? 'image/png' : 'image/jpeg';
    const old = this.image.src;
    this.image.src = URL.createObjectURL(new Blob([message.data], {type}));
    if (old) URL.revokeObjectURL(old);
    this.image.alt = `The image of ${topic}`;
    ++this.frames;
    const now = performance.now();
    this.times = [...this.times.filter((time) => time > now - 2000), now];
    this.bytes = size;
  }

  describe() {
    const {times} = this;
    const rate = times.length > 1 ? ((times.length - 1) / (times.at(-1) - times[0])) * 1000 : 0;
    this.width = this.image.naturalWidth;
    setText(this.facts, `${this.width} x ${this.image.naturalHeight}, ${rate.toFixed(1)} images/s, ${(this.bytes / 1024).toFixed(0)} KB each`);
  }

  report() {
    return {...super.report(), frames: this.frames, width: this.width};
  }
}
