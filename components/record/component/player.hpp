// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/node/generic_topics.hpp"
#include "record/component/open_recording.hpp"

namespace nacelle::record {

/// What a player has done so far.
struct PlayerFigures {
  double seconds = 0.0;  ///< Of the recording, from the first message that is played.
  std::uint64_t messages = 0;
  std::uint64_t unread = 0;     ///< Had no reader, so that they were not even decoded.
  std::uint64_t undecoded = 0;  ///< Are no message of their type.
  bool has_ended = false;
};

/// Publishes the messages of a recording on a thread of its own, with the time between them that they were recorded with.
///
/// It decodes a message only if its topic has a reader, or keeps messages for late readers.
/// Threads: construct and destroy on the component's executor; the other functions on any.
class Player {
 public:
  struct Topic {
    const msgs::MessageType* type = nullptr;
    Writer* writer = nullptr;  ///< Null: it is not played. Outlives the player, which alone uses it meanwhile.
    bool keeps = false;        ///< For late readers.
  };
  /// Times are nanoseconds since the Unix epoch, as recorded.
  struct Options {
    std::uint64_t from = 0, to = 0;  ///< Both included.
    double rate = 1.0;
    bool loops = false, starts_paused = false;
    Duration clock_period{};                           ///< Between calls of publish_clock; zero: none.
    std::function<void(WallTime)> publish_clock = {};  ///< On the player's thread.
  };
  Player(OpenRecording recording, std::vector<Topic> topics, Options options, const Clock& clock);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  void pause(bool is_paused);
  [[nodiscard]] bool is_paused() const;
  /// Errors: false for a rate that is not above 0, which changes nothing.
  bool set_rate(double rate);
  [[nodiscard]] double rate() const;
  /// Publishes the next message while it is paused. Returns false if it is not, or has ended.
  bool play_next();
  /// Continues at a time of the recording. Returns false outside of what is played.
  bool seek(std::uint64_t time);
  [[nodiscard]] PlayerFigures figures() const;

 private:
  enum class Turn : std::uint8_t { Play, Seek, Stop };
  void run();
  [[nodiscard]] Turn wait_for(std::uint64_t time);
  void publish(const OrderedMessages::Message& message);
  void rebase(std::uint64_t time) NACELLE_REQUIRES(mutex_);
  [[nodiscard]] std::uint64_t position() const NACELLE_REQUIRES(mutex_);

  const OpenRecording recording_;  // the thread's
  const std::vector<Topic> topics_;
  const Options options_;
  const Clock& clock_;
  MonotonicTime clock_due_{};  // the thread's

  mutable Mutex mutex_;
  std::condition_variable changed_;
  double rate_ NACELLE_GUARDED_BY(mutex_);
  bool is_paused_ NACELLE_GUARDED_BY(mutex_), is_ending_ NACELLE_GUARDED_BY(mutex_) = false;
  std::uint64_t steps_ NACELLE_GUARDED_BY(mutex_) = 0;
  std::optional<std::uint64_t> seeks_ NACELLE_GUARDED_BY(mutex_);
  // At this instant, this time of the recording was played.
  MonotonicTime base_ NACELLE_GUARDED_BY(mutex_);
  std::uint64_t base_time_ NACELLE_GUARDED_BY(mutex_) = 0;
  PlayerFigures figures_ NACELLE_GUARDED_BY(mutex_);
  std::thread thread_;  // last: it starts when everything above is there
};

}  // namespace nacelle::record
