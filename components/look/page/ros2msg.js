// SPDX-License-Identifier: Apache-2.0
// Parses ros2msg schemas: the text of a message, followed by the texts of the messages that it contains.

const NUMBERS = ['int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'int64', 'uint64', 'float32', 'float64'];
const ALIASES = {byte: 'uint8', char: 'uint8'};
export const PRIMITIVES = new Set([...NUMBERS, 'bool', 'string', 'wstring']);
export const NUMERIC = new Set([...NUMBERS, 'bool']);

/** Returns `pkg/Type` of `pkg/msg/Type`, and of `Type` inside of `pkg`. */
export function shortName(name, pkg = '') {
  const parts = name.split('/');
  if (parts.length === 1) return `${pkg}/${name}`;
  return `${parts[0]}/${parts[parts.length - 1]}`;
}

/** Returns the schema {name, types: Map of short names to {fields, constants}}. Throws an Error if the text is no schema. */
export function parseSchema(name, text) {
  const root = shortName(name);
  const types = new Map();
  const [first, ...others] = text.split(/^={80}[ \t]*\r?$/m);
  types.set(root, parseMessage(first, root.split('/')[0]));
  for (const part of others) {
    const found = /^\s*MSG:[ \t]*(\S+)[ \t]*\r?$/m.exec(part);
    if (!found) throw new Error(`schema of ${name}: a part has no line "MSG: pkg/Type"`);
    const key = shortName(found[1]);
    types.set(key, parseMessage(part.slice(found.index + found[0].length), key.split('/')[0]));
  }
  for (const [key, {fields}] of types) {
    for (const field of fields) {
      if (!PRIMITIVES.has(field.type) && !types.has(field.type))
        throw new Error(`schema of ${name}: ${key} contains ${field.type}, which is not defined`);
    }
  }
  return {name: root, types};
}

function parseMessage(text, pkg) {
  const fields = [];
  const constants = {};
  for (const raw of text.split('\n')) {
    const line = withoutComment(raw).trim();
    if (line === '') continue;
    const words = /^([\w/]+)(<=\d+)?(\[(?:<=)?\d*\])?\s+([A-Za-z]\w*)\s*(.*)$/.exec(line);
    if (!words) throw new Error(`"${line}" is neither a field nor a constant`);
    const [, written, stringBound, brackets, name, rest] = words;
    const base = ALIASES[written] ?? written;
    const type = PRIMITIVES.has(base) ? base : shortName(base, pkg);
    if (rest.startsWith('=')) {
      constants[name] = valueOf(type, rest.slice(1).trim());
      continue;
    }
    const field = {name, type};
    if (stringBound) field.stringBound = Number(stringBound.slice(2));
    if (brackets) {
      const inside = brackets.slice(1, -1);
      if (inside === '') field.array = 'sequence';
      else if (inside.startsWith('<=')) Object.assign(field, {array: 'sequence', bound: Number(inside.slice(2))});
      else Object.assign(field, {array: 'fixed', length: Number(inside)});
    }
    if (rest !== '') field.default = defaultOf(field, rest);
    fields.push(field);
  }
  return {fields, constants};
}

/** A # inside of quotes is no comment. */
function withoutComment(line) {
  let quote = '';
  for (let i = 0; i < line.length; ++i) {
    const c = line[i];
    if (quote !== '') {
      if (c === '\\') ++i;
      else if (c === quote) quote = '';
    } else if (c === '"' || c === "'") {
      quote = c;
    } else if (c === '#') {
      return line.slice(0, i);
    }
  }
  return line;
}

function defaultOf(field, text) {
  if (!field.array) return valueOf(field.type, text);
  const inside = text.replace(/^\[|\]$/g, '').trim();
  if (inside === '') return [];
  const items = inside.match(/"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|[^,]+/g) ?? [];
  return items.map((item) => valueOf(field.type, item.trim()));
}

function valueOf(type, text) {
  if (type === 'bool') return text === '1' || text.toLowerCase() === 'true';
  if (type === 'string' || type === 'wstring') {
    const quoted = /^(["'])(.*)\1$/s.exec(text);
    return quoted ? quoted[2].replace(/\\(["'\\])/g, '$1') : text;
  }
  if (type === 'int64' || type === 'uint64') return BigInt(text);
  const number = Number(text);
  if (Number.isNaN(number) && !/^nan$/i.test(text)) throw new Error(`"${text}" is no ${type}`);
  return number;
}
