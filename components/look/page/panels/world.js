// SPDX-License-Identifier: Apache-2.0
import {button, canvasOf, colours, element, labelled, setText} from '../dom.js';
import {yawOf} from '../geometry.js';
import {Panel} from '../panel.js';
import {Scene} from '../scene.js';
import {View2d} from '../view2d.js';
import {View3d} from '../view3d.js';

/** The robot in its world, from above or in perspective. */
export class WorldPanel extends Panel {
  constructor(robot) {
    super(robot, 'world', 'World');
    this.scene = new Scene(robot.connection);
    this.views = {'2D': new View2d(), '3D': new View3d()};
    this.which = '2D';
    this.options = {follow: true, names: false};
    this.canvas = element('canvas', {
      tabindex: 0,
      role: 'img',
      'aria-label': 'The robot in its world. Drag to move, pinch or use the wheel to zoom.',
    });
    this.legend = element('div', {class: 'legend'});
    this.body.append(this.canvas, this.legend);
    this.switches = Object.keys(this.views).map((name) => button(name, () => this.choose(name), {'aria-pressed': String(name === this.which)}));
    const check = (word, text) => {
      const input = element('input', {
        type: 'checkbox',
        checked: this.options[word],
        onchange: () => {
          this.options[word] = input.checked;
          this.dirty = true;
        },
      });
      this[`${word}Input`] = input;
      return labelled(text, input, {class: 'check'});
    };
    this.tools.append(
      ...this.switches,
      check('follow', 'follow'),
      check('names', 'frames'),
      button('clear path', () => this.scene.clearPaths()),
    );
    this.pointers = new Map();
    this.listen();
  }

  get view() {
    return this.views[this.which];
  }

  choose(name) {
    this.which = name;
    for (const one of this.switches) one.setAttribute('aria-pressed', String(one.textContent === name));
    this.dirty = true;
  }

  start() {
    this.scene.start();
    this.ends.push(() => this.scene.stop());
    this.colour = colours();
    const dark = window.matchMedia('(prefers-color-scheme: dark)');
    const recolour = () => {
      this.colour = colours();
      this.dirty = true;
    };
    dark.addEventListener('change', recolour);
    this.ends.push(() => dark.removeEventListener('change', recolour));
    this.dirty = true;
    this.drawn = -1;
    this.frames(() => this.draw());
    this.every(500, () => this.describe());
  }

  draw() {
    const {clientWidth, clientHeight} = this.canvas;
    if (clientWidth === 0 || (this.drawn === this.scene.version && !this.dirty && clientWidth === this.width && clientHeight === this.height)) return;
    if (this.drawn !== this.scene.version) this.touch();
    this.drawn = this.scene.version;
    this.dirty = false;
    [this.width, this.height] = [clientWidth, clientHeight];
    const {context, width, height} = canvasOf(this.canvas);
    this.view.draw(context, width, height, this.scene, this.colour, this.options);
  }

  describe() {
    const rows = [...this.scene.paths].map(([topic, path]) => {
      const {p, q} = path.pose;
      const text = `${topic}  x ${p[0].toFixed(2)}  y ${p[1].toFixed(2)} m  ${((yawOf(q) * 180) / Math.PI).toFixed(0)}°`;
      return {colour: path.colour, text};
    });
    while (this.legend.children.length > rows.length) this.legend.lastChild.remove();
    rows.forEach(({colour, text}, i) => {
      const row = this.legend.children[i] ?? this.legend.appendChild(element('div', {}, element('span', {class: 'swatch'}), element('span')));
      row.firstChild.style.background = `var(${colour})`;
      setText(row.lastChild, text);
    });
  }

  listen() {
    const {canvas} = this;
    canvas.addEventListener(
      'wheel',
      (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-event.deltaY * 0.0015));
      },
      {passive: false},
    );
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
    });
    canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener('keydown', (event) => {
      const step = {ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40]}[event.key];
      if (step) this.drag(...step);
      else if (event.key === '+' || event.key === '=') this.zoom(1.2);
      else if (event.key === '-') this.zoom(1 / 1.2);
      else return;
      event.preventDefault();
    });
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    if (this.pointers.size === 2) {
      const other = [...this.pointers.values()].find(({pointerId}) => pointerId !== event.pointerId);
      const far = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY) || 1;
      this.zoom(far(event) / far(before));
    } else {
      this.drag(event.clientX - before.clientX, event.clientY - before.clientY);
    }
    this.pointers.set(event.pointerId, event);
  }

  drag(dx, dy) {
    if (this.which === '2D' && this.options.follow) {
      this.options.follow = false; // else the robot would go back to the middle
      this.followInput.checked = false;
    }
    this.view.drag(dx, dy);
    this.dirty = true;
  }

  zoom(factor) {
    this.view.zoom(factor);
    this.dirty = true;
  }

  report() {
    const {counts, base, fixed} = this.scene;
    const first = [...this.scene.paths.values()][0];
    const isWhole = counts.tf > 0 && counts.scan > 0 && counts.odometry > 0 && counts.description > 0;
    const shown = super.report();
    return {
      ...shown,
      live: shown.live && isWhole,
      counts: {...counts},
      frames: this.scene.tf.size,
      paths: [...this.scene.paths.keys()],
      base,
      fixed,
      position: first ? first.pose.p : null,
      speed: first ? first.twist.linear.x : null,
      hasOutline: Boolean(this.scene.outline()),
    };
  }
}
