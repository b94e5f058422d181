// SPDX-License-Identifier: Apache-2.0
// Any bytes as the files of a ring that a killed process left: nothing crashes, and what is written is a recording with which nothing is wrong,
// or it is refused and no folder stays. The bytes are files behind each other, each with its length in two bytes before it.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "record/component/ring.hpp"
#include "record/component/snapshot.hpp"
#include "record/model/recording_check.hpp"
#include "record/port/recording_file.hpp"

namespace nacelle::record {
namespace {

constexpr std::size_t kMostFiles = 8;

void require(bool holds) {
  if (!holds) std::abort();
}

/// A folder of its own for each process.
const std::string& folder_of_process() {
  static const std::string path = "/dev/shm/ring_fuzz." + std::to_string(::getpid());
  [[maybe_unused]] static const bool is_made = std::filesystem::create_directory(path);
  [[maybe_unused]] static const int at_end = std::atexit([] { std::filesystem::remove_all(path); });
  return path;
}

std::string write(const std::string& path, ByteView bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  require(file >= 0);
  const auto written = ::write(file, bytes.data(), bytes.size());
  ::close(file);
  require(written == static_cast<ssize_t>(bytes.size()));
  return path;
}

void look_at(ByteView bytes) {
  const std::string& folder = folder_of_process();
  std::vector<std::string> files;
  while (bytes.size() > 2 && files.size() < kMostFiles) {
    const std::size_t length = std::min<std::size_t>(bytes[0] | std::size_t{bytes[1]} << 8U, bytes.size() - 2);
    const std::uint64_t number = files.size();
    // The first one is a kept message of the second one's chunk, or of none.
    const std::string name = number == 0 ? kept_name(0, bytes[0] & 1U) : chunk_name(number);
    files.push_back(write(folder + "/" + name, bytes.subspan(2, length)));
    bytes = bytes.subspan(2 + length);
  }
  const std::string bag = folder + "/bag";
  const auto made = write_snapshot({.files = files, .folder = bag, .reason = "any bytes"});
  if (made) {
    require(made->folder == bag);
    auto source = FileSource::open(bag + "/bag_0.mcap");
    require(source.has_value());
    const auto report = RecordingCheck{**source, nullptr}.run();
    require(report.complete && report.problem_count == 0 && report.messages == made->messages);
    require(std::filesystem::exists(bag + "/metadata.yaml"));
  }
  for (const auto& file : files) ::unlink(file.c_str());
  require((std::filesystem::remove_all(bag) > 0) == made.has_value());
}

}  // namespace
}  // namespace nacelle::record

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  nacelle::record::look_at({data, size});
  return 0;
}
