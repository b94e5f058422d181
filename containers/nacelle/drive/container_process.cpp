// SPDX-License-Identifier: Apache-2.0
#include "drive/container_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>

#include "control/socket_path.hpp"

namespace nacelle::drive {
namespace {

constexpr std::size_t kKeptLines = 30;
constexpr std::size_t kLongestLine = 4096;
constexpr std::size_t kMostComplaints = 64U << 10U;

}  // namespace

ContainerProcess::ContainerProcess(std::unique_ptr<process::ForeignProgram> process, int output, std::string name,
                                   bool show_output, const Clock& clock)
    : process_(std::move(process)), output_(output), name_(std::move(name)), show_output_(show_output), clock_(clock) {}

ContainerProcess::~ContainerProcess() {
  process_->stop(clock_);
  ::close(output_);
}

Result<std::unique_ptr<ContainerProcess>, Problem> ContainerProcess::start(process::ProgramSpec spec,
                                                                           std::string container_name, bool show_output,
                                                                           const Clock& clock) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return err(Problem{"pipe", "no descriptor is free", "raise `ulimit -n`"});
  ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
  spec.output_descriptor = ends[1];
  auto process = process::ForeignProgram::start(spec);
  ::close(ends[1]);
  if (!process) {
    ::close(ends[0]);
    return err(process.error());
  }
  return std::unique_ptr<ContainerProcess>{
      new ContainerProcess{std::move(process).value(), ends[0], std::move(container_name), show_output, clock}};
}

Result<control::Client, Problem> ContainerProcess::connect(Duration limit, int stop_descriptor) {
  const MonotonicTime until = clock_.now() + limit;
  const auto path = control::socket_path_of(control::socket_places_from_environment(), name_);
  if (!path) return err(path.error());
  while (true) {
    if (auto client = control::Client::connect(path.value())) return client;
    if (!ended().empty()) return err(Problem{"container", ended(), ""});
    if (clock_.now() > until)
      return err(Problem{"container", "its control socket did not appear", "is the machine overloaded?"});
    pollfd stop{stop_descriptor, POLLIN, 0};
    if (::poll(&stop, 1, 0) > 0) return err(Problem{"", "interrupted", ""});
    listen(5ms, stop_descriptor);
  }
}

void ContainerProcess::listen(Duration limit, int stop_descriptor) {
  std::array<pollfd, 3> waits{pollfd{output_, POLLIN, 0}, pollfd{process_->descriptor(), POLLIN, 0},
                              pollfd{stop_descriptor, POLLIN, 0}};
  const timespec time{limit.count() / 1'000'000'000, limit.count() % 1'000'000'000};
  if (::ppoll(waits.data(), waits.size(), &time, nullptr) <= 0) return;
  const bool hung_up = (waits[0].revents & POLLHUP) != 0 && (waits[0].revents & POLLIN) == 0;
  if (waits[0].revents != 0) take_output();
  // A closed pipe would answer at once for ever; its reader is about to end.
  if (hung_up && process_->descriptor() >= 0) {
    pollfd end{process_->descriptor(), POLLIN, 0};
    ::poll(&end, 1, 10);
  }
}

void ContainerProcess::take_output() {
  std::array<char, 4096> chunk{};
  ssize_t got = 0;
  while ((got = ::read(output_, chunk.data(), chunk.size())) > 0) {
    const std::string_view text{chunk.data(), static_cast<std::size_t>(got)};
    if (show_output_) std::fwrite(text.data(), 1, text.size(), stderr);
    partial_.append(text);
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = partial_.find('\n', begin)) != std::string::npos; begin = end + 1) {
      take_line(partial_.substr(begin, end - begin));
    }
    partial_.erase(0, begin);
    if (partial_.size() > kLongestLine) partial_.clear();
  }
}

void ContainerProcess::take_line(std::string line) {
  complaining_ = line.rfind("nacelle: ", 0) == 0 || (complaining_ && line.rfind("  ", 0) == 0);
  if (complaining_ && complaints_.size() + line.size() < kMostComplaints) complaints_ += line + "\n";
  lines_.push_back(std::move(line));
  if (lines_.size() > kKeptLines) lines_.pop_front();
}

std::string ContainerProcess::wait_for_end(Duration limit) {
  const MonotonicTime until = clock_.now() + limit;
  while (ended().empty() && clock_.now() < until) listen(until - clock_.now(), -1);
  if (ended().empty()) process_->stop(clock_);
  take_output();
  return ended();
}

void ContainerProcess::interrupt() const { ::kill(process_->pid(), SIGINT); }

std::string ContainerProcess::last_lines() const {
  std::string text;
  for (const auto& line : lines_) text += "  | " + line + "\n";
  if (!partial_.empty()) text += "  | " + partial_ + "\n";
  return text;
}

}  // namespace nacelle::drive
