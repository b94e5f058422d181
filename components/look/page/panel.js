// SPDX-License-Identifier: Apache-2.0
import {element, setText} from './dom.js';

const STALE_MS = 5000;

/** A part of the page. While it is hidden it has no subscription and asks nothing. */
export class Panel {
  /** `name` is a word for the address of the panel, `title` what the user reads. */
  constructor(robot, name, title) {
    Object.assign(this, {robot, name, title, connection: robot.connection});
    this.ends = [];
    this.isShown = false;
    this.lastData = -Infinity;
    this.note = element('p', {class: 'note', role: 'status'});
    this.tools = element('div', {class: 'tools'});
    this.body = element('div', {class: 'body'});
    this.root = element(
      'section',
      {class: `panel panel-${name}`, id: `panel-${name}`, 'aria-label': title, hidden: true},
      element('header', {}, element('h2', {}, title), this.tools),
      this.note,
      this.body,
    );
  }

  show() {
    if (this.isShown) return;
    this.isShown = true;
    this.root.hidden = false;
    this.start();
  }

  hide() {
    if (!this.isShown) return;
    this.isShown = false;
    this.root.hidden = true;
    this.stop();
  }

  /** Subclasses subscribe here, with the functions below. */
  start() {}

  stop() {
    for (const end of this.ends.splice(0)) end();
    this.lastData = -Infinity;
  }

  subscribe(pick, callback) {
    this.ends.push(
      this.connection.subscribe(pick, (...words) => {
        this.touch();
        callback(...words);
      }),
    );
  }

  poll(name, request, periodMs, callback) {
    this.ends.push(
      this.robot.poll(name, request, periodMs, (answer, problem) => {
        if (problem) return this.say(problem.message);
        this.touch();
        callback(answer);
      }),
    );
  }

  every(periodMs, callback) {
    const timer = setInterval(callback, periodMs);
    this.ends.push(() => clearInterval(timer));
    callback();
  }

  /** Calls `draw` before the next picture of the screen, as often as there is one. */
  frames(draw) {
    let id = 0;
    const next = () => {
      draw();
      id = requestAnimationFrame(next);
    };
    next();
    this.ends.push(() => cancelAnimationFrame(id));
  }

  on(emitter, name, listener) {
    this.ends.push(emitter.on(name, listener));
  }

  touch() {
    this.lastData = performance.now();
    setText(this.note, '');
  }
  say(text) {
    setText(this.note, text);
  }

  /** Disables controls that need the right to operate, and says why. */
  guard(...controls) {
    const apply = () => {
      for (const control of controls) {
        control.disabled = !this.robot.mayOperate;
        control.title = this.robot.whyNot;
      }
    };
    apply();
    this.robot.on('right', apply);
  }

  /** For tests: whether what it shows is of now. */
  report() {
    return {shown: this.isShown, live: this.isShown && performance.now() - this.lastData < STALE_MS};
  }
}
