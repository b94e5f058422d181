// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "record/model/recording_summary.hpp"
#include "record/protocol/mcap_walk.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::record {

/// A topic that has another type in another recording.
struct TypeConflict {
  std::string topic;
  std::string types[2];
  std::size_t recordings[2] = {0, 0};  ///< Their places in the list.
};
/// Returns the first topic with two types, or nullopt.
[[nodiscard]] std::optional<TypeConflict> type_conflict(
    const std::vector<std::reference_wrapper<const RecordingSummary>>& all);

/// A recording that is merged with others.
struct MergeSource {
  std::function<std::unique_ptr<RecordingReader>(McapVisitor&)> open;
  std::uint64_t first = 0;     ///< As its summary says.
  std::uint64_t disorder = 0;  ///< As its summary says.
};

/// Writes the messages of several recordings into one, in the order of their log times. Messages of one time keep the order of their recording.
/// Schemas and channels that are equal are one there. Attachments are all carried over, and metadata once if they are equal.
///
/// Of each recording it holds the chunks whose time has come. Recordings with chunks out of order make it hold more, up to
/// `most_held_bytes` and one chunk: from there on messages are written before an earlier one is found, and late() counts that one.
/// Threads: one.
class RecordingMerge {
 public:
  static constexpr std::size_t kMostHeldBytes = std::size_t{256} << 20U;

  RecordingMerge(McapWriter& writer, std::vector<MergeSource> sources, std::size_t most_held_bytes = kMostHeldBytes);
  ~RecordingMerge();
  RecordingMerge(const RecordingMerge&) = delete;
  RecordingMerge& operator=(const RecordingMerge&) = delete;

  /// Writes all of them; the writer is not finished. Returns false if the writer failed or a recording could not be read to its end.
  [[nodiscard]] bool run();

  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  /// Messages that were written after a later one.
  [[nodiscard]] std::uint64_t late() const { return late_; }
  /// The most bytes of messages that were held at once.
  [[nodiscard]] std::size_t peak_bytes() const { return peak_bytes_; }

 private:
  class Stream;
  using Key = std::tuple<std::uint64_t, std::size_t, std::uint64_t>;  // log time, recording, place in it
  struct Held {
    McapMessage message;  // without its data
    Bytes data;
  };

  /// The recording that may still have a message before this time, the earliest one first; nullptr: none.
  Stream* earliest_before(std::uint64_t time);
  bool write_first();
  void hold(Key key, const McapMessage& message);

  McapWriter& writer_;
  const std::size_t most_held_bytes_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::map<Key, Held> held_;
  std::set<std::pair<std::string, std::map<std::string, std::string>>> metadata_;
  std::size_t held_bytes_ = 0, peak_bytes_ = 0;
  std::uint64_t messages_ = 0, late_ = 0, last_written_ = 0;
};

}  // namespace nacelle::record
