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

/// This process's connection to iox-roudi: one, for the life of the process, as iceoryx has it.
///
/// Whatever asks the daemon for something runs on one thread, and is waited for with a bound: iceoryx itself waits up to a
/// minute for a daemon that is not there, and for ever for one that has stopped answering. The same thread learns when the
/// daemon's process ends.
/// Threads: any. Never destroyed: its threads may outlive main().
class Daemon {
 public:
  /// Connects if that has not been done. Errors: see IceoryxCarrier::start().
  [[nodiscard]] static Result<Daemon*, Problem> connect(Duration patience);

  /// False forever once the daemon has ended.
  [[nodiscard]] bool is_alive() const { return alive_.load(std::memory_order_acquire); }

  /// What the daemon makes for this process; null with a reason. The port is the caller's to destroy.
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
  std::atomic<bool> ends_{false};                 // the program does
  iox::runtime::PoshRuntime* runtime_ = nullptr;  // the thread's own
  int process_ = -1;                              // the daemon's pidfd; -1: it is not known, and asked now and then
  int wake_ = -1;                                 // an eventfd: there are requests
  Mutex mutex_;
  std::condition_variable changed_;
  enum class State : std::uint8_t { Connecting, Connected, Failed, Ended };
  State state_ NACELLE_GUARDED_BY(mutex_) = State::Connecting;
  std::string failure_ NACELLE_GUARDED_BY(mutex_);
  std::deque<std::shared_ptr<Request>> requests_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::transport_iceoryx
