// SPDX-License-Identifier: Apache-2.0

/** Calls listeners by the name of an event. */
export class Emitter {
  constructor() {
    this.listeners = new Map();
  }

  /** Returns a function that ends it. */
  on(name, listener) {
    if (!this.listeners.has(name)) this.listeners.set(name, new Set());
    this.listeners.get(name).add(listener);
    return () => this.listeners.get(name).delete(listener);
  }

  emit(name, ...values) {
    for (const listener of [...(this.listeners.get(name) ?? [])]) listener(...values);
  }
}
