// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/mcap_records.hpp"

namespace nacelle::record {

const char* opcode_name(McapOpcode opcode) {
  switch (opcode) {
    case McapOpcode::Header: return "Header";
    case McapOpcode::Footer: return "Footer";
    case McapOpcode::Schema: return "Schema";
    case McapOpcode::Channel: return "Channel";
    case McapOpcode::Message: return "Message";
    case McapOpcode::Chunk: return "Chunk";
    case McapOpcode::MessageIndex: return "MessageIndex";
    case McapOpcode::ChunkIndex: return "ChunkIndex";
    case McapOpcode::Attachment: return "Attachment";
    case McapOpcode::AttachmentIndex: return "AttachmentIndex";
    case McapOpcode::Statistics: return "Statistics";
    case McapOpcode::Metadata: return "Metadata";
    case McapOpcode::MetadataIndex: return "MetadataIndex";
    case McapOpcode::SummaryOffset: return "SummaryOffset";
    case McapOpcode::DataEnd: return "DataEnd";
  }
  return "";
}

}  // namespace nacelle::record
