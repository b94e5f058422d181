// SPDX-License-Identifier: Apache-2.0
import {Rows, element, setText, table} from '../dom.js';
import {Panel} from '../panel.js';
import {ofType} from '../scene.js';

const LEVELS = ['ok', 'warning', 'error', 'stale'];
const MARKS = ['good', 'warn', 'bad', 'bad'];

/** Faulted components and what is done about them, the history, and /diagnostics. */
export class FaultsPanel extends Panel {
  constructor(robot) {
    super(robot, 'faults', 'Faults');
    this.summary = element('p', {class: 'facts'});
    this.list = element('ul', {class: 'faults'});
    const {table: diagnostics, body} = table('Diagnostics', ['Diagnostics', 'Level', 'Message']);
    this.statuses = new Map();
    this.rows = new Rows(
      body,
      () => {
        const row = element('tr', {}, element('td'), element('td', {}, element('span', {class: 'badge'})), element('td'));
        return row;
      },
      (row, status) => this.fillRow(row, status),
    );
    this.body.append(this.summary, this.list, diagnostics);
  }

  start() {
    this.poll('get_faults', {}, 1000, (answer) => this.showFaults(answer));
    this.subscribe(
      (channels) => ofType(channels, 'diagnostic_msgs/msg/DiagnosticArray', ['/diagnostics'])[0],
      ({status}) => {
        for (const one of status) this.statuses.set(one.name, one);
        this.rows.show(
          [...this.statuses.values()].sort((a, b) => b.level - a.level || (a.name < b.name ? -1 : 1)),
          ({name}) => name,
        );
      },
    );
  }

  stop() {
    super.stop();
    this.statuses.clear();
  }

  fillRow(row, {name, level, message, values}) {
    const [nameCell, levelCell, messageCell] = row.children;
    setText(nameCell, name);
    setText(levelCell.firstChild, LEVELS[level] ?? String(level));
    levelCell.firstChild.className = `badge ${MARKS[level] ?? 'bad'}`;
    setText(messageCell, message);
    row.title = values.map(({key, value}) => `${key}: ${value}`).join('\n');
  }

  showFaults({container_fault: own, components, history, robot_stopped_by: stoppedBy, last_crash: crash, left_out: leftOut}) {
    const lines = [];
    for (const {code, text} of own) lines.push(['bad', `container: ${code}: ${text}`]);
    if (stoppedBy) lines.push(['bad', `The robot was stopped by ${stoppedBy}.`]);
    for (const {node, state, fault, open_faults: open, policy, restarts, max_restarts: most, next_restart_s: next} of components) {
      for (const {code, text} of [...fault, ...open]) lines.push(['bad', `${node} (${state || 'no lifecycle'}): ${code}: ${text}`]);
      const due = next.length > 0 ? `, the next in ${next[0].toFixed(1)} s` : '';
      lines.push(['dull', `${node}: policy ${policy}, ${restarts} of ${most} restarts${due}`]);
    }
    for (const {node, why} of leftOut) lines.push(['warn', `${node} was not loaded: ${why}`]);
    if (crash) lines.push(['warn', `last crash: ${crash}`]);
    for (const {node, code, text, time_ns: time, lasted_s: lasted} of [...history].reverse().slice(0, 30)) {
      const when = new Date(Number(time / 1000000n)).toLocaleTimeString('en-GB');
      lines.push(['dull', `${when} ${node}: ${code}: ${text}${lasted.length > 0 ? ` (over after ${lasted[0].toFixed(1)} s)` : ''}`]);
    }
    const bad = lines.filter(([mark]) => mark === 'bad').length;
    setText(this.summary, bad > 0 ? `${bad} faults now` : 'No component has a fault.');
    this.summary.className = `facts ${bad > 0 ? 'bad' : ''}`;
    const key = JSON.stringify(lines);
    if (key !== this.drawn) this.list.replaceChildren(...lines.map(([mark, text]) => element('li', {class: mark}, text)));
    this.drawn = key;
  }

  report() {
    const shown = super.report();
    return {...shown, live: shown.live && this.statuses.size > 0, diagnostics: this.statuses.size};
  }
}
