// SPDX-License-Identifier: Apache-2.0
#include "daemon.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "daemon_process.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "quiet.hpp"

namespace nacelle::transport_iceoryx {
namespace {

// Where the daemon's process cannot be watched.
constexpr int kProbeEveryMs = 500;

Problem problem(std::string what, std::string way_out) {
  return {"transport_iceoryx", std::move(what), std::move(way_out)};
}

Problem unreachable(int error) {
  if (error == EACCES || error == EPERM) {
    return problem("iceoryx's daemon runs, but this user may not use it",
                   "run both as one user, or as users of the group that its configuration names");
  }
  return problem(fmt::format("iceoryx's daemon does not run ({})", std::strerror(error)),
                 "start `iox-roudi -c FILE` first; docs/between_processes.md has a file that fits a small board");
}

// Unique on the host while this process lives, and after a crash, which leaves a socket of that name behind.
iox::RuntimeName_t runtime_name() {
  std::random_device random;
  const std::string name = fmt::format("nacelle-{}-{:08x}", ::getpid(), random());
  return iox::RuntimeName_t(iox::cxx::TruncateToCapacity, name.c_str());
}

}  // namespace

Result<Daemon*, Problem> Daemon::connect(Duration patience) {
  static Mutex mutex;
  // Once made, it stays: iceoryx cannot be started twice in a process.
  static Daemon* daemon NACELLE_GUARDED_BY(mutex) = nullptr;
  const LockGuard lock(mutex);
  if (daemon != nullptr) {
    if (daemon->is_alive()) return daemon;
    return err(problem("iceoryx's daemon is gone, or another one has taken its place", "restart this process"));
  }
  if (const int error = probe_daemon(); error != 0) return err(unreachable(error));
  daemon = new Daemon(patience);
  if (auto begun = daemon->begin(); !begun) return err(begun.error());
  Logger("transport_iceoryx").info("iceoryx's daemon answers: streams between processes may go through shared memory");
  // Before iceoryx's runtime and the log are destroyed, which were made before this.
  std::atexit([]() NACELLE_NOT_CHECKED { daemon->end(); });  // it stays as it is
  return daemon;
}

Result<void, Problem> Daemon::begin() {
  take_over_errors();
  process_ = open_daemon_process();
  wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake_ < 0) return err(problem(fmt::format("no eventfd ({})", std::strerror(errno)), ""));
  // Signals are for the program's own threads; iceoryx's inherit this one's mask.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([this] { run(); }).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);

  UniqueLock lock(mutex_);
  changed_.wait_for(lock.raw(), patience_, [this]() NACELLE_REQUIRES(mutex_) { return state_ != State::Connecting; });
  if (state_ == State::Connected) return {};
  const bool answered = state_ == State::Failed;
  state_ = State::Failed;
  return err(problem(answered ? fmt::format("iceoryx could not be started ({})", failure_)
                              : fmt::format("iceoryx's daemon has not answered within {} ms",
                                            std::chrono::duration_cast<std::chrono::milliseconds>(patience_).count()),
                     "look at the daemon's own output; then restart this process"));
}

void Daemon::run() {
  pthread_setname_np(pthread_self(), "iceoryx");
  if (!register_process()) return;
  serve();
  const LockGuard lock(mutex_);
  state_ = State::Ended;
  changed_.notify_all();
}

void Daemon::end() {
  ends_.store(true, std::memory_order_release);
  wake();
  // A thread that waits for a daemon that does not answer is left behind.
  UniqueLock lock(mutex_);
  changed_.wait_for(lock.raw(), patience_, [this]() NACELLE_REQUIRES(mutex_) { return state_ == State::Ended; });
}

void Daemon::wake() const {
  const std::uint64_t one = 1;
  static_cast<void>(!::write(wake_, &one, sizeof one));
}

bool Daemon::register_process() {
  park_this_thread_on_fatal_errors(
      [](void* context, const char* error) {
        auto& daemon = *static_cast<Daemon*>(context);
        const LockGuard lock(daemon.mutex_);
        daemon.state_ = State::Failed;
        daemon.failure_ = error;
        daemon.changed_.notify_all();
      },
      this);
  runtime_ = &iox::runtime::PoshRuntime::initRuntime(runtime_name());
  park_no_longer();
  const LockGuard lock(mutex_);
  if (state_ != State::Connecting) return false;  // too late: no thread waits any more
  state_ = State::Connected;
  alive_.store(true, std::memory_order_release);
  changed_.notify_all();
  return true;
}

void Daemon::serve() {
  while (is_alive() && !ends_.load(std::memory_order_acquire)) {
    pollfd watched[] = {{wake_, POLLIN, 0}, {process_, POLLIN, 0}};
    ::poll(watched, process_ < 0 ? 1 : 2, process_ < 0 ? kProbeEveryMs : -1);
    if (process_ >= 0 ? watched[1].revents != 0 : probe_daemon() != 0) {
      lose("its process has ended");
      break;
    }
    std::uint64_t calls = 0;
    [[maybe_unused]] const ssize_t drained = ::read(wake_, &calls, sizeof calls);
    while (true) {
      std::shared_ptr<Request> request;
      {
        const LockGuard lock(mutex_);
        if (requests_.empty()) break;
        request = requests_.front();
        requests_.pop_front();
      }
      static_cast<void>(last_error());
      void* const port = request->work(*runtime_);
      const LockGuard lock(mutex_);
      request->answer = {port, port == nullptr ? last_error() : ""};
      request->done = true;
      changed_.notify_all();
    }
  }
  if (!is_alive()) stop_greeting(*runtime_);
}

Daemon::Made Daemon::ask(std::function<void*(iox::runtime::PoshRuntime&)> work) {
  if (!is_alive()) return {nullptr, "the daemon is gone"};
  const auto request = std::make_shared<Request>(Request{std::move(work), {}, false});
  UniqueLock lock(mutex_);
  requests_.push_back(request);
  wake();
  changed_.wait_for(lock.raw(), patience_, [&]() NACELLE_REQUIRES(mutex_) { return request->done || !is_alive(); });
  if (request->done) return request->answer;
  lock.unlock();
  lose("it does not answer");
  return {nullptr, "the daemon does not answer"};
}

void Daemon::lose(const std::string& how) {
  if (!alive_.exchange(false, std::memory_order_acq_rel)) return;
  Logger("transport_iceoryx")
      .error("iceoryx's daemon is lost: {}. Its streams go over the socket until this process is restarted", how);
  const LockGuard lock(mutex_);
  changed_.notify_all();
  wake();
}

Daemon::Made Daemon::make_writer(const iox::capro::ServiceDescription& service) {
  return ask([service](iox::runtime::PoshRuntime& runtime) -> void* {
    iox::popo::PublisherOptions options;
    options.subscriberTooSlowPolicy = iox::popo::ConsumerTooSlowPolicy::DISCARD_OLDEST_DATA;
    return runtime.getMiddlewarePublisher(service, options);
  });
}

Daemon::Made Daemon::make_reader(const iox::capro::ServiceDescription& service, std::size_t depth) {
  return ask([service, depth](iox::runtime::PoshRuntime& runtime) -> void* {
    iox::popo::SubscriberOptions options;
    options.queueCapacity = depth;
    return runtime.getMiddlewareSubscriber(service, options);
  });
}

Daemon::Made Daemon::make_condition() {
  return ask([](iox::runtime::PoshRuntime& runtime) -> void* { return runtime.getMiddlewareConditionVariable(); });
}

}  // namespace nacelle::transport_iceoryx
