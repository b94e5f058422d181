// SPDX-License-Identifier: Apache-2.0
#include "answers/statistics.hpp"

#include <algorithm>
#include <vector>

#include "process/process_figures.hpp"

namespace nacelle::answers {
namespace {

namespace msg = nacelle_interfaces::msg;

double us(Duration duration) { return to_seconds(duration) * 1e6; }

std::vector<msg::StreamStatistics> streams_of(const runtime::Container& container) {
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  std::vector<msg::StreamStatistics> rows;
  for (const auto& stream : streams) {
    if (stream.writers == 0 && stream.readers == 0) continue;  // a stream that was
    auto& row = rows.emplace_back();
    row.name = stream.name;
    row.type = stream.type;
    row.writers = stream.writers;
    row.readers = stream.readers;
    row.published = stream.published;
    row.delivered = stream.delivered;
    row.last_ns = stream.last.nanoseconds();
    row.copies = stream.copies;
    row.bytes_copied = stream.bytes_copied;
    row.handed_over = words_of(stream.handed_over);
    row.latency_p50_us = us(stream.latency_p50);
    row.latency_p99_us = us(stream.latency_p99);
    row.latency_max_us = us(stream.latency_max);
    row.dropped.overwritten = stream.overwritten;
    row.dropped.full = stream.full;
    row.dropped.expired = stream.expired;
    row.dropped.inactive = stream.inactive + stream.inactive_unpublished;
    row.dropped.would_block = stream.would_block;
    row.dropped.pool_dry = stream.pool_dry;
    row.dropped.discarded = stream.discarded;
    row.deadline_missed = stream.deadline_missed;
  }
  return rows;
}

std::vector<msg::ReaderStatistics> readers_of(const runtime::Container& container) {
  std::vector<runtime::ReaderReport> readers;
  container.report_readers(readers);
  std::vector<msg::ReaderStatistics> rows;
  for (const auto& reader : readers) {
    auto& row = rows.emplace_back();
    row.topic = reader.topic;
    row.type = reader.type;
    row.node = reader.node;
    row.other_process = reader.other_process;
    row.open = reader.open;
    row.keeps_all = reader.keeps_all;
    row.waiting = reader.waiting;
    row.depth = reader.depth;
    row.delivered = reader.delivered;
    row.lost = reader.overwritten + reader.full + reader.expired;
    row.deadline_missed = reader.deadline_missed;
    row.latency_p99_us = us(reader.latency_p99);
    row.latency_max_us = us(reader.latency_max);
  }
  return rows;
}

std::vector<msg::ComponentStatistics> components_of(const runtime::Container& container) {
  std::vector<runtime::LoadReport> loads;
  container.report_loads(loads);
  std::vector<msg::ComponentStatistics> rows;
  for (const auto& info : container.list()) {
    auto& row = rows.emplace_back();
    row.node = info.node;
    if (info.managed) row.state = nacelle::to_text(info.state);
    const auto load = std::ranges::find(loads, info.node, &runtime::LoadReport::node);
    if (load != loads.end()) {
      row.executor = load->executor;
      row.own_threads = load->own_threads;
      row.callbacks = load->callbacks;
      row.samples = load->samples;
      row.cpu_us = us(load->own_threads ? load->thread_cpu : load->cpu);
    } else if (const auto usage = info.process != 0 ? process::usage_of_process(info.process) : std::nullopt) {
      row.process = info.process;
      row.cpu_us = us(usage->cpu);
      row.rss_bytes = usage->rss_bytes;
    }
  }
  return rows;
}

/// Those of executors have exact times; the others (of drivers, of the container itself) are known by name.
std::vector<msg::ThreadStatistics> threads_of(const runtime::Container& container) {
  std::vector<runtime::ThreadReport> threads;
  container.report_threads(threads);
  std::vector<msg::ThreadStatistics> rows;
  const auto add = [&](std::int32_t id, const std::string& name, Duration cpu) -> msg::ThreadStatistics& {
    auto& row = rows.emplace_back();
    row.id = id;
    row.name = name;
    row.cpu_us = us(cpu);
    return row;
  };
  for (const auto& thread : threads) {
    auto& row = add(thread.thread_id, thread.executor, thread.cpu);
    row.executor = thread.executor;
    row.state = thread.state;
  }
  for (const auto& thread : process::living_threads()) {
    if (std::ranges::find(threads, thread.tid, &runtime::ThreadReport::thread_id) != threads.end()) continue;
    if (const auto cpu = process::cpu_of_thread(thread.tid)) add(thread.tid, thread.name, *cpu);
  }
  return rows;
}

}  // namespace

std::vector<nacelle_interfaces::msg::CallbackStatistics> callbacks_of(const runtime::Container& container,
                                                                      const std::string& node) {
  std::vector<runtime::CallbackReport> callbacks;
  container.report_callbacks(callbacks);
  std::vector<nacelle_interfaces::msg::CallbackStatistics> rows;
  for (const auto& callback : callbacks) {
    if (!node.empty() && callback.node != node) continue;
    auto& row = rows.emplace_back();
    row.node = callback.node;
    row.kind = callback.kind;
    row.name = callback.name;
    row.count = callback.count;
    row.skipped = callback.skipped;
    row.total_us = us(callback.duration_total);
    row.p99_us = us(callback.duration_p99);
    row.max_us = us(callback.duration_max);
  }
  return rows;
}

nacelle_interfaces::srv::GetStatistics::Response statistics_of(const runtime::Container& container) {
  nacelle_interfaces::srv::GetStatistics::Response statistics;
  statistics.container = container.options().name;
  statistics.now_ns = container.clock().now().nanoseconds();
  statistics.process.cpu_us = us(process::cpu_time());
  statistics.process.rss_bytes = process::resident_bytes();
  statistics.streams = streams_of(container);
  statistics.readers = readers_of(container);
  statistics.callbacks = callbacks_of(container, "");
  statistics.components = components_of(container);
  statistics.threads = threads_of(container);
  return statistics;
}

}  // namespace nacelle::answers
