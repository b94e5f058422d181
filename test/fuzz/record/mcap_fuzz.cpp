// SPDX-License-Identifier: Apache-2.0
// Any bytes as an MCAP file: nothing crashes, what the walk hands over is counted by all readers alike, and a copy of what can be read is
// a file with which nothing is wrong.
#include <cstdlib>
#include <cstring>
#include <optional>

#include "record/model/ordered_messages.hpp"
#include "record/model/recording_check.hpp"
#include "record/model/recording_copy.hpp"
#include "record/model/recording_summary.hpp"

namespace nacelle::record {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

class MemoryFile final : public ByteSink, public ByteSource {
 public:
  explicit MemoryFile(Bytes content = {}) : bytes_(std::move(content)) {}
  bool write(ByteView more) override {
    bytes_.insert(bytes_.end(), more.begin(), more.end());
    return true;
  }
  std::uint64_t size() const override { return bytes_.size(); }
  bool read_at(std::uint64_t offset, ByteSpan out) override {
    require(offset <= bytes_.size() && out.size() <= bytes_.size() - offset);  // it asks for nothing beyond the end
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
    return true;
  }

 private:
  Bytes bytes_;
};

/// The number of messages in the order of their times; nothing if the file has no end.
std::optional<std::uint64_t> ordered(MemoryFile& file) {
  const auto made = OrderedMessages::open({&file});
  if (!made) return std::nullopt;
  std::uint64_t count = 0;
  const auto topics = (*made)->topics().size();
  for (; count < 100'000; ++count) {  // indexes may name a chunk again and again
    const auto* const message = (*made)->next();
    if (message == nullptr) break;
    require(message->topic < topics);
  }
  return count;
}

void look_at(MemoryFile file) {
  ordered(file);

  RecordingSummary summary;
  const bool complete = walk_mcap(file, summary);
  const auto report = RecordingCheck{file, nullptr}.run();
  require(report.complete == complete);
  require(report.messages == summary.messages());
  require(report.problem_count >= summary.problems().size());

  MemoryFile copied;
  McapWriter writer{copied, {.compression = Compression::Lz4}};
  RecordingCopy copy{writer};
  require(writer.start());
  walk_mcap(file, copy);
  require(!copy.has_failed());
  require(writer.finish());
  require(copy.messages() == summary.messages());
  const auto of_copy = RecordingCheck{copied, nullptr}.run();
  require(of_copy.problem_count == 0);
  require(of_copy.messages == copy.messages());
  require(ordered(copied) == copy.messages());
}

}  // namespace
}  // namespace nacelle::record

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  nacelle::record::look_at(nacelle::record::MemoryFile{nacelle::Bytes(data, data + size)});
  return 0;
}
