// SPDX-License-Identifier: Apache-2.0
// What two answers of get_statistics say of each stream.

const SLOW_US = 20000;

/** Returns rows {name, type, rate, age, dropped, p99, late} of streams. `before` may be null. Ages are s, p99 is ms. */
export function streamRows(before, after) {
  const past = new Map((before?.streams ?? []).map((stream) => [keyOf(stream), stream]));
  const pastReaders = new Map((before?.readers ?? []).map((reader) => [readerKey(reader), reader]));
  const seconds = before ? Number(after.now_ns - before.now_ns) * 1e-9 : 0;
  return after.streams.map((stream) => {
    const old = past.get(keyOf(stream));
    const rate = old && seconds > 0 ? Number(stream.published - old.published) / seconds : NaN;
    const readers = after.readers.filter(({topic, type}) => topic === stream.name && type === stream.type);
    return {
      key: keyOf(stream),
      name: stream.name,
      type: stream.type,
      rate,
      published: Number(stream.published),
      age: stream.last_ns > 0n ? Math.max(0, Number(after.now_ns - stream.last_ns) * 1e-9) : NaN,
      dropped: Object.values(stream.dropped).reduce((sum, count) => sum + Number(count), 0),
      causes: Object.entries(stream.dropped)
        .filter(([, count]) => count > 0n)
        .map(([cause, count]) => `${cause} ${count}`)
        .join(', '),
      p99: stream.latency_p99_us / 1000,
      late: readers
        .map((reader) => lateness(pastReaders.get(readerKey(reader)), reader))
        .filter(Boolean)
        .join('; '),
      writers: Number(stream.writers),
      readers: Number(stream.readers),
    };
  });
}

/** Says why a reader is late; empty: it is not. */
function lateness(old, reader) {
  if (!reader.open) return '';
  const lost = Number(reader.lost - (old?.lost ?? reader.lost));
  const missed = Number(reader.deadline_missed - (old?.deadline_missed ?? reader.deadline_missed));
  const why = [];
  if (lost > 0) why.push(`lost ${lost}`);
  if (missed > 0) why.push(`missed ${missed} deadlines`);
  if (reader.depth > 1n && reader.waiting >= reader.depth) why.push('queue full');
  if (reader.latency_p99_us > SLOW_US) why.push(`${(reader.latency_p99_us / 1000).toFixed(0)} ms`);
  return why.length > 0 ? `${reader.node}: ${why.join(', ')}` : '';
}

function keyOf({name, type}) {
  return `${name} ${type}`;
}
function readerKey({topic, type, node}) {
  return `${topic} ${type} ${node}`;
}
