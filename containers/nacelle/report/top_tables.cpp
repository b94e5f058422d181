// SPDX-License-Identifier: Apache-2.0
#include "report/top_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "report/lateness.hpp"
#include "report/stream_rows.hpp"
#include "report/text_table.hpp"

namespace nacelle::report {
namespace {

using nlohmann::json;

double per_second(double count, const Interval& interval) {
  return interval.seconds > 0 ? count / interval.seconds : 0;
}

json late_readers(const Interval& interval, const json& stream, double hz) {
  json late = json::array();
  for (const auto& reader : interval.after["readers"]) {
    if (reader["topic"] != stream["name"] || reader["type"] != stream["type"]) continue;
    if (std::string why = why_late(interval, reader, hz); !why.empty()) {
      late.push_back({{"node", reader["node"]},
                      {"why", why},
                      {"waiting", reader["waiting"]},
                      {"depth", reader["depth"]},
                      {"latency_p99_us", reader["latency_p99_us"]}});
    }
  }
  return late;
}

json stream_between(const Interval& interval, const json& stream) {
  const json* const before = interval.earlier("streams", stream, {"name", "type"});
  json row = stream;
  const double hz = per_second(interval.growth(stream, before, "published"), interval);
  double dropped = 0;
  for (const auto& [cause, count] : stream["dropped"].items())
    dropped += interval.growth(stream["dropped"], before != nullptr ? &(*before)["dropped"] : nullptr, cause.c_str());
  row["hz"] = hz;
  row["dropped_per_s"] = per_second(dropped, interval);
  row["age_s"] = nullptr;
  if (stream["published"] != 0) {  // a message may have come after the time was read
    row["age_s"] = std::max(0.0, (interval.after["now_ns"].get<double>() - stream["last_ns"].get<double>()) * 1e-9);
  }
  row["late"] = late_readers(interval, stream, hz);
  row.erase("last_ns");
  return row;
}

json component_between(const Interval& interval, const json& component) {
  const json* const before = interval.earlier("components", component, {"node"});
  const std::string node = component["node"];
  json row{{"node", node}, {"state", component["state"]}};
  row["cpu_percent"] = row["callbacks_per_s"] = row["mean_us"] = row["max_us"] = row["rss_mb"] = nullptr;
  if (component.contains("cpu_us")) {
    const double percent = 100 * per_second(interval.growth(component, before, "cpu_us") * 1e-6, interval);
    row["cpu_percent"] = percent;
    row["cpu_by"] = component.contains("process")      ? "process"
                    : component["own_threads"] == true ? "threads"
                                                       : "callbacks";
  }
  if (component.contains("executor")) row["executor"] = component["executor"];
  if (component.contains("process")) row["process"] = component["process"];
  if (component.contains("rss_bytes")) row["rss_mb"] = component["rss_bytes"].get<double>() / 1e6;
  double count = 0, total_us = 0, max_us = 0;
  bool any = false;
  for (const auto& callback : interval.after["callbacks"]) {
    if (callback["node"] != node) continue;
    const json* const earlier = interval.earlier("callbacks", callback, {"node", "kind", "name"});
    any = true;
    count += interval.growth(callback, earlier, "count");
    total_us += interval.growth(callback, earlier, "total_us");
    max_us = std::max(max_us, callback["max_us"].get<double>());
  }
  if (any) {
    row["callbacks_per_s"] = per_second(count, interval);
    if (count > 0) row["mean_us"] = total_us / count;
    row["max_us"] = max_us;
  }
  std::size_t waiting = 0, depth = 0;
  for (const auto& reader : interval.after["readers"]) {
    if (reader["node"] != node) continue;
    waiting += reader["waiting"].get<std::size_t>();
    depth += reader["depth"].get<std::size_t>();
  }
  row["waiting"] = waiting;
  row["depth"] = depth;
  return row;
}

std::string cell(const json& value, const char* format) {
  return value.is_null() ? "-" : fmt::format(fmt::runtime(format), value.get<double>());
}

std::string time_cell(const json& us) { return us.is_null() ? "-" : time_text(us.get<double>()); }

std::string drops(const json& stream) {
  std::string text;
  for (const auto& [cause, count] : stream["dropped"].items()) {
    if (count != 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count.get<std::uint64_t>(), cause);
  }
  if (stream["deadline_missed"] != 0)
    text +=
        fmt::format("{}{} deadline missed", text.empty() ? "" : ", ", stream["deadline_missed"].get<std::uint64_t>());
  return text.empty() ? "-" : text;
}

}  // namespace

json streams_between(const json& before, const json& after) {
  const Interval interval{before, after};
  json rows = json::array();
  for (const auto& stream : after["streams"]) rows.push_back(stream_between(interval, stream));
  // Streams without readers come last: on a terminal they are the first to be cut off.
  const auto place = [](const json& row) { return std::pair{row["readers"] == 0, row["name"].get<std::string>()}; };
  std::stable_sort(rows.begin(), rows.end(), [&](const json& a, const json& b) { return place(a) < place(b); });
  return {{"seconds", interval.seconds}, {"streams", std::move(rows)}};
}

json components_between(const json& before, const json& after) {
  const Interval interval{before, after};
  json rows = json::array(), others = json::array();
  for (const auto& component : after["components"]) rows.push_back(component_between(interval, component));
  const auto load = [](const json& row) {
    return row["cpu_percent"].is_null() ? -1 : row["cpu_percent"].get<double>();
  };
  std::stable_sort(rows.begin(), rows.end(), [&](const json& a, const json& b) { return load(a) > load(b); });
  for (const auto& thread : after["threads"]) {
    if (!thread["executor"].get<std::string>().empty()) continue;
    const json* const earlier = interval.earlier("threads", thread, {"id", "name"});
    others.push_back({{"name", thread["name"]},
                      {"id", thread["id"]},
                      {"cpu_percent", 100 * per_second(interval.growth(thread, earlier, "cpu_us") * 1e-6, interval)}});
  }
  std::stable_sort(others.begin(), others.end(), [&](const json& a, const json& b) { return load(a) > load(b); });
  const json& process = after["process"];
  return {{"container", after["container"]},
          {"seconds", interval.seconds},
          {"cpu_percent", 100 * per_second(interval.growth(process, &before["process"], "cpu_us") * 1e-6, interval)},
          {"rss_mb", process["rss_bytes"].get<double>() / 1e6},
          {"threads", after["threads"].size()},
          {"components", std::move(rows)},
          {"other_threads", std::move(others)}};
}

std::string streams_text(const json& streams, std::size_t width) {
  TextTable table{{{"STREAM", false, 4},
                   {"HZ", true, 4},
                   {"AGE", true, 3},
                   {"PUBLISHED", true, 0},
                   {"READERS", true, 2},
                   {"COPIES", true, 1},
                   {"P99", true, 3},
                   {"DROPPED", false, 4}}};
  for (const auto& row : rows_of(streams["streams"])) {
    const json& stream = *row.stream;
    const auto& age = stream["age_s"];
    table.add_row(
        {row.label, fmt::format("{:.2f}", stream["hz"].get<double>()),
         age.is_null() ? "-" : time_text(age.get<double>() * 1e6),
         std::to_string(stream["published"].get<std::uint64_t>()), std::to_string(stream["readers"].get<std::size_t>()),
         std::to_string(stream["copies"].get<std::uint64_t>()),
         stream["delivered"] == 0 ? "-" : time_text(stream["latency_p99_us"].get<double>()),
         drops(stream) +
             (stream["dropped_per_s"] > 0.0 ? fmt::format(" ({:.1f}/s)", stream["dropped_per_s"].get<double>()) : "")});
    for (const auto& late : stream["late"])
      table.add_line(fmt::format("  {} is late: {}", late["node"].get<std::string>(), late["why"].get<std::string>()));
  }
  return table.text(width);
}

std::string components_text(const json& components, std::size_t width) {
  TextTable table{{{"COMPONENT", false, 4},
                   {"STATE", false, 3},
                   {"CPU %", true, 4},
                   {"BY", false, 0},
                   {"CALLBACKS/S", true, 2},
                   {"MEAN", true, 3},
                   {"MAX", true, 3},
                   {"QUEUED", true, 3},
                   {"MEMORY", true, 1}}};
  for (const auto& row : components["components"]) {
    const auto& memory = row["rss_mb"];
    table.add_row({row["node"].get<std::string>(), row["state"].get<std::string>(), cell(row["cpu_percent"], "{:.1f}"),
                   row.value("cpu_by", "-"), cell(row["callbacks_per_s"], "{:.1f}"), time_cell(row["mean_us"]),
                   time_cell(row["max_us"]),
                   fmt::format("{}/{}", row["waiting"].get<std::size_t>(), row["depth"].get<std::size_t>()),
                   memory.is_null() ? "shared" : fmt::format("{:.1f} MB", memory.get<double>())});
  }
  std::string others;
  for (const auto& thread : components["other_threads"]) {
    others += fmt::format("{}{} {:.1f} %", others.empty() ? "" : ", ", thread["name"].get<std::string>(),
                          thread["cpu_percent"].get<double>());
  }
  if (!others.empty()) table.add_line("other threads: " + others);
  return fmt::format("{}: {:.1f} % of a core, {:.1f} MB, {} threads\n", components["container"].get<std::string>(),
                     components["cpu_percent"].get<double>(), components["rss_mb"].get<double>(),
                     components["threads"].get<std::size_t>()) +
         table.text(width);
}

}  // namespace nacelle::report
