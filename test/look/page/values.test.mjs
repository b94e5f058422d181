// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {findEdge, nanosecondsOf, rulesApart, timeOf} from '../../../components/look/page/replay.js';
import {messageOf, parametersOf, parseValue, textOf, valueOf} from '../../../components/look/page/values.js';

test('what is shown can be read back', () => {
  for (const [type, value] of [
    [1, true],
    [2, -9007199254740993n],
    [3, 0.25],
    [3, NaN],
    [3, -Infinity],
    [4, ' a, b '],
    [5, [0, 255]],
    [6, [true, false]],
    [7, [1n, 2n]],
    [8, [0.5, 2]],
    [9, ['a, b', '']],
    [9, []],
  ]) {
    assert.deepEqual(parseValue(type, textOf(type, value)), value);
    assert.deepEqual(valueOf(messageOf(type, value)), value);
  }
});

test('what is no value is refused', () => {
  for (const [type, text] of [
    [1, 'yes'],
    [2, '1.5'],
    [2, ''],
    [3, ''],
    [3, '1 m'],
    [5, '256'],
    [7, '1, x'],
    [9, '["a", 2]'],
    [9, '["a"'],
  ]) {
    assert.throws(() => parseValue(type, text), `${type} ${text}`);
  }
});

test('parameters of a service have the types of their values', () => {
  assert.deepEqual(
    parametersOf({a: true, b: 1n, c: 1, d: 'x', e: ['y']}).map(({value}) => value.type),
    [1, 2, 3, 4, 9],
  );
});

test('both ends of a recording are found to 50 ms', async () => {
  for (const length of [0n, 10_000_000n, 12_781_000_000n, 86_400_000_000_000n]) {
    const start = 1_795_878_885_888_000_000n;
    let calls = 0;
    const seek = async (time) => {
      ++calls;
      return time >= start && time <= start + length;
    };
    const inside = start + length / 3n;
    const end = await findEdge(inside, 1n, seek);
    const begin = await findEdge(inside, -1n, seek);
    assert.ok(end <= start + length && start + length - end <= 50_000_000n, `${length}: ${end - start}`);
    assert.ok(begin >= start && begin - start <= 50_000_000n, `${length}: ${begin - start}`);
    assert.ok(calls < 150);
  }
  assert.equal(nanosecondsOf(timeOf(1_795_878_885_888_123_456n)), 1_795_878_885_888_123_456n);
});

test('topics that exist are kept apart', () => {
  assert.deepEqual(rulesApart(['/odom', '/odom', '/camera/image_raw/look', '/replay/odom', '/rosout'], '/replay'), ['/odom:=/replay/odom']);
});
