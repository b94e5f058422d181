// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <thread>

#include "iceoryx_posh/internal/popo/building_blocks/condition_variable_data.hpp"
#include "nacelle/base/mutex.hpp"
#include "reader.hpp"

namespace nacelle::transport_iceoryx {

/// A thread that sleeps until a chunk arrives for one of its readers, and calls that reader's deliver().
///
/// It replaces iceoryx's Listener, with three differences. The condition variable is allocated and checked by the
/// caller; a Listener uses a null pointer if the daemon has none left. No lock is held while a reader is called. Only
/// the flags of places that were ever in use are checked, not all 256, which take 3,900 of the 11,400 instructions that
/// a message costs with a Listener (counted with callgrind).
/// The protocol is iceoryx's: a sender sets the reader's flag, then posts the semaphore. So if a flag is set after it
/// was checked, a post follows and no message is missed.
/// Threads: any; readers are called on the own thread.
class ReadingThread {
 public:
  static constexpr std::size_t kMostReaders = iox::MAX_NUMBER_OF_NOTIFIERS;

  explicit ReadingThread(iox::popo::ConditionVariableData& condition);
  ReadingThread(const ReadingThread&) = delete;
  ReadingThread& operator=(const ReadingThread&) = delete;
  ~ReadingThread();

  /// Registers a reader and returns its place; nothing if all places are taken.
  [[nodiscard]] std::optional<std::size_t> add(const std::shared_ptr<StreamReader>& reader);
  void remove(std::size_t place);
  [[nodiscard]] iox::popo::ConditionVariableData& condition() { return condition_; }

 private:
  void run();
  void look_at(std::size_t place);

  iox::popo::ConditionVariableData& condition_;
  std::atomic<bool> ends_{false};
  std::atomic<std::size_t> places_{0};  // one more than the highest place that was ever taken
  Mutex mutex_;
  std::array<std::shared_ptr<StreamReader>, kMostReaders> readers_ NACELLE_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace nacelle::transport_iceoryx
