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

/// This process's own variables, with `changed` in place of those of the same name.
std::vector<std::string> environment_with(const std::map<std::string, std::string>& changed) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string line = *variable;
    if (!changed.contains(line.substr(0, line.find('=')))) variables.push_back(line);
  }
  for (const auto& [name, value] : changed) variables.emplace_back(name).append("=").append(value);
  return variables;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

PeerProcess::PeerProcess(const std::string& program, const std::vector<std::string>& arguments,
                         const std::map<std::string, std::string>& environment) {
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) return;
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> variables = environment_with(environment);
  std::vector<char*> argv = pointers_to(words), envp = pointers_to(variables);
  const pid_t parent = ::getpid();
  id_ = ::fork();
  if (id_ == 0) {
    // No memory may be asked for here: at the fork another thread may have held the allocator's lock, for ever in this copy.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(0);
    ::dup2(in[0], STDIN_FILENO);
    ::dup2(out[1], STDOUT_FILENO);
    ::execve(program.c_str(), argv.data(), envp.data());
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

std::string PeerProcess::line() {
  for (;;) {
    if (const auto end = read_.find('\n'); end != std::string::npos) {
      std::string line = read_.substr(0, end);
      read_.erase(0, end + 1);
      return line;
    }
    pollfd ready{output_, POLLIN, 0};
    if (::poll(&ready, 1, kPatience_ms) <= 0) return {};
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
