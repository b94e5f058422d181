// SPDX-License-Identifier: Apache-2.0
#include "support/peer_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <utility>

namespace nacelle::test {
namespace {

constexpr int kPatience_ms = 60000;

void close_end(int& end) {
  if (end >= 0) ::close(std::exchange(end, -1));
}

}  // namespace

PeerProcess::PeerProcess(const std::string& program, const std::vector<std::string>& arguments,
                         const std::map<std::string, std::string>& environment) {
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) return;
  // By `env`, since no memory may be asked for after the fork: another thread may have held the allocator's lock then, and for
  // ever in the copy. setenv() asks for some.
  std::vector<std::string> words{"/usr/bin/env"};
  for (const auto& [name, value] : environment) words.emplace_back(name).append("=").append(value);
  words.push_back(program);
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t parent = ::getpid();
  id_ = ::fork();
  if (id_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(0);
    ::dup2(in[0], STDIN_FILENO);
    ::dup2(out[1], STDOUT_FILENO);
    ::execv(pointers[0], pointers.data());
    std::_Exit(127);
  }
  close_end(in[0]);
  close_end(out[1]);
  input_ = in[1];
  output_ = out[0];
}

PeerProcess::~PeerProcess() {
  close_end(input_);
  if (id_ > 0) {
    ::kill(id_, SIGKILL);
    ::waitpid(id_, nullptr, 0);
  }
  close_end(output_);
}

std::string PeerProcess::line(std::chrono::milliseconds limit) {
  for (;;) {
    if (const auto end = read_.find('\n'); end != std::string::npos) {
      std::string line = read_.substr(0, end);
      read_.erase(0, end + 1);
      return line;
    }
    pollfd ready{output_, POLLIN, 0};
    if (::poll(&ready, 1, static_cast<int>(limit.count())) <= 0) return {};
    std::array<char, 4096> bytes{};
    const ssize_t count = ::read(output_, bytes.data(), bytes.size());
    if (count <= 0) return {};
    read_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

void PeerProcess::go() { static_cast<void>(::write(input_, "\n", 1) == 1); }

int PeerProcess::end() {
  close_end(input_);
  // Its output ends with it.
  while (!line().empty()) {}
  const auto limit = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatience_ms);
  int status = 0;
  for (;;) {
    const pid_t ended = ::waitpid(id_, &status, WNOHANG);
    if (ended == id_) break;
    if (std::chrono::steady_clock::now() > limit) return -1000;
    ::poll(nullptr, 0, 1);
  }
  id_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

void PeerProcess::stop() { ::kill(id_, SIGSTOP); }
void PeerProcess::go_on() { ::kill(id_, SIGCONT); }
void PeerProcess::kill_hard() { ::kill(id_, SIGKILL); }

}  // namespace nacelle::test
