// SPDX-License-Identifier: Apache-2.0
// Any bytes as a viewer's frame (the first byte says whether it is text), as its headers, and as values of parameters: nothing crashes,
// and what was read can be written.
#include <cstdlib>

#include "look/component/asset_folders.hpp"
#include "look/component/parameter_json.hpp"
#include "look/component/parameter_questions.hpp"
#include "look/model/access.hpp"
#include "look/protocol/client_message.hpp"
#include "look/protocol/server_message.hpp"

namespace nacelle::look {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void look_at_parameters(const SetParameters& message) {
  for (const SetParameters::One& one : message.all) {
    const auto value = parameter_value(one.value, one.type);
    if (!value) continue;
    const nlohmann::json written = parameter_json(one.name, *value);
    const auto again = parameter_value(written.value("value", nlohmann::json{}), written.value("type", ""));
    // An empty list has no type of its own.
    require(again.has_value() && (again->type == value->type || one.value.empty()));
    static_cast<void>(parameter_name(one.name));
  }
}

void look_at(ByteView bytes) {
  if (bytes.empty()) return;
  const bool is_text = bytes[0] % 2 == 0;
  bytes = bytes.subspan(1);
  const Access access{{"view", "operate", {"robot"}, {}}};
  static_cast<void>(access.is_host_allowed(as_text(bytes)));
  require(access.right_of(as_text(bytes)) == Right::None || bytes.size() < 8);
  require(!access.is_origin_allowed(as_text(bytes), "robot") || bytes.empty() || as_text(bytes).size() == 12);
  const auto message = is_text ? read_text(as_text(bytes)) : read_binary(bytes);
  if (!message) {
    static_cast<void>(status(StatusLevel::Warning, message.error().text()));
    return;
  }
  if (const auto* const set = std::get_if<SetParameters>(&*message)) look_at_parameters(*set);
  if (const auto* const fetch = std::get_if<FetchAsset>(&*message)) {
    static const AssetFolders folders{{"/nonexistent"}};
    require(!folders.read(fetch->uri));
  }
  if (const auto* const call = std::get_if<ServiceCall>(&*message)) {
    require(call->encoding.size() + call->data.size() + 13 == bytes.size());
    static_cast<void>(service_call_failure(call->service, call->call, call->encoding));
  }
  if (const auto* const publication = std::get_if<Publication>(&*message))
    require(publication->data.size() + 5 == bytes.size());
}

}  // namespace
}  // namespace nacelle::look

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  nacelle::look::look_at({data, size});
  return 0;
}
