// SPDX-License-Identifier: Apache-2.0
#include "drive/live_view.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "nacelle/base/printable.hpp"
#include "report/stream_rows.hpp"

namespace nacelle::drive {
namespace {

constexpr Duration kRateWindow = 2s;
constexpr Duration kLinePeriod = 5s;
constexpr std::size_t kNodesPerLine = 3;

const char* colour_of(const std::string& state) {
  if (state == "active" || state == "running") return "\033[32m";
  if (state == "inactive" || state == "unconfigured") return "\033[33m";
  return "\033[31m";
}

std::size_t terminal_rows() {
  winsize size{};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1 ? size.ws_row : 24;
}

std::string first_lines(std::string text, std::size_t lines) {
  std::size_t end = 0;
  for (std::size_t i = 0; i < lines; ++i) {
    const std::size_t newline = text.find('\n', end);
    if (newline == std::string::npos) return text;
    end = newline + 1;
  }
  text.resize(end);
  return text;
}

}  // namespace

void RateMeter::note(const std::string& stream, std::uint64_t published, MonotonicTime now) {
  auto& counts = counts_[stream];
  counts.push_back({now, published});
  // One count older than the window stays, so that the window is full.
  while (counts.size() > 2 && now - counts[1].at >= kRateWindow) counts.pop_front();
}

double RateMeter::hz(const std::string& stream) const {
  const auto found = counts_.find(stream);
  if (found == counts_.end() || found->second.size() < 2) return 0;
  const Count& first = found->second.front();
  const Count& last = found->second.back();
  const double seconds = to_seconds(last.at - first.at);
  return seconds > 0 && last.published >= first.published
             ? static_cast<double>(last.published - first.published) / seconds
             : 0;
}

void LiveView::show(const nlohmann::json& stats, const std::string& activity, MonotonicTime now) {
  for (const auto& stream : stats["streams"]) rates_.note(report::stream_key(stream), stream["published"], now);
  if (on_terminal_) {
    // Neither wrapped nor scrolled, or the way back up would be another one. Each line clears its own rest: terminals keep what
    // an erasure from the first line of the screen takes away in their scrollback.
    const std::string lines = first_lines(block(stats, activity, now), terminal_rows() - 1);
    std::string text = "\033[?7l";
    if (lines_shown_ > 0) text += fmt::format("\033[{}F", lines_shown_);
    for (const char c : lines) {
      if (c == '\n') text += "\033[K";
      text += c;
    }
    text += "\033[J\033[?7h";  // what a longer block left below
    lines_shown_ = static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n'));
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else {
    const std::string phase = stats.value("phase", "");
    const bool begins = phase != last_phase_ || (!activity.empty() && !was_active_);
    if (!begins && now - last_line_ < kLinePeriod) return;
    was_active_ = !activity.empty();
    last_phase_ = phase;
    last_line_ = now;
    std::printf("%s\n", line(stats, activity, now).c_str());
  }
  std::fflush(stdout);
}

void LiveView::clear() {
  if (on_terminal_ && lines_shown_ > 0) {
    const std::string up = fmt::format("\033[{}F", lines_shown_);
    std::string text = up;
    for (std::size_t i = 0; i < lines_shown_; ++i) text += "\033[K\n";
    text += up;
    std::fwrite(text.data(), 1, text.size(), stdout);
  }
  lines_shown_ = 0;
  std::fflush(stdout);
}

std::string LiveView::block(const nlohmann::json& stats, const std::string& activity, MonotonicTime now) const {
  std::string text =
      fmt::format("\033[1m{:>6.1f} s  {:<9}\033[0m {}\n", to_seconds(now - start_), stats.value("phase", ""), activity);
  std::size_t in_line = 0;
  for (const auto& node : stats["nodes"]) {
    const std::string state = node["state"];
    text += fmt::format("  {:<16}{}{:<12}\033[0m", node["name"].get<std::string>(), colour_of(state), state);
    if (++in_line % kNodesPerLine == 0) text += '\n';
  }
  if (in_line % kNodesPerLine != 0) text += '\n';
  for (const auto& node : stats["nodes"]) {
    if (node.contains("fault"))
      text += fmt::format("  \033[31m{}: {}\033[0m\n", node["name"].get<std::string>(),
                          printable_line(node["fault"].get<std::string>()));
  }
  for (const auto& row : report::rows_of(stats["streams"])) {
    const auto& stream = *row.stream;
    if (stream["writers"].get<int>() == 0) continue;
    text += fmt::format("  {:<26}{:>7.1f} Hz  {:>8} sent  {} reader{}  {} copies\n", row.label,
                        rates_.hz(report::stream_key(stream)), stream["published"].get<std::uint64_t>(),
                        stream["readers"].get<int>(), stream["readers"].get<int>() == 1 ? " " : "s",
                        stream["copies"].get<std::uint64_t>());
  }
  text += fmt::format("  {:.1f} MB, {:.1f} s of CPU\n", stats.value("rss_mb", 0.0), stats.value("cpu_s", 0.0));
  return text;
}

std::string LiveView::line(const nlohmann::json& stats, const std::string& activity, MonotonicTime now) const {
  std::string text = fmt::format("{:>5.1f} s  {}", to_seconds(now - start_), stats.value("phase", ""));
  if (!activity.empty()) text += ", " + activity;
  std::string rates;
  for (const auto& row : report::rows_of(stats["streams"])) {
    if (const double hz = rates_.hz(report::stream_key(*row.stream)); hz >= 0.5)
      rates += fmt::format("{}{} {:.0f}", rates.empty() ? "" : ", ", row.label, hz);
  }
  if (!rates.empty()) text += "; Hz: " + rates;
  return text;
}

}  // namespace nacelle::drive
