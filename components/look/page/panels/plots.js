// SPDX-License-Identifier: Apache-2.0
import {button, canvasOf, colours, element, setText} from '../dom.js';
import {Panel} from '../panel.js';
import {Series, drawPlot, fieldTree, valueAt} from '../plot.js';

const SECONDS = 30;
const LINES = ['--line-1', '--line-2', '--line-3', '--line-4', '--line-5', '--line-6'];
const NAMES_TEXT = 'text/plain';

/** Numbers over time: fields are dragged from the tree to the plot, or tapped. */
export class PlotsPanel extends Panel {
  constructor(robot) {
    super(robot, 'plots', 'Plots');
    this.lines = []; // {topic, path, series, colour, last}
    this.isHeld = false;
    this.canvas = element('canvas', {role: 'img', 'aria-label': 'Plot of the chosen fields. The values are in the list below it.'});
    this.legend = element('ul', {class: 'plot-legend'});
    this.tree = element('div', {class: 'tree', 'aria-label': 'Fields'});
    this.filter = element('input', {type: 'search', placeholder: 'topic', 'aria-label': 'Filter of topics', oninput: () => this.listTopics()});
    this.hold = button(
      'hold',
      () => {
        this.isHeld = !this.isHeld;
        this.hold.setAttribute('aria-pressed', String(this.isHeld));
      },
      {'aria-pressed': 'false'},
    );
    this.tools.append(
      this.hold,
      button('clear', () => this.lines.slice().forEach((line) => this.remove(line))),
    );
    const drop = element('div', {class: 'plot-area'}, this.canvas, this.legend);
    drop.addEventListener('dragover', (event) => event.preventDefault());
    drop.addEventListener('drop', (event) => {
      event.preventDefault();
      const [topic, path] = event.dataTransfer.getData(NAMES_TEXT).split(' ');
      if (topic && path) this.add(topic, path);
    });
    this.body.append(element('div', {class: 'plot-fields'}, this.filter, this.tree), drop);
    this.topics = new Map();
    this.time = 0;
  }

  start() {
    this.colour = colours();
    this.on(this.connection, 'channels', () => this.listTopics());
    this.listTopics();
    for (const line of this.lines) this.follow(line);
    this.frames(() => this.draw());
    if (this.lines.length === 0) this.addFirst();
    this.on(this.connection, 'channels', () => {
      if (this.lines.length === 0) this.addFirst();
    });
  }

  stop() {
    for (const line of this.lines) line.end?.();
    super.stop();
  }

  /** The plot is not empty at first: the speed of the odometry. */
  addFirst() {
    const channel = [...this.connection.channels.values()]
      .filter(({schemaName}) => schemaName === 'nav_msgs/msg/Odometry')
      .sort((a, b) => (a.topic < b.topic ? -1 : 1))[0];
    if (!channel) return;
    this.add(channel.topic, 'twist.twist.linear.x');
    this.add(channel.topic, 'twist.twist.angular.z');
  }

  listTopics() {
    const word = this.filter.value.trim().toLowerCase();
    const names = [...new Set([...this.connection.channels.values()].map(({topic}) => topic))]
      .sort()
      .filter((topic) => topic.toLowerCase().includes(word));
    if (names.join() === this.listed) return;
    this.listed = names.join();
    this.tree.replaceChildren(
      ...names.map((topic) => {
        const details = element('details', {}, element('summary', {}, topic));
        details.addEventListener('toggle', () => {
          if (!details.open || details.children.length > 1) return;
          const channel = [...this.connection.channels.values()].find((one) => one.topic === topic);
          if (channel) details.append(this.branch(topic, fieldTree(this.connection.schemaOf(channel))));
        });
        return details;
      }),
    );
  }

  branch(topic, nodes) {
    const list = element('ul');
    for (const {name, path, isNumber, children} of nodes) {
      if (isNumber) {
        const leaf = button(name, () => this.add(topic, path), {draggable: 'true', title: `Plot ${topic} ${path}`, class: 'field'});
        leaf.addEventListener('dragstart', (event) => event.dataTransfer.setData(NAMES_TEXT, `${topic} ${path}`));
        list.append(element('li', {}, leaf));
      } else {
        const details = element('details', {}, element('summary', {}, name));
        details.addEventListener('toggle', () => {
          if (details.open && details.children.length === 1) details.append(this.branch(topic, children));
        });
        list.append(element('li', {}, details));
      }
    }
    return list;
  }

  add(topic, path) {
    if (this.lines.some((line) => line.topic === topic && line.path === path)) return;
    const free = LINES.find((colour) => this.lines.every((line) => line.colour !== colour)) ?? LINES[0];
    const line = {topic, path, series: new Series(SECONDS), colour: free, last: NaN};
    line.value = element('output');
    const swatch = element('span', {class: 'swatch'});
    swatch.style.background = `var(${free})`;
    line.row = element(
      'li',
      {},
      swatch,
      element('span', {}, `${topic} ${path}`),
      line.value,
      button('×', () => this.remove(line), {'aria-label': `Remove ${topic} ${path}`, class: 'small'}),
    );
    this.lines.push(line);
    this.legend.append(line.row);
    if (this.isShown) this.follow(line);
  }

  follow(line) {
    line.end = this.connection.subscribe(line.topic, (message, topic, time) => {
      this.touch();
      line.last = valueAt(message, line.path);
      this.time = Number(time) * 1e-9;
      line.series.add(this.time, line.last);
    });
  }

  remove(line) {
    line.end?.();
    line.row.remove();
    this.lines.splice(this.lines.indexOf(line), 1);
  }

  draw() {
    if (this.isHeld || this.canvas.clientWidth === 0 || performance.now() - (this.drawnAt ?? 0) < 66) return;
    this.drawnAt = performance.now();
    const {context, width, height} = canvasOf(this.canvas);
    drawPlot(context, width, height, this.lines, this.time, SECONDS, this.colour);
    for (const {value, last} of this.lines) setText(value, Number.isNaN(last) ? 'none' : String(Number(last.toPrecision(5))));
  }

  report() {
    return {...super.report(), lines: this.lines.map(({topic, path, series}) => ({topic, path, points: series.times.length}))};
  }
}
