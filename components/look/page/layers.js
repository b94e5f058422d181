// SPDX-License-Identifier: Apache-2.0

/** Returns the names in columns from left to right, so that most edges {from, to} lead to the right; edges that close a loop are left out of
 * account. */
export function layersOf(names, edges) {
  const readers = new Map(names.map((name) => [name, []]));
  for (const {from, to} of edges) readers.get(from).push(to);
  const depth = new Map(names.map((name) => [name, 0]));
  const open = new Set();
  const done = [];
  const seen = new Set();
  const visit = (name) => {
    // depth first: `done` is in the order of readers before writers
    seen.add(name);
    open.add(name);
    readers.set(
      name,
      readers.get(name).filter((to) => !open.has(to)),
    );
    for (const to of readers.get(name)) if (!seen.has(to)) visit(to);
    open.delete(name);
    done.push(name);
  };
  const read = new Set(edges.map(({to}) => to));
  for (const name of [...names].sort((a, b) => read.has(a) - read.has(b))) if (!seen.has(name)) visit(name);
  for (const name of done.reverse()) for (const to of readers.get(name)) depth.set(to, Math.max(depth.get(to), depth.get(name) + 1));
  const layers = [];
  for (const name of names) (layers[depth.get(name)] ??= []).push(name);
  const rows = new Map();
  const writers = new Map(names.map((name) => [name, edges.filter(({to}) => to === name).map(({from}) => from)]));
  return Array.from(layers, (layer = []) => {
    const mean = (name) => {
      const known = writers
        .get(name)
        .map((from) => rows.get(from))
        .filter((row) => row !== undefined);
      return known.length > 0 ? known.reduce((sum, row) => sum + row, 0) / known.length : Infinity;
    };
    layer.sort((a, b) => mean(a) - mean(b) || (a < b ? -1 : 1));
    layer.forEach((name, row) => rows.set(name, row));
    return layer;
  });
}
