// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import {decode, encode} from '../../../components/look/page/cdr.js';
import {parseSchema} from '../../../components/look/page/ros2msg.js';
import {ROOT, schemaOf} from './schemas.mjs';

const {vectors} = JSON.parse(fs.readFileSync(path.join(ROOT, 'test/data/vectors/cdr_vectors_core.json'), 'utf8'));
const bytesOf = (hex) => Uint8Array.from(Buffer.from(hex, 'hex'));

/** Brings decoded values and those of the file into one form: some float32 are written in short there, and JSON.parse keeps 53 bits of an integer.
 * The bytes of the encoded message are compared exactly. */
function plain(value) {
  if (typeof value === 'bigint') return Math.fround(Number(value));
  if (typeof value === 'number') return Number.isFinite(value) ? Math.fround(value) : String(value);
  if (Array.isArray(value) || ArrayBuffer.isView(value)) return Array.from(value, plain);
  if (value !== null && typeof value === 'object') return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, plain(v)]));
  return value;
}

test('there are vectors', () => assert.ok(vectors.length >= 188));

for (const vector of vectors) {
  test(`decodes and encodes ${vector.type}, ${vector.sample}`, () => {
    const schema = schemaOf(vector.type);
    const bytes = bytesOf(vector.cdr_hex);

    const value = decode(schema, bytes);

    assert.deepEqual(plain(value), plain(vector.values));
    const again = encode(schema, value);
    assert.equal(Buffer.from(again).toString('hex'), vector.cdr_hex);
  });
}

test('a message that is cut anywhere is refused', () => {
  const {type, cdr_hex: hex} = vectors.find((v) => v.type === 'nav_msgs/msg/Odometry');
  const bytes = bytesOf(hex);
  const schema = schemaOf(type);
  for (let length = 0; length < bytes.length; ++length) assert.throws(() => decode(schema, bytes.subarray(0, length)), `${length}`);
});

test('a length that is not true is refused before memory is taken', () => {
  const schema = parseSchema('a/msg/B', 'string[] names\n');
  assert.throws(() => decode(schema, bytesOf('00010000ffffffff')), RangeError);
});

test('defaults, bounds and missing fields', () => {
  const schema = parseSchema('a/msg/B', 'int32 x 7\nstring s "a # b"\nint8[2] pair [1, 2]\nint16[<=2] few\nstring<=3 short\nbool on true\n');

  const value = plain(decode(schema, encode(schema, {})));

  assert.deepEqual(value, {x: 7, s: 'a # b', pair: [1, 2], few: [], short: '', on: true});
  assert.throws(() => encode(schema, {few: [1, 2, 3]}), /more than 2/);
  assert.throws(() => encode(schema, {short: 'long'}), /longer than 3/);
  assert.throws(() => encode(schema, {x: 'word'}), /no number/);
  assert.throws(() => encode(schema, {pair: [1, 2, 3]}), /array of 2/);
});

test('reads big-endian', () => {
  const schema = parseSchema('a/msg/B', 'uint16 a\nuint32[] b\n');
  assert.deepEqual(plain(decode(schema, bytesOf('000000000102000000000002000000010000ffff'))), {a: 258, b: [1, 65535]});
});
