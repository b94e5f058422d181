// SPDX-License-Identifier: Apache-2.0
// Makes elements. Text comes in through textContent alone.

/** element('button', {class: 'x', type: 'button', onclick: f}, 'text', otherElement) */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, '');
    else if (value !== false && value !== undefined && value !== null) made.setAttribute(name, String(value));
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

export function button(text, onclick, attributes = {}) {
  return element('button', {type: 'button', onclick, ...attributes}, text);
}

/** An input with its label. */
export function labelled(text, input, attributes = {}) {
  return element('label', attributes, element('span', {}, text), input);
}

export function select(options, attributes = {}) {
  return element('select', attributes, ...options.map(([value, text]) => element('option', {value}, text)));
}

export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Keeps rows of a table by key, so that a row that is pressed or read is not replaced. `fill(row, item)` changes cells. */
export class Rows {
  constructor(body, make, fill) {
    Object.assign(this, {body, make, fill});
    this.rows = new Map();
  }

  show(items, keyOf) {
    const left = new Set(this.rows.keys());
    let after = null;
    for (const item of items) {
      const key = keyOf(item);
      left.delete(key);
      let row = this.rows.get(key);
      if (!row) {
        row = this.make(item);
        this.rows.set(key, row);
      }
      const next = after ? after.nextSibling : this.body.firstChild;
      if (next !== row) this.body.insertBefore(row, next);
      this.fill(row, item);
      after = row;
    }
    for (const key of left) {
      this.rows.get(key).remove();
      this.rows.delete(key);
    }
  }
}

/** A table with a heading for each column; body() is where rows go. */
export function table(caption, headings) {
  const body = element('tbody');
  const made = element(
    'table',
    {},
    element('caption', {class: 'unseen'}, caption),
    element('thead', {}, element('tr', {}, ...headings.map((text) => element('th', {scope: 'col'}, text)))),
    body,
  );
  return {table: made, body};
}

/** Fits a canvas to its box and the screen's pixels. Returns its context, with a scale of one CSS pixel, and its size in them. */
export function canvasOf(canvas) {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return {context, width, height};
}

/** The colours of style.css, by the name of a custom property. */
export function colours() {
  const style = getComputedStyle(document.documentElement);
  return (name) => style.getPropertyValue(name).trim();
}
