// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "record/model/bag_rows.hpp"
#include "record/protocol/mcap_walk.hpp"

namespace nacelle::record {

/// Returns the ros2msg definition of a type that the recording has none of.
using TypeDefinition = std::function<std::optional<std::string>(const std::string& type)>;

/// Hands over the rows of a database as an MCAP file would be: header, schemas, channels, then each message. McapSpot::offset and
/// McapProblem::offset are the row of the message.
///
/// Threads: one.
class BagRowsReader final : public RecordingReader {
 public:
  BagRowsReader(BagRows& rows, McapVisitor& visitor, TypeDefinition definition = nullptr)
      : rows_(rows), visitor_(visitor), definition_(std::move(definition)) {}

  [[nodiscard]] bool next() override;
  [[nodiscard]] bool is_complete() const override { return is_complete_; }

 private:
  bool end(McapFault fault, const char* what);
  void introduce();
  std::uint16_t schema_of(const std::string& type);
  void hand_over(const BagMessage& message);

  BagRows& rows_;
  McapVisitor& visitor_;
  const TypeDefinition definition_;
  std::map<std::string, const BagDefinition*> definitions_;  // by type
  std::map<std::string, std::uint16_t> schemas_;             // by type
  std::map<std::int64_t, std::uint16_t> channels_;           // by the topic's id
  std::uint64_t row_ = 0;
  bool has_begun_ = false, has_ended_ = false, is_complete_ = false;
};

}  // namespace nacelle::record
