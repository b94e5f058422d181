// SPDX-License-Identifier: Apache-2.0
#include "qos_clash.hpp"

#include <fmt/format.h>

#include "broker_writer.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::runtime {

std::string ClashReport::what(const std::string& writer_place) const {
  const std::string writer = writer_place.empty() ? writer_node : fmt::format("{} ({})", writer_node, writer_place);
  if (policy == kTypePolicy)
    return fmt::format("{} publishes {}, {} reads {}", writer, offered, reader_node, requested);
  std::string others;
  if (other_writers != 0)
    others = fmt::format(" ({} other publisher{} it)", other_writers, other_writers == 1 ? " serves" : "s serve");
  return Clash{Verdict::Error, policy, offered, requested, change}.between(writer, reader_node) + others;
}

std::string ClashReport::text() const { return topic + ": " + what() + "; " + change; }

ClashReport clash_of_types(const std::string& topic, const std::string& writer_node, const std::string& writer_type,
                           const std::string& reader_node, const std::string& reader_type) {
  return {topic,
          writer_node,
          reader_node,
          kTypePolicy,
          writer_type,
          reader_type,
          "rename one of the topics with a remap, or make both sides use one type"};
}

std::vector<ClashReport> clashes_between(const EndpointSpec& writer, const EndpointSpec& reader) {
  std::vector<ClashReport> found;
  if (same_link(writer, reader)) return found;
  if (writer.type != reader.type) {
    found.push_back(clash_of_types(writer.topic, writer.node, writer.type->name, reader.node, reader.type->name));
    return found;
  }
  for (auto& clash : check(writer.qos.resolved(), reader.qos.resolved()).clashes) {
    if (clash.severity != Verdict::Error) continue;
    found.push_back({writer.topic, writer.node, reader.node, std::move(clash.policy), std::move(clash.offered),
                     std::move(clash.requested), std::move(clash.change)});
  }
  return found;
}

void introduce(BrokerWriter& writer, ReaderQueue& reader) {
  if (is_tool(writer.spec()) || is_tool(reader.spec()) || same_link(writer.spec(), reader.spec())) return;
  if (writer.spec().type == reader.spec().type && leaves_to_another(reader.spec(), writer.spec())) return;
  const auto clashes = clashes_between(writer.spec(), reader.spec());
  if (clashes.empty()) {
    if (reader.is_witness()) return;  // it matches only while its messages can reach the reader that it represents
    writer.note_matched();
    reader.note_matched();
    return;
  }
  // One count per pair, as in DDS; the text names all policies.
  std::string text;
  for (const auto& clash : clashes) text += (text.empty() ? "" : "\n") + clash.text();
  writer.note_clash(clashes.front().policy, text);
  reader.note_clash(clashes.front().policy, std::move(text));
}

}  // namespace nacelle::runtime
