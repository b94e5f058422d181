// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/node/generic_topics.hpp"
#include "record/component/message_log.hpp"
#include "record/component/recorder_figures.hpp"
#include "record/model/topic_choice.hpp"

namespace nacelle::record {

/// Records the topics of a container on a thread of its own, which shares the publishers' messages and encodes each once. New publishers are
/// found while it records.
///
/// The robot's description (URDF), as the first publisher of a topic robot_description has it, is attached, chosen or not.
/// A message in a device's memory (an image that a camera's driver lends) is the only one that is held of its topic: it is encoded before another one
/// is queued, and what is published meanwhile is lost in the queue.
/// A topic is read best_effort if one of its publishers is, and with its history if all of its publishers keep one.
/// Threads: construct and destroy on the component's executor; the other functions on any. Allocates: for new topics and chunks.
class Recorder final : private GraphListener {
 public:
  struct Options {
    TopicChoice choice;
    bool starts_paused = false;
    /// Called each time that the thread has taken messages, several times a second at least, on that thread. Empty: nothing is called.
    std::function<void(MonotonicTime now)> on_round{};
    /// Called on that thread for each message that sets an emergency stop which a component here reads, chosen or not. Empty: they are not read.
    std::function<void(const std::string& topic)> on_stop{};
    /// Called on that thread when the log has continued in another file.
    std::function<void(const std::string& closed, const std::string& opened)> on_split{};
  };
  /// `on_end`: the log ended by itself; called once, on the recorder's thread. What the topics are of outlives the recorder.
  Recorder(GenericTopics topics, Options options, std::unique_ptr<MessageLog> log,
           std::function<void(const Problem&)> on_end);
  /// Ends the recording as stop() does.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Takes what is in the queues, completes the recording and waits for the disk. Returns what went wrong at that. A second call does
  /// nothing.
  std::optional<Problem> stop();
  /// Messages that come while it is paused are not recorded, and do not count as lost. Topics whose publishers keep their messages for late
  /// readers are recorded all the same.
  void pause(bool is_paused) { is_paused_ = is_paused; }
  [[nodiscard]] bool is_paused() const { return is_paused_; }
  /// Continues in another file.
  void split();
  /// Runs a job on the recorder's thread, between messages: it may use the log. Returns false if the thread has ended; the job is dropped then,
  /// as one that waits when it ends.
  bool post(std::function<void()> job);
  /// Records a topic that only programs outside of this container use, as of this type. When somebody here reads or writes it with another
  /// type, it is left to that one. The type lives until the process ends.
  void add_remote(const std::string& topic, const msgs::MessageType& type, const std::vector<QoS>& offered);
  [[nodiscard]] RecorderFigures figures() const;

 private:
  using Key = std::pair<std::string, const msgs::MessageType*>;
  struct Stream;
  struct Change {
    std::uint64_t endpoint = 0;
    std::optional<EndpointInfo> made;  // not set: it is gone
  };
  void on_made(const EndpointInfo& endpoint) noexcept override;
  void on_gone(std::uint64_t id) noexcept override;
  void on_gate(std::uint64_t, bool) noexcept override {}
  void on_life(std::uint64_t) noexcept override {}
  void on_left(std::uint64_t) noexcept override {}

  void run();
  [[nodiscard]] bool wait();
  void take_changes();
  void run_jobs();
  void tell_split();
  void look_for_description(const EndpointInfo& endpoint);
  void take_description(Stream& stream);
  void look_for_stop(const EndpointInfo& endpoint);
  void forget_stop_reader(std::uint64_t reader);
  void take_stops(Stream& stream);
  [[nodiscard]] bool is_left(const Key& key) const;
  void note_end(const EndpointInfo& endpoint);
  void read(const Key& key);
  void read(const Key& key, std::vector<QoS> offered);
  void take_messages(Stream& stream);
  void record(Stream& stream, Block& block);
  void close_reader(Stream& stream);
  void note_figures();
  void note_ready(Stream& stream) noexcept;

  GenericTopics topics_;
  const Options options_;
  const std::function<void(const Problem&)> on_end_;
  std::unique_ptr<MessageLog> log_;  // of the thread until it has ended
  MonotonicTime begun_;
  std::atomic<bool> is_paused_;

  mutable Mutex mutex_;
  std::condition_variable changed_;
  std::vector<Change> changes_ NACELLE_GUARDED_BY(mutex_);
  std::vector<Stream*> ready_ NACELLE_GUARDED_BY(mutex_);
  std::vector<std::function<void()>> jobs_ NACELLE_GUARDED_BY(mutex_);
  bool is_sleeping_ NACELLE_GUARDED_BY(mutex_) = false, is_ending_ NACELLE_GUARDED_BY(mutex_) = false;
  RecorderFigures figures_ NACELLE_GUARDED_BY(mutex_);

  // The thread's own.
  std::map<std::uint64_t, std::pair<Key, QoS>> writers_;
  std::map<std::uint64_t, Key> ends_;  // of the container's own, but for the recorder's
  std::set<Key> remote_;               // see add_remote()
  std::map<Key, std::unique_ptr<Stream>> streams_;
  std::map<Key, std::unique_ptr<Stream>> stops_;         // emergency stops
  std::map<std::uint64_t, Key> stop_readers_;            // of others
  std::map<Key, std::unique_ptr<Stream>> descriptions_;  // robot descriptions, whose first text is attached
  std::vector<std::function<void()>> jobs_now_;
  std::vector<Change> changes_now_;
  std::vector<Stream*> ready_now_;
  MonotonicTime figures_due_{};
  std::string file_;  // of the log

  std::unique_ptr<GraphWatchHandle> graph_;
  std::thread thread_;
};

}  // namespace nacelle::record
