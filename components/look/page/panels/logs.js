// SPDX-License-Identifier: Apache-2.0
import {button, element, select, setText} from '../dom.js';
import {Panel} from '../panel.js';
import {ofType} from '../scene.js';

const LEVELS = [
  [10, 'DEBUG'],
  [20, 'INFO'],
  [30, 'WARN'],
  [40, 'ERROR'],
  [50, 'FATAL'],
];
const MOST = 500;

/** Lines of /rosout, with a filter by level and words. */
export class LogsPanel extends Panel {
  constructor(robot) {
    super(robot, 'logs', 'Logs');
    this.lines = [];
    this.level = select(LEVELS, {'aria-label': 'Lowest level', onchange: () => this.draw()});
    this.level.value = '20';
    this.filter = element('input', {type: 'search', placeholder: 'node or words', 'aria-label': 'Filter of lines', oninput: () => this.draw()});
    this.tools.append(
      this.level,
      this.filter,
      button('clear', () => {
        this.lines = [];
        this.draw();
      }),
    );
    this.list = element('ol', {class: 'log', 'aria-live': 'off'});
    this.body.append(this.list);
  }

  start() {
    this.subscribe(
      (channels) => ofType(channels, 'rcl_interfaces/msg/Log', ['/rosout'])[0],
      (message) => this.take(message),
    );
    this.draw();
  }

  take({stamp, level, name, msg}) {
    const line = {level, name, msg, time: new Date(stamp.sec * 1000 + stamp.nanosec / 1e6)};
    this.lines.push(line);
    if (this.lines.length > MOST) this.lines.splice(0, this.lines.length - MOST);
    if (this.isWanted(line)) this.add(line);
    while (this.list.children.length > MOST) this.list.firstChild.remove();
  }

  isWanted({level, name, msg}) {
    const word = this.filter.value.trim().toLowerCase();
    return level >= Number(this.level.value) && `${name} ${msg}`.toLowerCase().includes(word);
  }

  add({level, name, msg, time}) {
    const atEnd = this.body.scrollHeight - this.body.scrollTop - this.body.clientHeight < 30;
    const word = LEVELS.find(([number]) => number >= level)?.[1] ?? String(level);
    this.list.append(
      element(
        'li',
        {class: word.toLowerCase()},
        element('time', {}, time.toLocaleTimeString('en-GB')),
        ' ',
        element('b', {}, word),
        ' ',
        element('span', {class: 'from'}, name),
        ' ',
        msg,
      ),
    );
    if (atEnd) this.body.scrollTop = this.body.scrollHeight;
  }

  draw() {
    this.list.replaceChildren();
    for (const line of this.lines) if (this.isWanted(line)) this.add(line);
    setText(this.note, this.lines.length > 0 ? '' : 'Nothing was logged since the panel was opened.');
    this.body.scrollTop = this.body.scrollHeight;
  }

  /** A robot may have nothing to say: a subscription is enough. */
  report() {
    const isSubscribed = [...this.connection.subscriptions].some(({channel}) => channel?.schemaName === 'rcl_interfaces/msg/Log');
    return {...super.report(), live: this.isShown && isSubscribed, lines: this.lines.length};
  }
}
