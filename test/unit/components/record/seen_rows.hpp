// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "record/model/bag_rows_reader.hpp"

namespace nacelle::record {

/// What a reader of rows hands over, in its order, as text.
class SeenRows final : private McapVisitor {
 public:
  SeenRows(BagRows& rows, TypeDefinition definition) {
    BagRowsReader reader{rows, *this, std::move(definition)};
    while (reader.next()) {}
    complete = reader.is_complete();
  }

  std::vector<std::string> lines;
  std::vector<std::pair<McapFault, std::uint64_t>> problems;  // and their rows
  bool complete = false;

 private:
  void on_header(const McapHeader& header) override { lines.push_back("header " + header.profile); }
  void on_schema(const McapSchema& schema) override {
    lines.push_back("schema " + std::to_string(schema.id) + " " + schema.name + " " + schema.encoding + " " +
                    std::string{as_text(schema.data.bytes)});
  }
  void on_channel(const McapChannel& channel) override {
    std::string text = "channel " + std::to_string(channel.id) + " of " + std::to_string(channel.schema_id) + " " +
                       channel.topic + " " + channel.message_encoding;
    for (const auto& [key, value] : channel.metadata) text.append(" ").append(key).append("=").append(value);
    lines.push_back(std::move(text));
  }
  void on_message(const McapMessage& message, const McapSpot&) override {
    lines.push_back("message " + std::to_string(message.channel_id) + " at " + std::to_string(message.log_time) + ": " +
                    std::string{as_text(message.data.bytes)});
  }
  void on_problem(const McapProblem& problem) override { problems.emplace_back(problem.fault, problem.offset); }
};

}  // namespace nacelle::record
