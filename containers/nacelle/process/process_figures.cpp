// SPDX-License-Identifier: Apache-2.0
#include "process/process_figures.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <fstream>

namespace nacelle::process {
namespace {

// Reads a small file of /proc without a stream's heap.
template <std::size_t N>
std::string_view read_small(const char* path, std::array<char, N>& room) {
  const int fd = ::open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return {};
  const ssize_t got = ::read(fd, room.data(), room.size());
  ::close(fd);
  return {room.data(), got > 0 ? static_cast<std::size_t>(got) : 0};
}

std::optional<std::uint64_t> nth_number(std::string_view text, std::size_t index) {
  for (std::size_t i = 0;; ++i) {
    const std::size_t begin = text.find_first_not_of(" \n");
    if (begin == std::string_view::npos) return std::nullopt;
    text.remove_prefix(begin);
    if (i == index) break;
    text.remove_prefix(std::min(text.find(' '), text.size()));
  }
  std::uint64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc{}) return std::nullopt;
  return value;
}

Duration duration_of(const timeval& time) {
  return std::chrono::seconds{time.tv_sec} + std::chrono::microseconds{time.tv_usec};
}

}  // namespace

std::optional<StatLine> parse_stat_line(std::string_view text) {
  // The second field is the program's name in parentheses, which may hold parentheses and blanks itself.
  const std::size_t close = text.rfind(')');
  if (close == std::string_view::npos) return std::nullopt;
  const std::string_view rest = text.substr(close + 1);
  // proc_pid_stat(5) counts from 1; the first field of `rest` is number 3.
  const auto field = [&](std::size_t number) { return nth_number(rest, number - 3); };
  const auto user = field(14), system = field(15), threads = field(20), start = field(22);
  if (!user || !system || !threads || !start) return std::nullopt;
  return StatLine{*user, *system, *start, *threads};
}

Duration time_since_process_start() {
  std::array<char, 1024> room{};
  const auto stat = parse_stat_line(read_small("/proc/self/stat", room));
  const long ticks_per_second = ::sysconf(_SC_CLK_TCK);
  timespec now{};
  if (!stat || ticks_per_second <= 0 || ::clock_gettime(CLOCK_BOOTTIME, &now) != 0) return {};
  const Duration since_boot = std::chrono::seconds{now.tv_sec} + Duration{now.tv_nsec};
  return since_boot - from_seconds(static_cast<double>(stat->start_ticks) / static_cast<double>(ticks_per_second));
}

std::uint64_t resident_bytes() {
  std::array<char, 128> room{};
  const auto pages = nth_number(read_small("/proc/self/statm", room), 1);
  return pages.value_or(0) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

Duration cpu_time() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  return duration_of(used.ru_utime) + duration_of(used.ru_stime);
}

std::vector<NamedThread> living_threads() {
  std::vector<NamedThread> threads;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task", ignored)) {
    NamedThread thread;
    const std::string number = entry.path().filename().string();
    std::from_chars(number.data(), number.data() + number.size(), thread.tid);
    std::ifstream comm{entry.path() / "comm"};
    if (std::getline(comm, thread.name)) threads.push_back(std::move(thread));
  }
  return threads;
}

namespace {

std::optional<Duration> cpu_in(const std::string& stat_file) {
  std::array<char, 1024> room{};
  const auto stat = parse_stat_line(read_small(stat_file.c_str(), room));
  const long ticks_per_second = ::sysconf(_SC_CLK_TCK);
  if (!stat || ticks_per_second <= 0) return std::nullopt;
  return from_seconds(static_cast<double>(stat->user_ticks + stat->system_ticks) /
                      static_cast<double>(ticks_per_second));
}

}  // namespace

std::optional<Usage> usage_of_process(int pid) {
  const std::string folder = "/proc/" + std::to_string(pid);
  const auto cpu = cpu_in(folder + "/stat");
  std::array<char, 128> room{};
  const auto pages = nth_number(read_small((folder + "/statm").c_str(), room), 1);
  if (!cpu || !pages) return std::nullopt;
  return Usage{*cpu, *pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE))};
}

std::optional<Duration> cpu_of_thread(int tid) { return cpu_in("/proc/self/task/" + std::to_string(tid) + "/stat"); }

std::map<std::string, double> allocation_rates(const AllocationSnapshot& before, const AllocationSnapshot& after,
                                               const std::vector<NamedThread>& threads, double seconds) {
  const auto sum_of = [](const AllocationSnapshot& snapshot, int tid) {
    // A number that the kernel gave twice has two slots.
    std::uint64_t calls = 0;
    for (std::size_t i = 0; i < snapshot.count; ++i)
      calls += snapshot.threads[i].tid == tid ? snapshot.threads[i].calls : 0;
    return calls;
  };
  std::map<std::string, double> rates;
  if (!(seconds > 0)) return rates;
  for (const NamedThread& thread : threads) {
    rates[thread.name] += static_cast<double>(sum_of(after, thread.tid) - sum_of(before, thread.tid)) / seconds;
  }
  std::uint64_t ended = after.uncounted - before.uncounted;
  std::vector<int> seen;
  for (std::size_t i = 0; i < after.count; ++i) {
    const int tid = after.threads[i].tid;
    const auto lives = [tid](const NamedThread& thread) { return thread.tid == tid; };
    if (std::any_of(threads.begin(), threads.end(), lives) || std::count(seen.begin(), seen.end(), tid) != 0) continue;
    seen.push_back(tid);
    ended += sum_of(after, tid) - sum_of(before, tid);
  }
  if (ended != 0) rates["(ended)"] = static_cast<double>(ended) / seconds;
  return rates;
}

void SteadyState::begin(MonotonicTime now) {
  begun_ = true;
  began_at_ = now;
  cpu_before_ = cpu_time();
  take_snapshot(before_);
}

ProcessFigures SteadyState::end(MonotonicTime now) {
  take_snapshot(after_);  // before anything below allocates
  ProcessFigures figures;
  const Duration used = cpu_time() - cpu_before_;
  const bool is_enough = begun_ && now - began_at_ >= kShortestMeasure;
  const double seconds = to_seconds(now - began_at_);
  if (is_enough) figures.cpu_percent = 100.0 * to_seconds(used) / seconds;
  figures.rss_mb = static_cast<double>(resident_bytes()) / 1e6;
  const std::vector<NamedThread> threads = living_threads();
  figures.threads = threads.size();
  if (is_enough && allocations_are_counted())
    figures.allocations_per_second = allocation_rates(before_, after_, threads, seconds);
  return figures;
}

}  // namespace nacelle::process
