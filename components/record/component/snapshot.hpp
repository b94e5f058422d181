// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "record/protocol/compression.hpp"

namespace nacelle::record {

struct SnapshotWish {
  std::vector<std::string> files;  ///< Of a ring, in any order. They may be damaged.
  std::string folder;              ///< Of the recording. If it exists, "_2", "_3" and so on is added.
  std::string reason;              ///< Metadata of the file: "emergency stop /emergency_stop".
  Compression compression = Compression::None;
  std::uint64_t keep_free = 0;  ///< Bytes of the file system that are left to others.
};

struct Snapshot {
  std::string folder;
  std::uint64_t messages = 0, bytes = 0;
  std::uint64_t problems =
      0;  ///< Records of the ring that could not be read, but for the chunk that was being written at a kill.
};

/// Writes what a ring holds as a recording folder, and waits for the disk.
///
/// The bytes of the files are hostile, as walk_mcap() has them. Errors: nothing can be read, the disk is full, or the folder cannot be made;
/// no folder is left then.
[[nodiscard]] Result<Snapshot, Problem> write_snapshot(const SnapshotWish& wish);

}  // namespace nacelle::record
