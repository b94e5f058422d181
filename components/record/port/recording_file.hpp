// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/io/descriptor.hpp"
#include "record/model/byte_file.hpp"

namespace nacelle::record {

/// A regular file that is read by offsets. One that shrinks meanwhile gives short reads, which fail.
///
/// Threads: one. Errors of open: a FileFault; `where` is the path.
class FileSource final : public ByteSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<FileSource>, Problem> open(const std::string& path);
  FileSource(io::Descriptor file, std::uint64_t size) : file_(std::move(file)), size_(size) {}

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] bool read_at(std::uint64_t offset, ByteSpan out) override;

 private:
  const io::Descriptor file_;
  const std::uint64_t size_;
};

/// A new file that is written from its start to its end.
///
/// Threads: one. Errors of create: a FileFault; `where` is the path. A file that exists is never overwritten.
class FileSink final : public ByteSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<FileSink>, Problem> create(const std::string& path);
  FileSink(io::Descriptor file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}

  [[nodiscard]] bool write(ByteView bytes) override;
  /// Has the kernel write to the disk what was written since the last call, without waiting for it: a sync has little left then.
  void start_writeback();
  /// Waits until the disk has all that was written. Errors: false.
  [[nodiscard]] bool sync();
  /// Returns how many bytes an ordinary user may still write to the file system; the largest number if it does not say.
  [[nodiscard]] std::uint64_t free_bytes() const;
  /// A write or a sync failed.
  [[nodiscard]] bool has_failed() const { return error_ != 0; }
  /// Returns why the last write or sync failed.
  [[nodiscard]] Problem problem() const;

 private:
  const io::Descriptor file_;
  const std::string path_;
  std::int64_t written_ = 0, started_ = 0;  // bytes
  int error_ = 0;                           // errno
};

}  // namespace nacelle::record
