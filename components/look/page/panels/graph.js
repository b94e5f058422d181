// SPDX-License-Identifier: Apache-2.0
import {layersOf} from '../layers.js';
import {Panel} from '../panel.js';

const SVG = 'http://www.w3.org/2000/svg';
const WIDTH = 150,
  HEIGHT = 34,
  GAP_X = 70,
  GAP_Y = 16;
const EVERYBODYS = /(^|\/)(rosout|parameter_events|diagnostics|clock|tf|tf_static|emergency_stop|_[^/]*)$|\/transition_event$/;

function svg(tag, attributes, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  if (text !== undefined) made.textContent = text;
  return made;
}

/** The nodes as boxes in the colour of their state, and the topics between them. */
export class GraphPanel extends Panel {
  constructor(robot) {
    super(robot, 'graph', 'Graph');
    this.picture = svg('svg', {role: 'img', 'aria-label': 'The graph of components and topics'});
    this.body.append(this.picture);
    this.states = new Map();
    this.counts = {nodes: 0, edges: 0};
  }

  start() {
    this.ends.push(this.connection.watchGraph());
    this.on(this.connection, 'graph', () => this.soon());
    this.poll('get_components', {}, 1000, ({components}) => {
      this.states = new Map(
        components.map(({node, managed, state, fault, open_faults: open}) => [
          node,
          fault.length + open.length > 0 ? 'bad' : !managed || state.label === 'active' ? 'good' : 'dull',
        ]),
      );
      this.soon();
    });
  }

  /** Several updates come at once. */
  soon() {
    if (this.due) return;
    this.due = requestAnimationFrame(() => {
      this.due = 0;
      if (this.isShown) this.draw();
    });
  }

  draw() {
    const {published, subscribed} = this.connection.graph;
    const names = new Set(this.states.keys());
    const edges = new Map();
    for (const [topic, writers] of published) {
      if (EVERYBODYS.test(topic)) continue;
      for (const from of writers) {
        for (const to of subscribed.get(topic) ?? []) {
          if (from === to) continue;
          names.add(from).add(to);
          const key = `${from} ${to}`;
          if (!edges.has(key)) edges.set(key, {from, to, topics: []});
          edges.get(key).topics.push(topic);
        }
      }
    }
    const key = JSON.stringify([[...names].sort(), [...edges.values()], [...this.states]]);
    if (key === this.drawn) return;
    this.drawn = key;
    this.counts = {nodes: names.size, edges: edges.size};
    this.paint([...names].sort(), [...edges.values()]);
  }

  paint(names, edges) {
    const layers = layersOf(names, edges);
    const at = new Map();
    layers.forEach((layer, column) => layer.forEach((name, row) => at.set(name, [10 + column * (WIDTH + GAP_X), 10 + row * (HEIGHT + GAP_Y)])));
    const width = 20 + layers.length * (WIDTH + GAP_X) - GAP_X;
    const height = 20 + Math.max(1, ...layers.map((layer) => layer.length)) * (HEIGHT + GAP_Y) - GAP_Y;
    this.picture.replaceChildren();
    this.picture.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.picture.style.minWidth = `${Math.min(width, 560)}px`;
    for (const {from, to, topics} of edges) {
      const [x1, y1] = [at.get(from)[0] + WIDTH, at.get(from)[1] + HEIGHT / 2];
      const [x2, y2] = [at.get(to)[0], at.get(to)[1] + HEIGHT / 2];
      const bend = Math.max(40, Math.abs(x2 - x1) / 2);
      const line = svg('path', {class: 'edge', d: `M ${x1} ${y1} C ${x1 + bend} ${y1}, ${x2 - bend} ${y2}, ${x2} ${y2}`});
      line.append(svg('title', {}, `${from} to ${to}: ${topics.join(', ')}`));
      this.picture.append(line);
    }
    for (const name of names) {
      const [x, y] = at.get(name);
      const box = svg('g', {class: `node ${this.states.get(name) ?? 'other'}`});
      box.append(
        svg('title', {}, name),
        svg('rect', {x, y, width: WIDTH, height: HEIGHT, rx: 6}),
        svg('text', {x: x + WIDTH / 2, y: y + HEIGHT / 2 + 4, 'text-anchor': 'middle'}, name.length > 22 ? `…${name.slice(-21)}` : name),
      );
      this.picture.append(box);
    }
  }

  report() {
    const shown = super.report();
    return {...shown, live: shown.live && this.counts.edges > 0, ...this.counts};
  }
}
