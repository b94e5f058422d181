// SPDX-License-Identifier: Apache-2.0
#include "look/protocol/client_message.hpp"

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <utility>

#include "look/protocol/look_fault.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/printable.hpp"

namespace nacelle::look {
namespace {

using nlohmann::json;

constexpr std::size_t kMostEntries = 1000;

/// Reads the fields of one operation; the first one that is wrong is kept.
class Fields {
 public:
  Fields(const json& object, std::string operation) : object_(object), operation_(std::move(operation)) {}

  [[nodiscard]] std::uint32_t number(const json& in, const char* name) {
    const auto found = in.is_object() ? in.find(name) : in.end();
    if (found == in.end() || !found->is_number_unsigned() ||
        found->get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
      say(fmt::format("'{}' is not a number from 0 to 4,294,967,295", name));
      return 0;
    }
    return found->get<std::uint32_t>();
  }
  /// `is_needed`: else it may be absent, and is empty then.
  [[nodiscard]] std::string text(const json& in, const char* name, bool is_needed) {
    const auto found = in.is_object() ? in.find(name) : in.end();
    if (found == in.end() && in.is_object() && !is_needed) return {};
    if (found == in.end() || !found->is_string()) {
      say(fmt::format("'{}' is not a text", name));
      return {};
    }
    return found->get<std::string>();
  }
  [[nodiscard]] std::string text(const char* name, bool is_needed) { return text(object_, name, is_needed); }
  [[nodiscard]] std::uint32_t number(const char* name) { return number(object_, name); }
  template <typename Take>
  void each(const char* name, Take&& take) {
    const auto found = object_.find(name);
    if (found == object_.end() || !found->is_array()) return say(fmt::format("'{}' is not a list", name));
    if (found->size() > kMostEntries)
      return say(fmt::format("'{}' has {} entries, the most are {}", name, found->size(), kMostEntries),
                 LookFault::TooMany);
    for (const json& one : *found) take(one);
  }
  [[nodiscard]] std::vector<std::string> texts(const char* name) {
    std::vector<std::string> all;
    each(name, [&](const json& one) {
      if (!one.is_string()) return say(fmt::format("'{}' holds something else than texts", name));
      all.push_back(one.get<std::string>());
    });
    return all;
  }
  [[nodiscard]] std::vector<std::uint32_t> numbers(const char* name) {
    std::vector<std::uint32_t> all;
    each(name, [&](const json& one) { all.push_back(number(json{{name, one}}, name)); });
    return all;
  }

  template <typename Message>
  [[nodiscard]] Result<ClientMessage, Problem> result(Message message) {
    if (problem_) return err(std::move(*problem_));
    return ClientMessage{std::move(message)};
  }

 private:
  void say(std::string what, LookFault fault = LookFault::BadMessage) {
    if (!problem_)
      problem_ = Problem{"operation " + operation_, std::move(what), "see the Foxglove WebSocket protocol", fault};
  }

  const json& object_;
  const std::string operation_;
  std::optional<Problem> problem_;
};

Result<ClientMessage, Problem> read_subscribe(Fields& fields) {
  Subscribe made;
  fields.each("subscriptions", [&](const json& one) {
    made.all.push_back({fields.number(one, "id"), fields.number(one, "channelId")});
  });
  return fields.result(std::move(made));
}

Result<ClientMessage, Problem> read_advertise(Fields& fields) {
  Advertise made;
  fields.each("channels", [&](const json& one) {
    made.all.push_back({fields.number(one, "id"), fields.text(one, "topic", true), fields.text(one, "encoding", true),
                        fields.text(one, "schemaName", true)});
  });
  return fields.result(std::move(made));
}

Result<ClientMessage, Problem> read_set_parameters(Fields& fields) {
  SetParameters made;
  fields.each("parameters", [&](const json& one) {
    SetParameters::One parameter{fields.text(one, "name", true), fields.text(one, "type", false), nullptr};
    if (one.is_object() && one.contains("value")) parameter.value = one["value"];
    made.all.push_back(std::move(parameter));
  });
  made.id = fields.text("id", false);
  return fields.result(std::move(made));
}

Result<ClientMessage, Problem> read_operation(const std::string& operation, const json& object) {
  Fields fields{object, operation};
  if (operation == "subscribe") return read_subscribe(fields);
  if (operation == "unsubscribe") return fields.result(Unsubscribe{fields.numbers("subscriptionIds")});
  if (operation == "advertise") return read_advertise(fields);
  if (operation == "unadvertise") return fields.result(Unadvertise{fields.numbers("channelIds")});
  if (operation == "getParameters")
    return fields.result(GetParameters{fields.texts("parameterNames"), fields.text("id", false)});
  if (operation == "setParameters") return read_set_parameters(fields);
  if (operation == "subscribeParameterUpdates")
    return fields.result(WatchParameters{fields.texts("parameterNames"), true});
  if (operation == "unsubscribeParameterUpdates")
    return fields.result(WatchParameters{fields.texts("parameterNames"), false});
  if (operation == "subscribeConnectionGraph") return fields.result(WatchGraph{true});
  if (operation == "unsubscribeConnectionGraph") return fields.result(WatchGraph{false});
  if (operation == "fetchAsset") return fields.result(FetchAsset{fields.text("uri", true), fields.number("requestId")});
  return err(Problem{"operation " + printable(operation), "there is no such operation",
                     "see the Foxglove WebSocket protocol", LookFault::BadMessage});
}

Problem bad_frame(const char* what) {
  return {"binary frame", what, "see the Foxglove WebSocket protocol", LookFault::BadMessage};
}

std::uint32_t load_le32(ByteView bytes, std::size_t at) {
  return static_cast<std::uint32_t>(load_le16(&bytes[at]) | (load_le16(&bytes[at + 2]) << 16U));
}

}  // namespace

Result<ClientMessage, Problem> read_text(std::string_view text) {
  const auto parsed = parse_json(text);
  if (!parsed) return err(Problem{"text frame", parsed.error().text(), "send a JSON object", LookFault::BadMessage});
  const json& object = *parsed;
  const auto operation = object.is_object() ? object.find("op") : object.end();
  if (!object.is_object() || operation == object.end() || !operation->is_string())
    return err(Problem{"text frame", "is not an object with an 'op'", "send {\"op\": ...}", LookFault::BadMessage});
  return read_operation(operation->get<std::string>(), object);
}

Result<ClientMessage, Problem> read_binary(ByteView frame) {
  constexpr std::uint8_t kPublication = 1, kCall = 2;
  constexpr std::size_t kPublicationHead = 5, kCallHead = 13;
  if (frame.empty()) return err(bad_frame("is empty"));
  if (frame[0] == kPublication) {
    if (frame.size() < kPublicationHead) return err(bad_frame("of a message has no channel"));
    return ClientMessage{Publication{load_le32(frame, 1), frame.subspan(kPublicationHead)}};
  }
  if (frame[0] != kCall) return err(bad_frame("begins with an unknown operation"));
  if (frame.size() < kCallHead) return err(bad_frame("of a service call is too short"));
  const std::size_t encoding = load_le32(frame, 9);
  if (encoding > frame.size() - kCallHead) return err(bad_frame("of a service call ends inside its encoding"));
  return ClientMessage{ServiceCall{load_le32(frame, 1), load_le32(frame, 5),
                                   std::string{as_text(frame.subspan(kCallHead, encoding))},
                                   frame.subspan(kCallHead + encoding)}};
}

}  // namespace nacelle::look
