// SPDX-License-Identifier: Apache-2.0
#include "record/port/recording_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <limits>
#include <system_error>

#include "nacelle/base/file_fault.hpp"

namespace nacelle::record {
namespace {

std::string words_of(int error) { return std::generic_category().message(error); }

Problem problem_of(const std::string& path, int error, FileFault otherwise, const char* what) {
  return {Place{path, 0}, fmt::format("{}: {}", what, words_of(error)), "", file_fault_of(error, otherwise)};
}

}  // namespace

Result<std::unique_ptr<FileSource>, Problem> FileSource::open(const std::string& path) {
  // O_NONBLOCK: a FIFO without a writer would wait for one.
  io::Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  struct stat status {};
  if (!file.is_open() || ::fstat(file.number(), &status) != 0)
    return err(problem_of(path, errno, FileFault::Unreadable, "cannot be read"));
  if (!S_ISREG(status.st_mode))
    return err(Problem{Place{path, 0}, "is no file", "name a recording", FileFault::NotRegular});
  return std::make_unique<FileSource>(std::move(file), static_cast<std::uint64_t>(status.st_size));
}

bool FileSource::read_at(std::uint64_t offset, ByteSpan out) {
  while (!out.empty()) {
    const auto count = ::pread(file_.number(), out.data(), out.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return true;
}

Result<std::unique_ptr<FileSink>, Problem> FileSink::create(const std::string& path) {
  io::Descriptor file{::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)};
  if (file.is_open()) return std::make_unique<FileSink>(std::move(file), path);
  if (errno == EEXIST)
    return err(Problem{Place{path, 0}, "exists already", "remove it, or name another file", FileFault::Unwritable});
  return err(problem_of(path, errno, FileFault::Unwritable, "cannot be made"));
}

bool FileSink::write(ByteView bytes) {
  while (!bytes.empty()) {
    const auto count = ::write(file_.number(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      error_ = count < 0 ? errno : ENOSPC;
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    written_ += count;
  }
  return true;
}

// Fails where there is no disk (a pipe); a sync says what there is to say.
void FileSink::start_writeback() {
  static_cast<void>(::sync_file_range(file_.number(), started_, written_ - started_, SYNC_FILE_RANGE_WRITE));
  started_ = written_;
}

bool FileSink::sync() {
  // A pipe has nothing to sync, and says so.
  if (::fdatasync(file_.number()) == 0 || errno == EINVAL) return true;
  error_ = errno;
  return false;
}

std::uint64_t FileSink::free_bytes() const {
  struct statvfs status {};
  if (::fstatvfs(file_.number(), &status) != 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

Problem FileSink::problem() const { return problem_of(path_, error_, FileFault::Unwritable, "cannot be written"); }

}  // namespace nacelle::record
