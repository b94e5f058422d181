// SPDX-License-Identifier: Apache-2.0
import {element, setText} from '../dom.js';
import {Panel} from '../panel.js';
import {TYPES, messageOf, parseValue, textOf, valueOf} from '../values.js';

const LIST = '/list_parameters';

/** The parameters of a node, with their ranges and descriptions. */
export class ParametersPanel extends Panel {
  constructor(robot) {
    super(robot, 'parameters', 'Parameters');
    this.node = '';
    this.nodes = element('select', {'aria-label': 'Node', onchange: () => this.choose(this.nodes.value)});
    this.filter = element('input', {type: 'search', placeholder: 'filter', 'aria-label': 'Filter of parameters', oninput: () => this.sift()});
    this.tools.append(this.nodes, this.filter);
    this.list = element('div', {class: 'parameters'});
    this.body.append(this.list);
    this.entries = new Map();
  }

  start() {
    this.on(this.connection, 'services', () => this.listNodes());
    this.on(this.connection, 'parameters', (changed) => {
      if (changed.some(({name}) => name.startsWith(`${this.node}.`))) this.refresh();
    });
    this.on(this.robot, 'right', () => this.entries.forEach((entry) => this.enable(entry)));
    this.listNodes();
    if (this.node) this.choose(this.node);
    this.every(5000, () => this.refresh());
  }

  stop() {
    super.stop();
    this.unwatch?.();
    this.unwatch = null;
  }

  listNodes() {
    const names = [...this.connection.services.keys()]
      .filter((name) => name.endsWith(LIST))
      .map((name) => name.slice(0, -LIST.length))
      .sort();
    if (names.join() !== this.listed) {
      this.listed = names.join();
      this.nodes.replaceChildren(...names.map((name) => element('option', {value: name}, name)));
    }
    if (names.includes(this.node)) this.nodes.value = this.node;
    else if (names.length > 0) this.choose(names.find((name) => name === '/diff_drive') ?? names[0]);
  }

  async choose(node) {
    this.node = node;
    this.nodes.value = node;
    this.unwatch?.();
    this.unwatch = null;
    this.entries.clear();
    this.list.replaceChildren();
    try {
      const {result} = await this.connection.call(`${node}${LIST}`, {});
      const names = [...result.names].sort();
      const {descriptors} = await this.connection.call(`${node}/describe_parameters`, {names});
      if (this.node !== node || !this.isShown) return;
      for (const descriptor of descriptors) this.entries.set(descriptor.name, this.makeEntry(descriptor));
      this.list.replaceChildren(...[...this.entries.values()].map(({row}) => row));
      this.unwatch = this.connection.watchParameters(names.map((name) => `${node}.${name}`));
      this.sift();
      await this.refresh();
    } catch (problem) {
      this.say(problem.message);
    }
  }

  async refresh() {
    const {node} = this;
    const names = [...this.entries.keys()];
    if (names.length === 0) return;
    try {
      const {values} = await this.connection.call(`${node}/get_parameters`, {names});
      if (this.node !== node) return;
      this.touch();
      names.forEach((name, i) => {
        if (values[i]) this.fill(this.entries.get(name), values[i]);
      });
    } catch (problem) {
      this.say(problem.message);
    }
  }

  sift() {
    const word = this.filter.value.trim().toLowerCase();
    for (const [name, {row, descriptor}] of this.entries) row.hidden = !`${name} ${descriptor.description}`.toLowerCase().includes(word);
  }

  makeEntry(descriptor) {
    const {name, type, description} = descriptor;
    const id = `parameter-${name}`;
    const limits = descriptor.floating_point_range[0] ?? descriptor.integer_range[0];
    const entry = {descriptor, type, limits: limits && [Number(limits.from_value), Number(limits.to_value)]};
    entry.input = element(
      'input',
      type === 1
        ? {id, type: 'checkbox'}
        : {id, type: 'text', spellcheck: 'false', autocomplete: 'off', inputmode: type === 2 || type === 3 ? 'decimal' : 'text'},
    );
    entry.input.addEventListener('change', () => this.set(entry, type === 1 ? entry.input.checked : null));
    const isSlid = limits && Number.isFinite(entry.limits[0]) && entry.limits[1] - entry.limits[0] < 1e6;
    if (isSlid) {
      const step = Number(limits.step) || (type === 2 ? 1 : (entry.limits[1] - entry.limits[0]) / 200);
      entry.slider = element('input', {type: 'range', min: entry.limits[0], max: entry.limits[1], step, 'aria-label': `${name}, slider`});
      entry.slider.addEventListener('change', () => {
        entry.input.value = entry.slider.value;
        this.set(entry, null);
      });
    }
    const words = [
      TYPES[type],
      entry.limits ? `${entry.limits[0]} to ${entry.limits[1]}` : '',
      descriptor.read_only ? 'read only' : '',
      descriptor.additional_constraints,
    ];
    entry.state = element('small', {class: 'bad', role: 'status'});
    entry.row = element(
      'div',
      {class: 'parameter'},
      element('label', {for: id, title: description}, name),
      entry.input,
      entry.slider ?? null,
      element('small', {}, `${description} (${words.filter(Boolean).join(', ')})`),
      entry.state,
    );
    this.enable(entry);
    return entry;
  }

  enable({descriptor, input, slider}) {
    for (const one of [input, slider].filter(Boolean)) {
      one.disabled = descriptor.read_only || !this.robot.mayOperate;
      one.title = descriptor.read_only ? 'This parameter is read only: it is set when the component is loaded.' : this.robot.whyNot;
    }
  }

  fill(entry, message) {
    if (message.type !== 0) entry.type = message.type;
    const value = valueOf(message);
    if (document.activeElement === entry.input || document.activeElement === entry.slider) return; // the user is writing
    if (entry.input.type === 'checkbox') entry.input.checked = value === true;
    else entry.input.value = textOf(entry.type, value);
    if (entry.slider && value !== undefined) entry.slider.value = String(value);
  }

  async set(entry, given) {
    const {name} = entry.descriptor;
    setText(entry.state, '');
    try {
      const value = given ?? parseValue(entry.type, entry.input.value);
      if (entry.limits && (Number(value) < entry.limits[0] || Number(value) > entry.limits[1]))
        throw new Error(`it must be from ${entry.limits[0]} to ${entry.limits[1]}`);
      const {results} = await this.connection.call(`${this.node}/set_parameters`, {parameters: [{name, value: messageOf(entry.type, value)}]});
      if (!results[0].successful) throw new Error(results[0].reason || 'the node refuses it');
      entry.input.blur();
      entry.slider?.blur();
      this.robot.emit('words', `${this.node} ${name} is ${textOf(entry.type, value)}`, false);
    } catch (problem) {
      setText(entry.state, problem.message);
      return;
    }
    await this.refresh();
  }

  report() {
    return {...super.report(), node: this.node, parameters: this.entries.size};
  }
}
