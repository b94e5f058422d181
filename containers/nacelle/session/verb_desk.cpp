// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/verb_desk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "nacelle/control/client.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/session/message_yaml.hpp"
#include "nacelle/session/session.hpp"
#include "nacelle/session/tf_verbs.hpp"
#include "nacelle/session/verbs.hpp"

namespace nacelle::session {

using nlohmann::json;

namespace {

/// The types of which a topic has ends.
std::vector<std::string> types_of(const runtime::Container& container, const std::string& topic) {
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  std::vector<std::string> types;
  for (const auto& stream : streams) {
    if (stream.name == topic && stream.writers + stream.readers != 0) types.push_back(stream.type);
  }
  return types;
}

}  // namespace

VerbDesk::VerbDesk(Session& session) : session_(session), types_(session.options().places.message_folders) {}
VerbDesk::~VerbDesk() = default;

void VerbDesk::take(control::ControlServer::HandedOver handed) {
  guests_.push_back({});
  guests_.back().connection = std::move(handed.connection);
  answer(guests_.back(), handed.request);
  read(guests_.back());  // requests that came right behind the first one
}

void VerbDesk::append_waits(std::vector<pollfd>& waits) const {
  for (const Guest& guest : guests_) {
    const bool slow = guest.connection->is_slow();
    const int events = (slow ? 0 : POLLIN) | (guest.connection->wants_to_write() ? POLLOUT : 0);
    waits.push_back({guest.connection->descriptor(), static_cast<short>(events), 0});
    // A slow guest's messages wait in the tap's queue, and there the oldest give way.
    waits.push_back({guest.tap && !slow ? guest.tap->descriptor() : -1, POLLIN, 0});
  }
}

void VerbDesk::serve(const pollfd* waits, std::size_t count) {
  for (std::size_t i = 0; i < count / 2; ++i) {
    Guest& guest = guests_[i];
    const short events = waits[2 * i].revents;
    if ((events & (POLLERR | POLLNVAL)) != 0) guest.gone = true;
    if (!guest.gone && (events & (POLLIN | POLLHUP)) != 0) {
      guest.gone = !guest.connection->read_some();
      if (!guest.gone) read(guest);
    }
    if (!guest.gone && waits[2 * i + 1].revents != 0) stream(guest);
    if (!guest.gone) guest.gone = !guest.connection->write_some();
  }
  std::erase_if(guests_, [](const Guest& guest) { return guest.gone; });
}

void VerbDesk::read(Guest& guest) {
  while (!guest.gone && !guest.connection->is_slow()) {
    auto frame = guest.connection->in.next();
    if (!frame) {
      guest.gone = true;
      return;
    }
    if (!frame.value()) break;
    if (frame.value()->kind == control::FrameKind::Request) {
      answer(guest, std::string{as_text(frame.value()->payload)});
    } else {
      control::append_frame(guest.connection->out, control::FrameKind::Fault,
                            "this connection takes requests; open another one to publish");
    }
  }
  if (!guest.gone) guest.gone = !guest.connection->write_some();
}

void VerbDesk::answer(Guest& guest, const std::string& request_text) {
  const json request = json::parse(request_text, nullptr, false);
  json reply;
  try {
    reply = request.is_object() ? reply_to(guest, request) : control::reply_of({"request", "is not a JSON object", ""});
  } catch (const json::exception& e) {
    // A field of another type than it should be: the client's fault, told to the client.
    const std::string_view text = e.what();  // "[json.exception.type_error.302] type must be ..."
    const auto end = text.find("] ");
    reply = control::reply_of({"request", std::string{text.substr(end == std::string_view::npos ? 0 : end + 2)},
                               "use the `nacelle` that started the container"});
  }
  control::append_frame(guest.connection->out, control::FrameKind::Reply,
                        reply.dump(-1, ' ', false, json::error_handler_t::replace));
  if (!guest.gone) guest.gone = !guest.connection->write_some();
}

json VerbDesk::reply_to(Guest& guest, const json& request) {
  const std::string verb = request.value("verb", "");
  if (verb != "topic.listen") return reply_to_verb(session_, verb, request);

  const std::string topic = request.value("topic", "");
  const msgs::MessageType* type = nullptr;
  // A name may carry two types (cmd_vel does); then the one that is meant can be given.
  if (const std::string wanted = request.value("type", ""); !wanted.empty()) {
    auto found = types_.message(wanted);
    if (!found) return control::reply_of(found.error());
    type = found.value();
    // Of another type nothing would ever come. A topic that nobody has yet may still get this one.
    const std::vector<std::string> types = types_of(session_.container(), topic);
    if (!types.empty() && std::find(types.begin(), types.end(), type->name) == types.end())
      return control::reply_of({"topic " + topic, "has the type " + join(types, " and ") + ", not " + type->name, ""});
  } else {
    type = session_.container().topic_type(topic);
  }
  if (type == nullptr) {
    std::vector<std::string> names;
    std::vector<runtime::StreamReport> streams;
    session_.container().report_streams(streams);
    for (const auto& stream : streams) names.push_back(stream.name);
    return control::reply_of({"topic " + topic, "nobody publishes or reads it", suggestion(topic, names)});
  }
  const std::string show = request.value("show", "yaml");
  guest.show = show == "json"         ? Show::Json
               : show == "times"      ? Show::Times
               : show == "transforms" ? Show::Transforms
                                      : Show::Yaml;
  if (guest.show == Show::Transforms && type->name != std::string_view{kTransformsType})
    return control::reply_of({"topic " + topic, std::string{"has the type "} + type->name, ""});
  guest.longest = request.value("longest", std::size_t{128});
  // A person reads text slower than a sensor writes it; only the times of `topic hz` must not be lost.
  const bool keeps_up = guest.show == Show::Times || guest.show == Show::Transforms;
  guest.tap = std::make_unique<TopicTap>(session_.container().transport(), topic, *type, keeps_up ? 1000 : 10);
  return {{"ok", true}, {"type", type->name}, {"writers", guest.tap->writer_count()}};
}

void VerbDesk::stream(Guest& guest) {
  while (!guest.connection->is_slow()) {
    Block* const block = guest.tap->take();
    if (block == nullptr) break;
    text_.clear();
    switch (guest.show) {
      case Show::Yaml: append_yaml(text_, guest.tap->type(), block->message, {guest.longest}); break;
      case Show::Json: text_ = msgs::to_json(guest.tap->type(), block->message); break;
      case Show::Transforms: append_transform_times(text_, *block, session_.container().clock()); break;
      case Show::Times: fmt::format_to(std::back_inserter(text_), "{}", block->info.source_time.nanoseconds()); break;
    }
    drop_reference(*block);
    control::append_frame(guest.connection->out, control::FrameKind::Item, text_);
  }
}

}  // namespace nacelle::session
