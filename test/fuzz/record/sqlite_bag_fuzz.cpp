// SPDX-License-Identifier: Apache-2.0
// Any bytes as a SQLite recording: nothing crashes, two readers hand over the same, and a copy of what can be read is an MCAP file with
// which nothing is wrong.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "record/model/bag_rows_reader.hpp"
#include "record/model/recording_check.hpp"
#include "record/model/recording_copy.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/sqlite_file.hpp"

namespace nacelle::record {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

class MemoryFile final : public ByteSink, public ByteSource {
 public:
  bool write(ByteView more) override {
    bytes_.insert(bytes_.end(), more.begin(), more.end());
    return true;
  }
  std::uint64_t size() const override { return bytes_.size(); }
  bool read_at(std::uint64_t offset, ByteSpan out) override {
    require(offset <= bytes_.size() && out.size() <= bytes_.size() - offset);
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return true;
  }

 private:
  Bytes bytes_;
};

bool walk(SqliteFile& bag, McapVisitor& visitor) {
  BagRowsReader reader{bag, visitor};
  while (reader.next()) {}
  return reader.is_complete();
}

void look_at(const std::string& path) {
  const auto bag = SqliteFile::open(path);
  if (!bag) return;
  RecordingSummary summary;
  const bool complete = walk(**bag, summary);
  require(complete || !summary.problems().empty());

  MemoryFile copied;
  McapWriter writer{copied, {.compression = Compression::Lz4}};
  RecordingCopy copy{writer};
  require(writer.start());
  require(walk(**bag, copy) == complete);
  require(!copy.has_failed());
  require(writer.finish());
  require(copy.messages() == summary.messages());
  const auto of_copy = RecordingCheck{copied, nullptr}.run();
  require(of_copy.problem_count == 0);
  require(of_copy.messages == copy.messages());
}

/// A file of its own for each process, since SQLite reads by name.
const std::string& path_of_process() {
  static const std::string path = "/tmp/sqlite_bag_fuzz." + std::to_string(::getpid());
  [[maybe_unused]] static const int at_end = std::atexit([] { ::unlink(path.c_str()); });
  return path;
}

}  // namespace
}  // namespace nacelle::record

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string& path = nacelle::record::path_of_process();
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  nacelle::record::require(file >= 0);
  const auto written = ::write(file, data, size);
  ::close(file);
  if (written == static_cast<ssize_t>(size)) nacelle::record::look_at(path);
  return 0;
}
