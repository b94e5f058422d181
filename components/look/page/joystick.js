// SPDX-License-Identifier: Apache-2.0
import {element} from './dom.js';

const DEAD_ZONE = 0.08;
const RIM = 64; // percent of the knob, which brings its edge to that of the stick
const KEYS = {ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0], w: [0, 1], s: [0, -1], a: [-1, 0], d: [1, 0]};

/** Returns [x, y] within the unit circle: 0 in the middle, and 1 at the rim. */
export function stickOf(x, y) {
  const length = Math.hypot(x, y);
  if (!(length > DEAD_ZONE)) return [0, 0];
  const pushed = (Math.min(1, length) - DEAD_ZONE) / (1 - DEAD_ZONE);
  return [(x / length) * pushed, (y / length) * pushed];
}

/** A stick that is held with a finger, the mouse, or keys. Whatever ends the hold ends the grip. */
export class Joystick {
  /** `handlers`: grip() returns whether it may, move(x, y) with right and up positive, release(). */
  constructor(handlers) {
    this.handlers = handlers;
    this.isHeld = false;
    this.pointer = null;
    this.keys = new Set();
    this.knob = element('div', {class: 'knob', 'aria-hidden': 'true'});
    this.root = element(
      'div',
      {
        class: 'stick',
        tabindex: 0,
        role: 'application',
        'aria-label': 'Joystick. Hold it to drive; with the keyboard hold the arrow keys. Letting go stops the robot.',
      },
      this.knob,
    );
    const on = (target, names, listener) => names.split(' ').forEach((name) => target.addEventListener(name, listener));
    on(this.root, 'pointerdown', (event) => this.down(event));
    on(this.root, 'pointermove', (event) => this.move(event));
    on(this.root, 'pointerup pointercancel lostpointercapture', (event) => {
      if (event.pointerId === this.pointer) this.letGo();
    });
    on(this.root, 'contextmenu', (event) => event.preventDefault());
    on(this.root, 'keydown', (event) => this.keyDown(event));
    on(window, 'keyup', (event) => this.keyUp(event));
    on(this.root, 'blur', () => this.letGo());
    on(window, 'blur pagehide', () => this.letGo());
    on(document, 'visibilitychange freeze', () => this.letGo());
  }

  grip() {
    this.isHeld = this.handlers.grip();
    this.root.classList.toggle('held', this.isHeld);
    return this.isHeld;
  }

  down(event) {
    if (this.isHeld || event.button > 0) return;
    event.preventDefault();
    this.root.focus({preventScroll: true});
    if (!this.grip()) return;
    this.pointer = event.pointerId;
    try {
      this.root.setPointerCapture(event.pointerId);
    } catch {
      // A synthetic pointer cannot be captured; its events come all the same.
    }
    this.move(event);
  }

  move(event) {
    if (event.pointerId !== this.pointer) return;
    const box = this.root.getBoundingClientRect();
    const radius = box.width / 2;
    this.set((event.clientX - box.left - radius) / radius, (box.top + box.height / 2 - event.clientY) / radius);
  }

  keyDown(event) {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!KEYS[key] || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    if (event.repeat || this.pointer !== null) return;
    if (!this.isHeld && !this.grip()) return;
    this.keys.add(key);
    this.fromKeys();
  }

  keyUp(event) {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!this.keys.delete(key)) return;
    if (this.keys.size === 0) this.letGo();
    else this.fromKeys();
  }

  fromKeys() {
    let x = 0,
      y = 0;
    for (const key of this.keys) {
      x += KEYS[key][0];
      y += KEYS[key][1];
    }
    this.set(x, y);
  }

  set(x, y) {
    const length = Math.max(1, Math.hypot(x, y));
    this.knob.style.transform = `translate(${(RIM * x) / length}%, ${(-RIM * y) / length}%)`;
    this.handlers.move(...stickOf(x, y));
  }

  /** Ends the hold, and the command with it. */
  letGo() {
    if (!this.isHeld) return;
    this.isHeld = false;
    this.pointer = null;
    this.keys.clear();
    this.root.classList.remove('held');
    this.knob.style.transform = '';
    this.handlers.release();
  }
}
