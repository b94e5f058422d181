// SPDX-License-Identifier: Apache-2.0
// Reads and writes CDR (XCDR1, little-endian, with its header of 4 bytes) as a schema of ros2msg.js says.
// 64-bit integers are BigInt; sequences of numbers are typed arrays.

const SIZE = {int8: 1, uint8: 1, bool: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4, int64: 8, uint64: 8, float64: 8};
const GET = {
  int8: 'getInt8',
  uint8: 'getUint8',
  int16: 'getInt16',
  uint16: 'getUint16',
  int32: 'getInt32',
  uint32: 'getUint32',
  int64: 'getBigInt64',
  uint64: 'getBigUint64',
  float32: 'getFloat32',
  float64: 'getFloat64',
};
const ARRAYS = {
  int8: Int8Array,
  uint8: Uint8Array,
  int16: Int16Array,
  uint16: Uint16Array,
  int32: Int32Array,
  uint32: Uint32Array,
  int64: BigInt64Array,
  uint64: BigUint64Array,
  float32: Float32Array,
  float64: Float64Array,
};
const HEADER = 4;
const LARGEST = 0x10000000;
const UTF8 = new TextDecoder();
const TO_UTF8 = new TextEncoder();

/** Returns the message in the bytes (Uint8Array). Throws a RangeError if they end too early, and an Error if the encoding is another one. */
export function decode(schema, bytes) {
  return new Reader(schema, bytes).message(schema.name);
}

/** Returns the bytes of the message. What it leaves out has the schema's default. Throws an Error if a value does not fit. */
export function encode(schema, value) {
  const writer = new Writer(schema);
  writer.message(schema.name, value ?? {}, '');
  return writer.bytes();
}

class Reader {
  constructor(schema, bytes) {
    this.types = schema.types;
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    if (bytes.length < HEADER || bytes[0] !== 0 || bytes[1] > 1) throw new Error('the bytes are no plain CDR');
    this.little = bytes[1] === 1;
    this.at = HEADER;
  }

  align(size) {
    const over = (this.at - HEADER) % size;
    if (over !== 0) this.at += size - over;
  }

  message(name) {
    const {fields} = this.types.get(name);
    const result = {};
    if (fields.length === 0) ++this.at; // an empty message is one byte
    for (const field of fields) result[field.name] = this.field(field);
    return result;
  }

  field(field) {
    if (!field.array) return this.value(field.type);
    const count = field.array === 'fixed' ? field.length : this.value('uint32');
    if (ARRAYS[field.type]) return this.numbers(field.type, count);
    // Each element takes a byte at least, so that a wrong length does not make a long array.
    if (count > this.bytes.length - this.at) throw new RangeError(`${field.name} is longer than the message`);
    const result = [];
    for (let i = 0; i < count; ++i) result.push(this.value(field.type));
    return result;
  }

  numbers(type, count) {
    const size = SIZE[type];
    if (count === 0) return new ARRAYS[type](0);
    this.align(size);
    const begin = this.at;
    const end = begin + count * size;
    if (end > this.bytes.length) throw new RangeError('an array is longer than the message');
    this.at = end;
    if (this.little) return new ARRAYS[type](this.bytes.slice(begin, end).buffer);
    const result = new ARRAYS[type](count);
    for (let i = 0; i < count; ++i) result[i] = this.view[GET[type]](begin + i * size, false);
    return result;
  }

  value(type) {
    if (type === 'string' || type === 'wstring') return this.text(type);
    const size = SIZE[type];
    if (!size) return this.message(type);
    this.align(size);
    const at = this.at;
    this.at += size;
    if (type === 'bool') return this.view.getUint8(at) !== 0;
    return this.view[GET[type]](at, this.little);
  }

  text(type) {
    const length = this.value('uint32');
    const size = type === 'string' ? length : 2 * length;
    const begin = this.at;
    if (begin + size > this.bytes.length) throw new RangeError('a string is longer than the message');
    this.at += size;
    if (type === 'string') return UTF8.decode(this.bytes.subarray(begin, begin + Math.max(0, length - 1))); // without its NUL
    let result = '';
    for (let i = 0; i < length; ++i) result += String.fromCharCode(this.view.getUint16(begin + 2 * i, this.little));
    return result;
  }
}

class Writer {
  constructor(schema) {
    this.types = schema.types;
    this.buffer = new Uint8Array(256);
    this.view = new DataView(this.buffer.buffer);
    this.buffer[1] = 1;
    this.at = HEADER;
  }

  bytes() {
    return this.buffer.slice(0, this.at);
  }

  room(size) {
    if (this.at + size <= this.buffer.length) return;
    const wanted = Math.max(2 * this.buffer.length, this.at + size);
    if (wanted > LARGEST) throw new Error('the message is too long');
    const larger = new Uint8Array(wanted);
    larger.set(this.buffer);
    this.buffer = larger;
    this.view = new DataView(larger.buffer);
  }

  align(size) {
    const over = (this.at - HEADER) % size;
    if (over === 0) return;
    this.room(size - over);
    this.at += size - over;
  }

  message(name, value, where) {
    const {fields} = this.types.get(name);
    if (fields.length === 0) {
      this.room(1);
      ++this.at;
    }
    for (const field of fields) this.field(field, value[field.name] ?? field.default, `${where}${field.name}`);
  }

  field(field, value, where) {
    if (!field.array) return this.value(field.type, value, where, field.stringBound);
    const items = value ?? [];
    const count = field.array === 'fixed' ? field.length : items.length;
    if (field.array === 'fixed' && items.length > count) throw new Error(`${where}: ${items.length} values for an array of ${count}`);
    if (field.bound !== undefined && count > field.bound) throw new Error(`${where}: more than ${field.bound} values`);
    if (field.array === 'sequence') this.value('uint32', count, where);
    for (let i = 0; i < count; ++i) this.value(field.type, items[i], `${where}[${i}]`, field.stringBound);
  }

  value(type, value, where, stringBound) {
    if (type === 'string' || type === 'wstring') return this.text(type, String(value ?? ''), where, stringBound);
    const size = SIZE[type];
    if (!size) return this.message(type, value ?? {}, `${where}.`);
    this.align(size);
    this.room(size);
    const at = this.at;
    this.at += size;
    if (type === 'bool') return this.view.setUint8(at, value ? 1 : 0);
    const number = size === 8 && type !== 'float64' ? BigInt(value ?? 0) : Number(value ?? 0);
    if (Number.isNaN(number) && !Number.isNaN(value)) throw new Error(`${where}: ${value} is no number`);
    return this.view[GET[type].replace('get', 'set')](at, number, true);
  }

  text(type, value, where, bound) {
    if (bound !== undefined && value.length > bound) throw new Error(`${where}: longer than ${bound} characters`);
    if (type === 'wstring') {
      this.value('uint32', value.length, where);
      for (let i = 0; i < value.length; ++i) this.value('uint16', value.charCodeAt(i), where);
      return;
    }
    const bytes = TO_UTF8.encode(value);
    this.value('uint32', bytes.length + 1, where);
    this.room(bytes.length + 1);
    this.buffer.set(bytes, this.at);
    this.at += bytes.length + 1;
  }
}
