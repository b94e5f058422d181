// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/qos/qos.hpp"

// What rosbag2 knows of a recording beside its messages.
// Source: rosbag2 (jazzy), rosbag2_storage/include/rosbag2_storage/{yaml,qos}.hpp, rosbag2_storage/src/rosbag2_storage/metadata_io.cpp
namespace nacelle::record {

/// The name of the metadata record in which Nacelle's recorder says at the end what was lost and copied; the last file has it.
inline constexpr const char* kRecorderRecord = "nacelle.recorder";

struct BagTopic {
  std::string name, type, hash;
  std::vector<QoS> offered;  ///< By its publishers.
  std::uint64_t messages = 0;
};
/// Times are nanoseconds since the Unix epoch.
struct BagFile {
  std::string name;  ///< Without its folder.
  std::uint64_t messages = 0, first = 0, last = 0;
};
struct BagMetadata {
  std::vector<BagTopic> topics;
  std::vector<BagFile> files;
};

/// Returns the YAML of a topic's QoS profiles, as in an MCAP channel's metadata "offered_qos_profiles".
[[nodiscard]] std::string offered_qos_profiles(const std::vector<QoS>& offered);
/// Reads such a text, with enumerators as words (rosbag2 of jazzy and later) or numbers. Returns nothing if it is none.
[[nodiscard]] std::vector<QoS> read_qos_profiles(const std::string& yaml);
/// Returns a QoS that fits the readers of each of these publishers: the strongest that one of them offers of each policy. QoS(10) if there are none.
[[nodiscard]] QoS strongest_qos(const std::vector<QoS>& offered);
/// Returns the text of metadata.yaml, version 9.
[[nodiscard]] std::string metadata_yaml(const BagMetadata& metadata);

}  // namespace nacelle::record
