// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::record {

class RingFolder;

/// A file of a ring. It is removed with the last reference to it; a process that is killed leaves it.
class RingFile {
 public:
  RingFile(std::shared_ptr<RingFolder> folder, std::string path, std::uint64_t bytes);
  ~RingFile();
  RingFile(const RingFile&) = delete;
  RingFile& operator=(const RingFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  const std::shared_ptr<RingFolder> folder_;  // goes after its files
  const std::string path_;
  const std::uint64_t bytes_;
};

/// A folder in memory (/dev/shm) with the files of one ring.
///
/// Its name ends in random letters, it belongs to this user, and nobody else can look into it (mode 0700). It is locked while the process
/// lives, so that another one can tell what a killed process left. It goes when it is empty.
/// Threads: any.
class RingFolder : public std::enable_shared_from_this<RingFolder> {
 public:
  /// `base`: "/dev/shm". Errors: a FileFault; `where` is the base.
  [[nodiscard]] static Result<std::shared_ptr<RingFolder>, Problem> make(const std::string& base,
                                                                         const std::string& name);
  /// Returns the folders of this name that no living process holds, and locks them. Those of other users, symbolic links, and folders into which
  /// others may write are ignored: this process did not make them.
  [[nodiscard]] static std::vector<std::shared_ptr<RingFolder>> left_behind(const std::string& base,
                                                                            const std::string& name);
  RingFolder(io::Descriptor folder, std::string path) : folder_(std::move(folder)), path_(std::move(path)) {}
  ~RingFolder();
  RingFolder(const RingFolder&) = delete;
  RingFolder& operator=(const RingFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Writes a new file (mode 0600). Errors: a FileFault, NoRoom if the memory is full; nothing is left then.
  [[nodiscard]] Result<std::shared_ptr<RingFile>, Problem> add(const std::string& name, ByteView bytes);
  /// Returns the paths of the regular files in it.
  [[nodiscard]] std::vector<std::string> files() const;
  /// Returns their bytes.
  [[nodiscard]] std::uint64_t bytes() const;
  /// Removes all of them.
  void clear();
  /// Returns how many bytes the file system takes.
  [[nodiscard]] std::uint64_t free_bytes() const;

 private:
  const io::Descriptor folder_;
  const std::string path_;
};

/// Returns whether a folder with this status is the user's own, and no other user's to look into or to change.
[[nodiscard]] bool is_private(const struct stat& status, uid_t user);

/// Returns a folder's name for a node: "robot.rosbag2_recorder" for "/robot" and "/rosbag2_recorder". Other characters than letters,
/// digits, '_', '-' and '.' become '_'; of a long name the end is a checksum.
[[nodiscard]] std::string ring_name(const std::string& container, const std::string& node);

}  // namespace nacelle::record
