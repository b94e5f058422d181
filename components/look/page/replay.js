// SPDX-License-Identifier: Apache-2.0
// A player of recordings (rosbag2's services) with a beginning and an end, which its services do not tell.

const STEP_NS = 50_000_000n;
const LONGEST_NS = 1n << 52n; // 52 days

export function timeOf(ns) {
  return {sec: Number(ns / 1_000_000_000n), nanosec: Number(ns % 1_000_000_000n)};
}
export function nanosecondsOf({sec, nanosec}) {
  return BigInt(sec) * 1_000_000_000n + BigInt(nanosec);
}

/** Returns the last time that `seek` (an async function of ns) accepts after one that it accepts, to 50 ms. With a `direction` of -1n it returns the
 * first time before it. The player must be paused. */
export async function findEdge(from, direction, seek) {
  let good = from;
  let step = 1_000_000_000n;
  while (step < LONGEST_NS && (await seek(from + direction * step))) {
    good = from + direction * step;
    step *= 2n;
  }
  let bad = from + direction * step;
  while ((bad - good) * direction > STEP_NS) {
    const middle = (good + bad) / 2n;
    if (await seek(middle)) good = middle;
    else bad = middle;
  }
  return good;
}

/** Topics that the player itself publishes, too: those of a recording cannot be told from its own. */
export const PLAYERS_OWN = ['/rosout', '/parameter_events'];

/** Returns remap rules for topics that exist already, so that a recording does not get between them. */
export function rulesApart(topics, prefix) {
  const rules = [...new Set(topics)].filter((topic) => !topic.endsWith('/look') && !topic.startsWith(`${prefix}/`) && !PLAYERS_OWN.includes(topic));
  return rules.sort().map((topic) => `${topic}:=${prefix}${topic}`);
}
