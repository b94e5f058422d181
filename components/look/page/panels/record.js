// SPDX-License-Identifier: Apache-2.0
import {Rows, button, element, labelled, select, setText} from '../dom.js';
import {Panel} from '../panel.js';
import {ofType} from '../scene.js';
import {parametersOf} from '../values.js';

const PLUGIN = 'nacelle::record::RecordComponent';

/** Starts and ends recordings, and shows those that run. */
export class RecordPanel extends Panel {
  constructor(robot) {
    super(robot, 'record', 'Record');
    this.topics = element('input', {placeholder: 'all', autocomplete: 'off', spellcheck: 'false'});
    this.folder = element('input', {placeholder: 'rosbag2_ and the time', autocomplete: 'off', spellcheck: 'false'});
    this.compression = select([
      ['zstd', 'zstd'],
      ['lz4', 'lz4'],
      ['none', 'none'],
    ]);
    this.begin = element('button', {type: 'submit', class: 'record'}, '● record');
    const form = element(
      'form',
      {class: 'row'},
      labelled('topics', this.topics),
      labelled('folder', this.folder),
      labelled('compression', this.compression),
      this.begin,
    );
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.record();
    });
    this.running = element('div', {class: 'cards'});
    this.rows = new Rows(
      this.running,
      (component) => this.makeCard(component),
      (card, component) => this.fillCard(card, component),
    );
    this.body.append(form, this.running);
    this.guard(this.begin);
    this.figures = new Map();
    this.components = [];
  }

  start() {
    this.poll('get_components', {}, 1000, ({components}) => {
      this.components = components.filter(({plugin}) => plugin === PLUGIN);
      this.draw();
    });
    this.subscribe(
      (channels) => ofType(channels, 'diagnostic_msgs/msg/DiagnosticArray', ['/diagnostics'])[0],
      ({status}) => {
        for (const one of status) if (/: recording$/.test(one.name)) this.figures.set(one.name.replace(/: recording$/, ''), one);
        this.draw();
      },
    );
  }

  draw() {
    this.rows.show(this.components, ({id}) => id);
    setText(this.note, this.components.length > 0 ? '' : 'Nothing is being recorded.');
  }

  record() {
    const names = this.topics.value.split(/[\s,]+/).filter(Boolean);
    const parameters = {'storage.uri': this.folder.value.trim(), 'storage.compression': this.compression.value};
    if (names.length > 0) parameters['record.topics'] = names;
    else parameters['record.all_topics'] = true;
    return this.robot.order('Record', 'load_component', {component: PLUGIN, parameters: parametersOf(parameters)});
  }

  makeCard({node}) {
    const card = element('div', {class: 'card'}, element('strong', {}, node), element('span', {class: 'facts'}));
    card.end = button('■ stop', () => this.robot.order('End the recording', 'unload_component', {component: node}));
    card.append(card.end);
    return card;
  }

  fillCard(card, {node, state}) {
    const status = this.figures.get(node.split('/').at(-1));
    const words = status ? [status.message, ...status.values.map(({key, value}) => `${key} ${value}`)] : [state.label];
    setText(card.children[1], words.join(', '));
    card.end.disabled = !this.robot.mayOperate;
    card.end.title = this.robot.whyNot;
  }

  report() {
    return {...super.report(), recordings: this.components.length};
  }
}
