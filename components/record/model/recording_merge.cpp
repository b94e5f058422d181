// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_merge.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace nacelle::record {

std::optional<TypeConflict> type_conflict(const std::vector<std::reference_wrapper<const RecordingSummary>>& all) {
  std::map<std::string, std::pair<std::string, std::size_t>> known;  // topic: type, recording
  for (std::size_t at = 0; at < all.size(); ++at) {
    for (const auto& [id, topic] : all[at].get().topics()) {
      const auto& [type, recording] = known.try_emplace(topic.name, topic.type, at).first->second;
      if (type != topic.type) return TypeConflict{topic.name, {type, topic.type}, {recording, at}};
    }
  }
  return std::nullopt;
}

/// Reads one recording: messages go to those that are held, the rest is written at once.
class RecordingMerge::Stream final : private McapVisitor {
 public:
  Stream(RecordingMerge& merge, std::size_t number, MergeSource source)
      : merge_(merge), number_(number), source_(std::move(source)), earliest_(source_.first) {}

  /// No message that was not read yet is earlier.
  [[nodiscard]] std::uint64_t earliest() const { return earliest_; }
  [[nodiscard]] bool has_ended() const { return has_ended_; }

  /// Reads the next chunk or record.
  bool step() {
    if (!reader_) reader_ = source_.open(*this);
    if (!reader_->next()) {
      has_ended_ = true;
      good_ = good_ && reader_->is_complete();
      reader_.reset();
      schemas_.clear();
    }
    return good_;
  }

 private:
  struct Schema {
    std::string name, encoding, text;
  };

  void expect(bool done) { good_ = good_ && done; }

  void on_schema(const McapSchema& schema) override {
    schemas_[schema.id] = {schema.name, schema.encoding, std::string{as_text(schema.data.bytes)}};
  }
  void on_channel(const McapChannel& channel) override {
    std::optional<std::uint16_t> schema_id{0};
    if (channel.schema_id != 0) {
      const Schema& schema = schemas_[channel.schema_id];
      schema_id = merge_.writer_.add_schema(schema.name, schema.encoding, schema.text);
    }
    const auto id =
        !schema_id ? std::nullopt
                   : merge_.writer_.add_channel(*schema_id, channel.topic, channel.message_encoding, channel.metadata);
    expect(id.has_value());
    if (id) channels_[channel.id] = *id;
  }
  void on_message(const McapMessage& message, const McapSpot&) override {
    const auto channel = channels_.find(message.channel_id);
    if (channel == channels_.end()) return;
    latest_ = std::max(latest_, message.log_time);
    earliest_ = std::max(earliest_, latest_ - std::min(latest_, source_.disorder));
    McapMessage of_file = message;
    of_file.channel_id = channel->second;
    merge_.hold({message.log_time, number_, place_++}, of_file);
  }
  void on_attachment(const McapAttachment& attachment, const McapSpot&) override {
    expect(merge_.writer_.write_attachment(attachment));
  }
  void on_metadata(const McapMetadata& metadata, const McapSpot&) override {
    if (merge_.metadata_.emplace(metadata.name, metadata.metadata).second)
      expect(merge_.writer_.write_metadata(metadata));
  }
  void on_problem(const McapProblem&) override { good_ = false; }

  RecordingMerge& merge_;
  const std::size_t number_;
  const MergeSource source_;
  std::unique_ptr<RecordingReader> reader_;
  std::map<std::uint16_t, Schema> schemas_;          // by their ids there
  std::map<std::uint16_t, std::uint16_t> channels_;  // ids there and here
  std::uint64_t earliest_, latest_ = 0, place_ = 0;
  bool has_ended_ = false, good_ = true;
};

RecordingMerge::RecordingMerge(McapWriter& writer, std::vector<MergeSource> sources, std::size_t most_held_bytes)
    : writer_(writer), most_held_bytes_(most_held_bytes) {
  for (auto& source : sources) streams_.push_back(std::make_unique<Stream>(*this, streams_.size(), std::move(source)));
}

RecordingMerge::~RecordingMerge() = default;

void RecordingMerge::hold(Key key, const McapMessage& message) {
  const ByteView data = message.data.bytes;
  Held& held = held_[key];
  held.message = message;
  held.message.data = {};
  held.data.assign(data.begin(), data.end());
  held_bytes_ += data.size() + sizeof(Held);
  peak_bytes_ = std::max(peak_bytes_, held_bytes_);
}

RecordingMerge::Stream* RecordingMerge::earliest_before(std::uint64_t time) {
  Stream* found = nullptr;
  for (const auto& stream : streams_) {
    if (stream->has_ended() || stream->earliest() > time) continue;
    if (found == nullptr || stream->earliest() < found->earliest()) found = stream.get();
  }
  return found != nullptr && (held_.empty() || found->earliest() < time) ? found : nullptr;
}

bool RecordingMerge::write_first() {
  auto first = held_.extract(held_.begin());
  Held& held = first.mapped();
  held.message.data = {held.data};
  if (messages_ > 0 && held.message.log_time < last_written_) ++late_;
  last_written_ = std::max(last_written_, held.message.log_time);
  held_bytes_ -= held.data.size() + sizeof(Held);
  ++messages_;
  return writer_.write(held.message);
}

bool RecordingMerge::run() {
  for (;;) {
    const bool is_full = !held_.empty() && held_bytes_ >= most_held_bytes_;
    const std::uint64_t next =
        held_.empty() ? std::numeric_limits<std::uint64_t>::max() : std::get<0>(held_.begin()->first);
    Stream* const stream = is_full ? nullptr : earliest_before(next);
    if (stream != nullptr) {
      if (!stream->step()) return false;
    } else if (held_.empty()) {
      return true;
    } else if (!write_first()) {
      return false;
    }
  }
}

}  // namespace nacelle::record
