// SPDX-License-Identifier: Apache-2.0
import {Rows, element, setText, table} from '../dom.js';
import {Panel} from '../panel.js';
import {streamRows} from '../statistics.js';

/** Each stream: rate, age, drops, and which reader is late. */
export class StreamsPanel extends Panel {
  constructor(robot) {
    super(robot, 'streams', 'Streams');
    this.filter = element('input', {type: 'search', placeholder: 'filter', 'aria-label': 'Filter of topics', oninput: () => this.draw()});
    this.idle = element('input', {type: 'checkbox', onchange: () => this.draw()});
    this.tools.append(this.filter, element('label', {class: 'check'}, element('span', {}, 'unused'), this.idle));
    const {table: list, body} = table('Streams', ['Topic', 'Hz', 'Age', 'Drops', 'p99', 'Late']);
    list.classList.add('numbers');
    this.rows = new Rows(
      body,
      () => this.makeRow(),
      (row, stream) => this.fillRow(row, stream),
    );
    this.body.append(list);
    this.streams = [];
  }

  start() {
    this.before = null;
    this.poll('get_statistics', {}, 1000, (answer) => {
      if (this.before && answer.now_ns === this.before.now_ns) return;
      this.streams = streamRows(this.before, answer);
      this.before = answer;
      this.draw();
    });
  }

  draw() {
    const word = this.filter.value.trim().toLowerCase();
    const shown = this.streams.filter(
      ({name, type, published}) => (published > 0 || this.idle.checked) && `${name} ${type}`.toLowerCase().includes(word),
    );
    this.rows.show(
      shown.sort((a, b) => (a.key < b.key ? -1 : 1)),
      ({key}) => key,
    );
  }

  makeRow() {
    const row = element('tr');
    row.cells6 = Array.from({length: 6}, (_, i) => row.appendChild(element(i === 0 ? 'th' : 'td', i === 0 ? {scope: 'row'} : {})));
    return row;
  }

  fillRow(row, {name, type, rate, age, dropped, causes, p99, late}) {
    const seconds = (value) => (value < 10 ? `${value.toFixed(2)} s` : `${value.toFixed(0)} s`);
    const texts = [
      name,
      Number.isNaN(rate) ? '' : rate.toFixed(1),
      Number.isNaN(age) ? '' : seconds(age),
      dropped || '',
      p99 > 0 ? `${p99.toFixed(2)} ms` : '',
      late,
    ];
    texts.forEach((text, i) => setText(row.cells6[i], String(text)));
    row.cells6[0].title = type;
    row.cells6[3].title = causes;
    row.cells6[5].className = late ? 'bad' : '';
  }

  report() {
    const shown = super.report();
    return {...shown, live: shown.live && this.streams.some(({rate}) => rate > 0), streams: this.streams.length};
  }
}
