// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"

namespace nacelle::runtime {

// What a container reports about its streams, callbacks and threads: figures, and pairs that do not match.

/// How messages passed from publish() to their callbacks, which is needed to interpret a latency. Two bits.
enum class HandedOver : std::uint8_t { Never = 0, Inline = 1, AcrossThreads = 2, Both = 3 };
/// Returns "inline" (on one thread), "across threads", "both", or "" for never.
[[nodiscard]] const char* words_of(HandedOver way);

/// One stream of the report.
struct StreamReport {
  std::string name, type;
  std::uint64_t published = 0, delivered = 0;
  std::size_t writers = 0, readers = 0;
  MonotonicTime first, last;  ///< First and last publish().
  std::uint64_t overwritten = 0, full = 0, inactive = 0, expired = 0, discarded = 0, would_block = 0, rehomed = 0;
  std::uint64_t inactive_unpublished = 0;  ///< Messages dropped because their writer was not active.
  std::uint64_t pool_dry = 0;              ///< Messages dropped because their writer's pool was empty.
  std::uint64_t pool_grown = 0;            ///< Messages that the writers' pools allocated.
  std::uint64_t copies = 0, bytes_copied = 0;
  std::uint64_t deadline_missed = 0;                     ///< Periods in which a writer broke the deadline it offers.
  Duration latency_p50{}, latency_p99{}, latency_max{};  ///< From publish() to the start of the callback.
  HandedOver handed_over = HandedOver::Never;            ///< How messages passed to the callbacks.
  /// Messages per second between the first and the last publish(); 0 for fewer than two.
  [[nodiscard]] double hz() const;
};

/// One reader of a stream, with its waiting messages.
struct ReaderReport {
  std::string topic, type, node;
  bool other_process = false;  ///< True for the proxy of a reader in another process.
  bool open = true;            ///< The lifecycle gate.
  bool keeps_all = false;
  std::size_t waiting = 0;  ///< Messages in its queue now.
  std::size_t depth = 0;    ///< Capacity of its queue.
  std::uint64_t delivered = 0, overwritten = 0, full = 0, inactive = 0, expired = 0, discarded = 0;
  std::uint64_t deadline_missed = 0;  ///< Periods of its requested deadline that passed without a message.
  Duration latency_p50{}, latency_p99{}, latency_max{};  ///< publish() to callback start.
};

struct HistogramReport {
  std::string node, name;
  std::uint64_t count = 0;
  Duration p50{}, p99{}, max{};
};

/// One callback of a component.
struct CallbackReport {
  std::string node;  ///< "/lidar"
  std::string kind;  ///< "subscription", "timer", "service" or "client"
  std::string name;  ///< The topic or service; a timer's period.
  std::uint64_t count = 0;
  std::uint64_t skipped = 0;                                ///< Ticks that did not run because an earlier one was late.
  Duration duration_p50{}, duration_p99{}, duration_max{};  ///< Start to return.
  Duration duration_total{};                                ///< Within 6.25 %.
  /// Until the start: from publish(), from the moment at which the timer was due, from the arrival of the call.
  Duration latency_p50{}, latency_p99{}, latency_max{};
};

/// One thread of an executor.
struct ThreadReport {
  std::string executor;        ///< "executor" is the shared one.
  std::int32_t thread_id = 0;  ///< As in /proc/self/task.
  const char* state = "";      ///< "serving", "late" (its callback runs too long) or "spare"
  Duration cpu{};              ///< Since it was started.
};

/// The cost of a component. Reading a thread's CPU clock is a system call, so about one callback in 128 is measured.
struct LoadReport {
  std::string node;
  std::uint64_t callbacks = 0;  ///< Callbacks that ran.
  std::uint64_t samples = 0;    ///< How many of them were measured.
  Duration cpu{};               ///< Estimate: the mean of the samples times the callbacks.
  std::string executor;         ///< The executor that runs them; "executor" is the shared one.
  bool own_threads = false;     ///< True if the executor runs this component only.
  Duration thread_cpu{};        ///< With own_threads: the exact CPU time of the executor's threads; else zero.
};

/// A pair of endpoints on one topic with incompatible QoS, and the change that would make them compatible.
struct ClashReport {
  std::string topic, writer_node, reader_node, policy, offered, requested, change;
  std::size_t other_writers = 0;  ///< Publishers of the topic that are compatible with this subscription.
  /// What is wrong, without topic and change. `writer_place` is where the publisher's QoS was set, if that is known.
  [[nodiscard]] std::string what(const std::string& writer_place = {}) const;
  [[nodiscard]] std::string text() const;
};

/// How a stream is wired now, and its cost.
struct WiringReport {
  std::string topic;
  std::vector<std::string> writer_nodes;
  std::vector<std::string> owner_nodes;      ///< Nodes that take ownership of the message (Loan, unique_ptr).
  std::vector<std::string> other_processes;  ///< Nodes of other processes that send or receive it here: a copy each.
  std::uint64_t copies = 0;  ///< Per message, in publish() and on links, for the writer that makes the most.
  std::uint64_t late = 0;    ///< Messages so far that were older than the given age when their callback began.
};

}  // namespace nacelle::runtime
