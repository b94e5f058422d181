// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/bytes.hpp"

namespace nacelle::record {

/// A row of the table `topics`. Texts that the file does not have are empty.
struct BagRowTopic {
  std::int64_t id = 0;
  std::string name, type, format, qos_profiles, type_hash;
};
/// A row of the table `message_definitions`.
struct BagDefinition {
  std::string type, encoding, text;
};
/// A row of the table `messages`. What is NULL or of another kind is nullopt.
struct BagMessage {
  std::int64_t row = 0;
  std::optional<std::int64_t> topic_id, time;
  std::optional<ByteView> data;  ///< Valid until the next row.
};

/// The tables of a recording of rosbag2 in a database.
class BagRows {
 public:
  enum class Step : std::uint8_t { Row, End, Damaged, TooLarge, Unreadable };

  BagRows() = default;
  BagRows(const BagRows&) = delete;
  BagRows& operator=(const BagRows&) = delete;
  virtual ~BagRows() = default;
  /// At most 65,534 of them, each with a name, a type and a format.
  [[nodiscard]] virtual const std::vector<BagRowTopic>& topics() const = 0;
  [[nodiscard]] virtual const std::vector<BagDefinition>& definitions() const = 0;
  /// Makes next() begin with the first message again.
  virtual void rewind() = 0;
  [[nodiscard]] virtual Step next(BagMessage& message) = 0;
};

}  // namespace nacelle::record
