// SPDX-License-Identifier: Apache-2.0
#include "remote/remote_requests.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "process/event_loop.hpp"
#include "remote/remote_nodes.hpp"
#include "requests/request_server.hpp"

namespace nacelle::remote {
namespace {

// A signal handler has no user argument.
std::atomic<int> signal_event{-1};
std::atomic<int> signal_number{0};
constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};

void on_signal(int number) {
  signal_number = number;
  const int saved = errno;
  const std::uint64_t one = 1;
  static_cast<void>(!::write(signal_event.load(), &one, sizeof one));
  errno = saved;
}

/// Only for signals without a handler: a command that listens has its own (process/stop_signal.hpp).
void watch_signals() {
  signal_event = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int number : kSignals) {
    struct sigaction before {};
    ::sigaction(number, nullptr, &before);
    if (before.sa_handler == SIG_DFL) ::sigaction(number, &action, nullptr);
  }
}

void forget_signals() {
  for (const int number : kSignals) {
    struct sigaction now {};
    ::sigaction(number, nullptr, &now);
    if (now.sa_handler == on_signal) ::signal(number, SIG_DFL);
  }
  ::close(signal_event.exchange(-1));
}

/// Ends the process as if the signal had not been caught.
[[noreturn]] void die_of_signal() {
  const int number = signal_number.load();
  ::signal(number, SIG_DFL);
  ::kill(::getpid(), number);
  ::_exit(128 + number);
}

}  // namespace

Result<std::unique_ptr<RemoteRequests>, Problem> RemoteRequests::open(const RemoteOptions& options) {
  auto network = RemoteNetwork::join(options);
  if (!network) return err(network.error());
  return std::unique_ptr<RemoteRequests>(new RemoteRequests{std::move(network).value(), options.spin_time});
}

RemoteRequests::RemoteRequests(std::unique_ptr<RemoteNetwork> network, Duration spin_time)
    : network_(std::move(network)), spin_time_(spin_time) {
  watch_signals();
  network_->interrupted_by({stop_.descriptor(), signal_event.load()});
  thread_ = std::thread([this] { run(); });
}

RemoteRequests::~RemoteRequests() {
  stop_.ring();
  thread_.join();
  forget_signals();
}

Result<control::Client, Problem> RemoteRequests::connect() {
  std::array<int, 2> ends{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return err(Problem{"--remote", std::strerror(errno), ""});
  ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
  coming_.lock()->push_back(std::make_unique<control::Connection>(ends[1]));
  came_.ring();
  return control::Client::over(ends[0], spin_time_);
}

void RemoteRequests::run() {
  pthread_setname_np(pthread_self(), "remote");
  {
    RemoteNodes nodes{*network_};
    requests::RequestServer server{nodes};
    process::EventLoop loop{network_->clock()};
    loop.add(process::on_readable("stop", stop_.descriptor(), [&] { loop.end(); }));
    loop.add(process::on_readable("signal", signal_event.load(), [&] { loop.end(); }));
    loop.add({.name = "requests",
              .watch = [&](std::vector<pollfd>& waits) { server.append_waits(waits); },
              .next_due = [&] { return server.next_due(); },
              .serve = [&](std::span<const pollfd> waits) { server.serve(waits.data()); },
              .shed = {}});
    loop.add(process::on_readable("network", network_->descriptor(), [&] {
      network_->drain();
      server.end_hopeless_listening();
    }));
    loop.add(process::on_readable("connections", came_.descriptor(), [&] {
      came_.silence();
      std::vector<std::unique_ptr<control::Connection>> coming;
      coming.swap(*coming_.lock());
      for (auto& connection : coming) server.take(std::move(connection));
    }));
    static_cast<void>(loop.run());
  }
  network_.reset();
  if (signal_number.load() != 0) die_of_signal();
}

}  // namespace nacelle::remote
