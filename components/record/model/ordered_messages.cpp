// SPDX-License-Identifier: Apache-2.0
#include "record/model/ordered_messages.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::record {
namespace {

constexpr std::size_t kMostProblems = 100;
constexpr std::uint64_t kMostHeld = std::uint64_t{1} << 30U;

}  // namespace

/// One file: what its summary says, and the messages of a chunk that is read.
class OrderedMessages::File final : public McapVisitor {
 public:
  File(OrderedMessages& owner, std::size_t number, ByteSource& source)
      : owner_(owner), number_(number), parts_(source, *this) {}

  [[nodiscard]] bool read_summary() {
    bool is_read = parts_.read_summary();
    if (is_read && footer_.summary_start == 0) is_read = scan();
    if (is_read && !has_chunks_ && statistics_.message_count > 0) {
      // Messages may stand outside chunks; then they are read at once.
      const std::uint64_t end = footer_.summary_start == 0 ? footer_at_ : footer_.summary_start;
      owner_.chunks_.push_back(
          {statistics_.message_start_time, statistics_.message_end_time, number_, kBegin, end - std::min(end, kBegin)});
    }
    note_statistics();
    reads_summary_ = false;
    return is_read && !has_problem_;
  }
  void read(const Chunk& chunk) {
    chunk_ = {new Bytes, [this](Bytes* bytes) {
                owner_.held_ -= bytes->size();
                delete bytes;
              }};
    static_cast<void>(parts_.read(chunk.offset, chunk.length));
    owner_.held_ += chunk_->size();
    for (Waiting& one : found_) {
      one.bytes = chunk_;
      owner_.waiting_.push(std::move(one));
    }
    found_.clear();
    chunk_.reset();
  }

  void on_schema(const McapSchema& schema) override {
    schemas_[schema.id] = {schema.name, schema.encoding, std::string{as_text(schema.data.bytes)}};
  }
  void on_channel(const McapChannel& channel) override {
    Topic topic{channel.topic, "", channel.message_encoding, "", "", channel.metadata};
    if (channel.schema_id != 0) {
      const Schema& schema = schemas_[channel.schema_id];
      topic.type = schema.name;
      topic.schema_encoding = schema.encoding;
      topic.definition = schema.text;
    }
    topics_[channel.id] = owner_.topic_of(std::move(topic));
  }
  void on_chunk_index(const McapChunkIndex& index) override {
    has_chunks_ = true;
    if (index.message_index_offsets.empty() && index.message_start_time == 0 && index.message_end_time == 0) return;
    owner_.chunks_.push_back(
        {index.message_start_time, index.message_end_time, number_, index.chunk_start_offset, index.chunk_length});
  }
  void on_footer(const McapFooter& footer, const McapSpot& spot) override {
    footer_ = footer;
    footer_at_ = spot.offset;
  }
  void on_statistics(const McapStatistics& statistics) override { statistics_ = statistics; }
  void on_chunk(const McapChunk& chunk, const McapSpot& spot) override {
    if (is_scanning_)
      scanned_.push_back({chunk.message_start_time, chunk.message_end_time, number_, spot.offset, spot.length});
  }
  void on_message(const McapMessage& message, const McapSpot& spot) override {
    if (is_scanning_) return count(message, spot);
    if (!chunk_ || message.log_time < owner_.from_) return;
    const ByteView data = message.data.bytes;
    found_.push_back({message.log_time, owner_.numbered_++, nullptr, chunk_->size(), data.size(),
                      topics_[message.channel_id], message.publish_time, message.sequence});
    chunk_->insert(chunk_->end(), data.begin(), data.end());
  }
  void on_problem(const McapProblem& problem) override {
    has_problem_ = has_problem_ || reads_summary_;
    owner_.note_problem(number_, problem);
  }

 private:
  struct Schema {
    std::string name, encoding, text;
  };
  static constexpr std::uint64_t kBegin = sizeof kMcapMagic;

  /// Reads the whole file, to know what a summary would say.
  bool scan() {
    is_scanning_ = true;
    const bool is_read = parts_.read(kBegin, footer_at_ - std::min(footer_at_, kBegin));
    is_scanning_ = false;
    has_chunks_ = !is_outside_ && !scanned_.empty();
    if (has_chunks_) owner_.chunks_.insert(owner_.chunks_.end(), scanned_.begin(), scanned_.end());
    return is_read;
  }
  void count(const McapMessage& message, const McapSpot& spot) {
    is_outside_ = is_outside_ || scanned_.empty() || scanned_.back().offset != spot.offset;
    McapStatistics& all = statistics_;
    const bool is_first = all.message_count++ == 0;
    all.message_start_time = is_first ? message.log_time : std::min(all.message_start_time, message.log_time);
    all.message_end_time = std::max(all.message_end_time, message.log_time);
  }
  void note_statistics() {
    owner_.messages_ += statistics_.message_count;
    if (statistics_.message_count == 0) return;
    const auto begin = statistics_.message_start_time;
    owner_.first_ = owner_.first_ != 0 ? std::min(owner_.first_, begin) : begin;
    owner_.last_ = std::max(owner_.last_, statistics_.message_end_time);
  }

  OrderedMessages& owner_;
  const std::size_t number_;
  McapParts parts_;
  bool reads_summary_ = true, has_problem_ = false;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, std::size_t> topics_;
  std::shared_ptr<Bytes> chunk_;
  std::vector<Waiting> found_;
  McapStatistics statistics_;
  McapFooter footer_;
  std::uint64_t footer_at_ = 0;
  std::vector<Chunk> scanned_;
  bool has_chunks_ = false, is_scanning_ = false, is_outside_ = false;
};

OrderedMessages::~OrderedMessages() = default;

Result<std::unique_ptr<OrderedMessages>, OrderedMessages::FileProblem> OrderedMessages::open(
    const std::vector<ByteSource*>& files) {
  std::unique_ptr<OrderedMessages> made{new OrderedMessages};
  for (ByteSource* const source : files) {
    made->files_.push_back(std::make_unique<File>(*made, made->files_.size(), *source));
    if (!made->files_.back()->read_summary()) return err(made->problems_.front());
  }
  std::stable_sort(made->chunks_.begin(), made->chunks_.end(),
                   [](const Chunk& a, const Chunk& b) { return a.start < b.start; });
  return made;
}

void OrderedMessages::note_problem(std::size_t file, const McapProblem& problem) {
  if (problems_.size() < kMostProblems) problems_.push_back({file, problem});
}

std::size_t OrderedMessages::topic_of(Topic topic) {
  const auto known = std::find(topics_.begin(), topics_.end(), topic);
  if (known != topics_.end()) return static_cast<std::size_t>(known - topics_.begin());
  topics_.push_back(std::move(topic));
  return topics_.size() - 1;
}

void OrderedMessages::load_until(std::uint64_t time) {
  for (; next_chunk_ < chunks_.size() && chunks_[next_chunk_].start <= time; ++next_chunk_) {
    const Chunk& chunk = chunks_[next_chunk_];
    if (chunk.end < from_) continue;
    if (held_ > kMostHeld) {
      note_problem(chunk.file, {McapFault::TooLarge, chunk.offset, "chunks of one time have more than 1 GiB together"});
      continue;
    }
    files_[chunk.file]->read(chunk);
  }
}

const OrderedMessages::Message* OrderedMessages::next() {
  while (waiting_.empty() && next_chunk_ < chunks_.size()) load_until(chunks_[next_chunk_].start);
  if (waiting_.empty()) return nullptr;
  load_until(waiting_.top().log_time);
  current_ = waiting_.top();
  waiting_.pop();
  message_ = {current_.topic, current_.log_time, current_.publish_time, current_.sequence,
              ByteView{*current_.bytes}.subspan(current_.offset, current_.size)};
  return &message_;
}

void OrderedMessages::seek(std::uint64_t time) {
  waiting_ = {};
  next_chunk_ = 0;
  from_ = time;
}

}  // namespace nacelle::record
