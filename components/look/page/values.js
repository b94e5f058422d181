// SPDX-License-Identifier: Apache-2.0
// Values of parameters: rcl_interfaces/ParameterValue to JavaScript and back, and as text.

const FIELDS = [
  '',
  'bool_value',
  'integer_value',
  'double_value',
  'string_value',
  'byte_array_value',
  'bool_array_value',
  'integer_array_value',
  'double_array_value',
  'string_array_value',
];
export const TYPES = ['not set', 'bool', 'integer', 'double', 'string', 'byte[]', 'bool[]', 'integer[]', 'double[]', 'string[]'];
const INTEGER = 2,
  INTEGERS = 7,
  DOUBLES = 8,
  STRINGS = 9;

/** Returns the value; undefined if it is not set. */
export function valueOf(message) {
  const value = message[FIELDS[message.type]];
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}

export function messageOf(type, value) {
  return type === 0 ? {type} : {type, [FIELDS[type]]: value};
}

/** Returns the text that an input shows. */
export function textOf(type, value) {
  if (value === undefined) return '';
  if (type === STRINGS) return JSON.stringify(value);
  return Array.isArray(value) ? value.join(', ') : String(value);
}

/** Returns the value that the user wrote. Throws an Error with the reason if it is none of the type. */
export function parseValue(type, text) {
  const words = text.trim();
  if (type === 1) return oneOf(words);
  if (type === INTEGER) return integer(words);
  if (type === 3) return double(words);
  if (type === 4) return text;
  if (type === STRINGS) return strings(words);
  const items = words
    .replace(/^\[|\]$/g, '')
    .split(',')
    .map((word) => word.trim())
    .filter((word) => word !== '');
  return items.map({5: byte, 6: oneOf, [INTEGERS]: integer, [DOUBLES]: double}[type]);
}

function oneOf(word) {
  if (word !== 'true' && word !== 'false') throw new Error(`"${word}" is neither true nor false`);
  return word === 'true';
}
function integer(word) {
  if (!/^[+-]?\d+$/.test(word)) throw new Error(`"${word}" is no integer`);
  return BigInt(word.replace('+', ''));
}
function double(word) {
  if (/^\.?nan$/i.test(word)) return NaN;
  const infinite = /^([+-]?)\.?inf(inity)?$/i.exec(word);
  if (infinite) return infinite[1] === '-' ? -Infinity : Infinity;
  if (word === '' || Number.isNaN(Number(word))) throw new Error(`"${word}" is no number`);
  return Number(word);
}
function byte(word) {
  const value = Number(integer(word));
  if (value < 0 || value > 255) throw new Error(`"${word}" is no byte`);
  return value;
}
function strings(words) {
  if (words === '') return [];
  if (!words.startsWith('[')) return words.split(',').map((word) => word.trim());
  const value = JSON.parse(words);
  if (!value.every((item) => typeof item === 'string')) throw new Error('a list of strings is ["a", "b"]');
  return value;
}

/** Returns parameters of a service such as load_component: {'record.all_topics': true} with the types that the values have. */
export function parametersOf(values) {
  return Object.entries(values).map(([name, value]) => ({name, value: messageOf(typeOf(value), value)}));
}

function typeOf(value) {
  if (Array.isArray(value)) return STRINGS;
  return {boolean: 1, bigint: INTEGER, number: 3, string: 4}[typeof value];
}
