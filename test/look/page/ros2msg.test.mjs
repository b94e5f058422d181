// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {parseSchema, shortName} from '../../../components/look/page/ros2msg.js';

const LINE = '='.repeat(80);

test('names are shortened', () => {
  assert.equal(shortName('std_msgs/msg/Header'), 'std_msgs/Header');
  assert.equal(shortName('a/srv/B_Request'), 'a/B_Request');
  assert.equal(shortName('Header', 'std_msgs'), 'std_msgs/Header');
});

test('fields, constants and comments', () => {
  const schema = parseSchema(
    'a/msg/B',
    [
      '# about',
      'byte OFF=0  # none',
      'string NAME = "x y"',
      'C[] cs',
      'float64[3] v',
      'uint8[<=4] few',
      LINE,
      'MSG: a/msg/C',
      'int64 big 9007199254740993',
    ].join('\n'),
  );
  const {fields, constants} = schema.types.get('a/B');
  assert.deepEqual(constants, {OFF: 0, NAME: 'x y'});
  assert.deepEqual(fields, [
    {name: 'cs', type: 'a/C', array: 'sequence'},
    {name: 'v', type: 'float64', array: 'fixed', length: 3},
    {name: 'few', type: 'uint8', array: 'sequence', bound: 4},
  ]);
  assert.equal(schema.types.get('a/C').fields[0].default, 9007199254740993n);
});

test('what is no schema is refused', () => {
  assert.throws(() => parseSchema('a/msg/B', 'C c'), /a\/C, which is not defined/);
  assert.throws(() => parseSchema('a/msg/B', 'int32'), /neither a field nor a constant/);
  assert.throws(() => parseSchema('a/msg/B', `int32 x\n${LINE}\nint32 y`), /MSG: pkg\/Type/);
  assert.throws(() => parseSchema('a/msg/B', 'int32 x word'), /no int32/);
});
