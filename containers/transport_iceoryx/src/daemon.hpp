// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "iceoryx_posh/runtime/posh_runtime.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::transport_iceoryx {

/// The connection of this process to iox-roudi. iceoryx allows one, for the life of the process.
///
/// All requests to the daemon run on one thread, and callers wait for them with a time limit: iceoryx itself waits up
/// to a minute for a daemon that does not run, and forever for one that does not answer. If a request exceeds the
/// limit, the connection counts as lost. The same thread detects the end of the daemon's process.
/// Threads: any. Never destroyed: its thread may outlive main().
class Daemon {
 public:
  /// Returns the connection, and connects at the first call. The `patience` of that call is also the limit of later
  /// requests. Errors: see IceoryxCarrier::start().
  [[nodiscard]] static Result<Daemon*, Problem> connect(Duration patience);

  /// Returns false from the loss of the daemon on; there is no reconnection.
  [[nodiscard]] bool is_alive() const { return alive_.load(std::memory_order_acquire); }

  /// A port that the daemon has made. The caller destroys it. Null: refused, with the reason in `why`.
  struct Made {
    void* port = nullptr;
    std::string why;
  };
  [[nodiscard]] Made make_writer(const iox::capro::ServiceDescription& service);
  [[nodiscard]] Made make_reader(const iox::capro::ServiceDescription& service, std::size_t depth);
  [[nodiscard]] Made make_condition();

 private:
  struct Request {
    std::function<void*(iox::runtime::PoshRuntime&)> work;
    Made answer;
    bool done = false;
  };
  explicit Daemon(Duration patience) : patience_(patience) {}
  Result<void, Problem> begin();
  void run();
  bool register_process();
  void serve();
  Made ask(std::function<void*(iox::runtime::PoshRuntime&)> work);
  void lose(const std::string& how);
  void end();
  void wake() const;

  const Duration patience_;
  std::atomic<bool> alive_{false};
  std::atomic<bool> ends_{false};                 // main() has returned
  iox::runtime::PoshRuntime* runtime_ = nullptr;  // used by the thread only
  int process_ = -1;                              // the daemon's pidfd; -1: unknown, so its socket is polled
  int wake_ = -1;                                 // an eventfd that signals new requests
  Mutex mutex_;
  std::condition_variable changed_;
  enum class State : std::uint8_t { Connecting, Connected, Failed, Ended };
  State state_ NACELLE_GUARDED_BY(mutex_) = State::Connecting;
  std::string failure_ NACELLE_GUARDED_BY(mutex_);
  std::deque<std::shared_ptr<Request>> requests_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::transport_iceoryx
