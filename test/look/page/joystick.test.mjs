// SPDX-License-Identifier: Apache-2.0
// The stick with a stand-in for the browser: whatever ends the hold must end the grip, once.
import assert from 'node:assert/strict';
import test from 'node:test';

import {Joystick} from '../../../components/look/page/joystick.js';

class FakeElement extends EventTarget {
  style = {};
  classes = new Set();
  classList = {
    add: (name) => this.classes.add(name),
    remove: (name) => this.classes.delete(name),
    toggle: (name, isOn) => (isOn ? this.classes.add(name) : this.classes.delete(name)),
  };
  setAttribute() {}
  append() {}
  focus() {}
  setPointerCapture() {}
  getBoundingClientRect() {
    return {left: 0, top: 0, width: 200, height: 200};
  }
}

function stick({mayGrip = true} = {}) {
  globalThis.window = new EventTarget();
  globalThis.document = Object.assign(new EventTarget(), {createElement: () => new FakeElement()});
  const calls = [];
  const joystick = new Joystick({
    grip: () => {
      calls.push('grip');
      return mayGrip;
    },
    move: (x, y) => calls.push([Number(x.toFixed(2)), Number(y.toFixed(2))]),
    release: () => calls.push('release'),
  });
  const send = (target, name, values = {}) => target.dispatchEvent(Object.assign(new Event(name, {cancelable: true}), values));
  const pointer = (name, x, y, id = 1) => send(joystick.root, name, {pointerId: id, button: 0, clientX: x, clientY: y});
  const key = (name, word) => send(name === 'keyup' ? window : joystick.root, name, {key: word});
  return {joystick, calls, send, pointer, key, count: (what) => calls.filter((one) => one === what).length};
}

test('a finger holds, moves and lets go', () => {
  const {calls, pointer} = stick();
  pointer('pointerdown', 100, 100);
  pointer('pointermove', 100, 0);
  pointer('pointermove', 300, 100);
  pointer('pointerup', 300, 100);
  pointer('pointermove', 100, 0);
  assert.deepEqual(calls, ['grip', [0, 0], [0, 1], [1, 0], 'release']);
});

for (const [what, end] of [
  ['the finger is lifted', ({pointer}) => pointer('pointerup', 0, 0)],
  ['the browser takes the finger', ({pointer}) => pointer('pointercancel', 0, 0)],
  ['the capture is lost', ({pointer}) => pointer('lostpointercapture', 0, 0)],
  ['the stick loses the focus', ({joystick, send}) => send(joystick.root, 'blur')],
  ['the window loses the focus', ({send}) => send(window, 'blur')],
  ['the page goes', ({send}) => send(window, 'pagehide')],
  ['the page is hidden', ({send}) => send(document, 'visibilitychange')],
  ['the page is frozen', ({send}) => send(document, 'freeze')],
]) {
  test(`the grip ends once when ${what}, of a finger and of a key`, () => {
    for (const begin of ['pointer', 'key']) {
      const all = stick();
      if (begin === 'pointer') all.pointer('pointerdown', 100, 20);
      else all.key('keydown', 'ArrowUp');
      end(all);
      if (begin === 'key' && what.match(/finger|capture/)) {
        assert.equal(all.count('release'), 0);
        continue;
      }
      end(all);
      assert.equal(all.count('release'), 1);
      assert.equal(all.joystick.isHeld, false);
    }
  });
}

test('keys hold until the last one is up', () => {
  const {calls, key} = stick();
  key('keydown', 'ArrowUp');
  key('keydown', 'A');
  key('keyup', 'a');
  key('keyup', 'ArrowUp');
  key('keyup', 'ArrowUp');
  assert.deepEqual(calls, ['grip', [0, 1], [-0.71, 0.71], [0, 1], 'release']);
});

test('a second finger and keys do not take over', () => {
  const {calls, pointer, key, count} = stick();
  pointer('pointerdown', 100, 100, 1);
  pointer('pointerdown', 100, 0, 2);
  pointer('pointermove', 100, 0, 2);
  key('keydown', 'ArrowUp');
  pointer('pointerup', 100, 0, 2);
  assert.equal(count('grip'), 1);
  assert.deepEqual(calls.at(-1), [0, 0]);
  pointer('pointerup', 100, 0, 1);
  assert.equal(count('release'), 1);
});

test('without permission nothing is held', () => {
  const {joystick, calls, pointer, key} = stick({mayGrip: false});
  pointer('pointerdown', 100, 0);
  pointer('pointermove', 100, 0);
  key('keydown', 'ArrowUp');
  assert.deepEqual(calls, ['grip', 'grip']);
  assert.equal(joystick.isHeld, false);
});
