// SPDX-License-Identifier: Apache-2.0
#include "report/lateness.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::report {

using nlohmann::json;

namespace {

constexpr double kBusy = 0.9;  // of the time: above this, messages wait for earlier ones

/// What a callback did in the interval.
struct Work {
  const json* row = nullptr;
  double count = 0, total_us = 0;
  [[nodiscard]] double mean_us() const { return count > 0 ? total_us / count : 0; }
};

Work work_of(const Interval& interval, const json& callback) {
  const json* const before = interval.earlier("callbacks", callback, {"node", "kind", "name"});
  return {&callback, interval.growth(callback, before, "count"), interval.growth(callback, before, "total_us")};
}

const json* component_of(const json& figures, const std::string& node) {
  for (const auto& row : figures["components"]) {
    if (row["node"] == node) return &row;
  }
  return nullptr;
}

/// Callbacks of other components take turns with this one's.
bool share_a_thread(const json& a, const json& b) {
  if (!a.contains("executor") || !b.contains("executor")) return false;
  return a["node"] == b["node"] || (!a["own_threads"].get<bool>() && !b["own_threads"].get<bool>());
}

std::string why_it_waits(const Interval& interval, const json& component, const json& reader) {
  Work most;
  double busy_us = 0;
  for (const auto& callback : interval.after["callbacks"]) {
    const json* const other = component_of(interval.after, callback["node"]);
    if (other == nullptr || !share_a_thread(component, *other)) continue;
    const Work work = work_of(interval, callback);
    busy_us += work.total_us;
    if (work.total_us > most.total_us) most = work;
  }
  double threads = 0, cpu_us = 0;
  for (const auto& thread : interval.after["threads"]) {
    if (thread["executor"] != component["executor"]) continue;
    if (thread.value("state", "") == "late") return "a callback on its thread runs too long";
    threads += thread.value("state", "") == "serving" ? 1 : 0;
    cpu_us += interval.growth(thread, interval.earlier("threads", thread, {"id", "executor"}), "cpu_us");
  }
  // A waiting callback uses no CPU, and one whose timer was destroyed is in no report.
  const double share = std::max(busy_us, cpu_us) * 1e-6 / (interval.seconds * std::max(threads, 1.0));
  if (share < kBusy) return {};
  std::string why = fmt::format("its thread '{}' is busy {:.0f} % of the time",
                                component["executor"].get<std::string>(), 100 * std::min(share, 1.0));
  if (busy_us < cpu_us / 2 || most.row == nullptr) return why;
  const json& row = *most.row;
  const bool is_own = row["node"] == reader["node"];
  return why + fmt::format(", most of it with {}'s {} {} ({} each)",
                           is_own ? "its own node" : row["node"].get<std::string>(), row["kind"].get<std::string>(),
                           row["name"].get<std::string>(), time_text(most.mean_us()));
}

std::string cause_of(const Interval& interval, const json& reader, double hz, bool falls_behind) {
  if (reader["other_process"].get<bool>()) return "its process does not take its messages in time";
  const json* const component = component_of(interval.after, reader["node"]);
  const json* callback = nullptr;
  for (const auto& row : interval.after["callbacks"]) {
    if (row["node"] == reader["node"] && row["kind"] == "subscription" && row["name"] == reader["topic"])
      callback = &row;
  }
  if (component == nullptr || callback == nullptr) return "it does not take its messages";
  const Work work = work_of(interval, *callback);
  if (work.count > 0 && hz > 0 && work.mean_us() * 1e-6 * hz >= kBusy) {
    return fmt::format("its callback takes {}, and every {} a message comes", time_text(work.mean_us()),
                       time_text(1e6 / hz));
  }
  if (std::string why = why_it_waits(interval, *component, reader); !why.empty()) return why;
  if (!falls_behind) return fmt::format("too few messages arrived ({:.1f} per second)", hz);
  if (work.count == 0) return "its callback has not run";
  const double bridged_us = hz > 0 ? reader["depth"].get<double>() * 1e6 / hz : 0;
  if ((*callback)["max_us"].get<double>() > bridged_us && bridged_us > 0) {
    return fmt::format("its callback took up to {}, and its queue of {} bridges {}",
                       time_text((*callback)["max_us"].get<double>()), reader["depth"].get<std::size_t>(),
                       time_text(bridged_us));
  }
  return fmt::format("messages come in bursts of more than its queue of {}", reader["depth"].get<std::size_t>());
}

}  // namespace

Interval::Interval(const json& first, const json& second)
    : before(first), after(second), seconds((second["now_ns"].get<double>() - first["now_ns"].get<double>()) * 1e-9) {}

const json* Interval::earlier(const char* list, const json& row, std::initializer_list<const char*> keys) const {
  for (const auto& other : before[list]) {
    if (std::all_of(keys.begin(), keys.end(), [&](const char* key) { return other[key] == row[key]; })) return &other;
  }
  return nullptr;
}

double Interval::growth(const json& row, const json* before_row, const char* key) const {
  const double now = row[key].get<double>(), then = before_row != nullptr ? (*before_row)[key].get<double>() : 0.0;
  return now >= then ? now - then : now;
}

std::string why_late(const Interval& interval, const json& reader, double hz) {
  if (!reader["open"].get<bool>()) return {};
  const json* const before = interval.earlier("readers", reader, {"topic", "type", "node"});
  // What came before it was there is not its fault.
  const double lost = before != nullptr ? interval.growth(reader, before, "lost") : 0;
  const double missed = before != nullptr ? interval.growth(reader, before, "deadline_missed") : 0;
  const auto waiting = reader["waiting"].get<std::size_t>(), depth = reader["depth"].get<std::size_t>();
  const bool is_filling = waiting > 1 && 2 * waiting >= depth;
  if (lost == 0 && missed == 0 && !is_filling) return {};
  std::string what;
  const auto say = [&](const std::string& part) { what += (what.empty() ? "" : ", ") + part; };
  if (lost > 0) say(fmt::format("{:.0f} lost", lost));
  if (missed > 0) say(fmt::format("deadline missed {:.0f} times", missed));
  if (waiting > 0) say(fmt::format("{} of {} wait", waiting, depth));
  return what + ": " + cause_of(interval, reader, hz, lost > 0 || is_filling);
}

std::string time_text(double us) {
  if (us < 1000) return fmt::format("{:.0f} us", us);
  if (us < 1e6) return fmt::format("{:.1f} ms", us / 1e3);
  return fmt::format("{:.1f} s", us / 1e6);
}

}  // namespace nacelle::report
