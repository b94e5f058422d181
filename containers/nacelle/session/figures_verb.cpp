// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/figures_verb.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nacelle/session/process_figures.hpp"
#include "nacelle/session/session.hpp"

namespace nacelle::session {
namespace {

using nlohmann::json;

double us(Duration duration) { return to_seconds(duration) * 1e6; }

json streams_of(const runtime::Container& container) {
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  json rows = json::array();
  for (const auto& stream : streams) {
    if (stream.writers == 0 && stream.readers == 0) continue;  // a stream that was
    rows.push_back({{"name", stream.name},
                    {"type", stream.type},
                    {"writers", stream.writers},
                    {"readers", stream.readers},
                    {"published", stream.published},
                    {"delivered", stream.delivered},
                    {"last_ns", stream.last.nanoseconds()},
                    {"copies", stream.copies},
                    {"bytes_copied", stream.bytes_copied},
                    {"handed_over", runtime::words_of(stream.handed_over)},
                    {"latency_p50_us", us(stream.latency_p50)},
                    {"latency_p99_us", us(stream.latency_p99)},
                    {"latency_max_us", us(stream.latency_max)},
                    {"dropped",
                     {{"overwritten", stream.overwritten},
                      {"full", stream.full},
                      {"expired", stream.expired},
                      {"inactive", stream.inactive + stream.inactive_unpublished},
                      {"would_block", stream.would_block},
                      {"pool_dry", stream.pool_dry},
                      {"discarded", stream.discarded}}},
                    {"deadline_missed", stream.deadline_missed}});
  }
  return rows;
}

json readers_of(const runtime::Container& container) {
  std::vector<runtime::ReaderReport> readers;
  container.report_readers(readers);
  json rows = json::array();
  for (const auto& reader : readers) {
    rows.push_back({{"topic", reader.topic},
                    {"type", reader.type},
                    {"node", reader.node},
                    {"other_process", reader.other_process},
                    {"open", reader.open},
                    {"keeps_all", reader.keeps_all},
                    {"waiting", reader.waiting},
                    {"depth", reader.depth},
                    {"delivered", reader.delivered},
                    {"lost", reader.overwritten + reader.full + reader.expired},
                    {"deadline_missed", reader.deadline_missed},
                    {"latency_p99_us", us(reader.latency_p99)},
                    {"latency_max_us", us(reader.latency_max)}});
  }
  return rows;
}

json callbacks_of(const runtime::Container& container) {
  std::vector<runtime::CallbackReport> callbacks;
  container.report_callbacks(callbacks);
  json rows = json::array();
  for (const auto& callback : callbacks) {
    rows.push_back({{"node", callback.node},
                    {"kind", callback.kind},
                    {"name", callback.name},
                    {"count", callback.count},
                    {"skipped", callback.skipped},
                    {"total_us", us(callback.duration_total)},
                    {"p99_us", us(callback.duration_p99)},
                    {"max_us", us(callback.duration_max)}});
  }
  return rows;
}

json components_of(const runtime::Container& container) {
  std::vector<runtime::LoadReport> loads;
  container.report_loads(loads);
  json rows = json::array();
  for (const auto& info : container.list()) {
    json row{{"node", info.node}, {"state", info.managed ? nacelle::to_text(info.state) : ""}};
    const auto load = std::find_if(loads.begin(), loads.end(), [&](const auto& l) { return l.node == info.node; });
    if (load != loads.end()) {
      row["callbacks"] = load->callbacks;
      row["executor"] = load->executor;
      row["own_threads"] = load->own_threads;
      row["cpu_us"] = us(load->own_threads ? load->thread_cpu : load->cpu);
      row["samples"] = load->samples;
    } else if (const auto usage = info.process != 0 ? usage_of_process(info.process) : std::nullopt) {
      row["process"] = info.process;
      row["cpu_us"] = us(usage->cpu);
      row["rss_bytes"] = usage->rss_bytes;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Those of executors say so and have exact times; the others (of drivers, of the container itself) are known by name.
json threads_of(const runtime::Container& container) {
  std::vector<runtime::ThreadReport> threads;
  container.report_threads(threads);
  json rows = json::array();
  for (const auto& thread : threads) {
    rows.push_back({{"id", thread.thread_id},
                    {"name", thread.executor},
                    {"executor", thread.executor},
                    {"state", thread.state},
                    {"cpu_us", us(thread.cpu)}});
  }
  for (const auto& thread : living_threads()) {
    if (std::any_of(threads.begin(), threads.end(), [&](const auto& t) { return t.thread_id == thread.tid; })) continue;
    const auto cpu = cpu_of_thread(thread.tid);
    if (cpu) rows.push_back({{"id", thread.tid}, {"name", thread.name}, {"executor", ""}, {"cpu_us", us(*cpu)}});
  }
  return rows;
}

}  // namespace

json figures_of(Session& session) {
  const runtime::Container& container = session.container();
  return {{"ok", true},
          {"container", session.options().container_name},
          {"now_ns", container.clock().now().nanoseconds()},
          {"process", {{"cpu_us", us(cpu_time())}, {"rss_bytes", resident_bytes()}}},
          {"streams", streams_of(container)},
          {"readers", readers_of(container)},
          {"callbacks", callbacks_of(container)},
          {"components", components_of(container)},
          {"threads", threads_of(container)}};
}

}  // namespace nacelle::session
