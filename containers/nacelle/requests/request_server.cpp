// SPDX-License-Identifier: Apache-2.0
#include "requests/request_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <iterator>
#include <new>
#include <nlohmann/json.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

#include "control/client.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/msgs/json.hpp"
#include "text/message_yaml.hpp"

namespace nacelle::requests {

using nlohmann::json;

namespace {

const msgs::Field* field_of(const msgs::MessageType& type, std::string_view name, std::string_view type_name) {
  for (const msgs::Field& field : type.fields) {
    if (field.name == name && field.shape == msgs::Shape::Single && field.message != nullptr &&
        field.message().name == type_name)
      return &field;
  }
  return nullptr;
}

const msgs::Field* header_of(const msgs::MessageType& type) { return field_of(type, "header", "std_msgs/msg/Header"); }

bool has_header(const msgs::MessageType& type) { return header_of(type) != nullptr; }

/// header.stamp of a message that has one.
std::int64_t stamp_ns(const msgs::MessageType& type, const void* message) {
  const msgs::Field& header = *header_of(type);
  const msgs::Field& stamp = *field_of(header.message(), "stamp", "builtin_interfaces/msg/Time");
  const auto* const at = static_cast<const std::uint8_t*>(message) + header.offset + stamp.offset;
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  for (const msgs::Field& field : stamp.message().fields) {
    if (field.kind == msgs::Kind::Int32) std::memcpy(&seconds, at + field.offset, sizeof seconds);
    if (field.kind == msgs::Kind::Uint32) std::memcpy(&nanoseconds, at + field.offset, sizeof nanoseconds);
  }
  return seconds * std::int64_t{1'000'000'000} + nanoseconds;
}

constexpr const char* kTheRobotGoesOn = "the request was refused; the container keeps running";

std::string reason_of(const std::exception& failure) {
  if (dynamic_cast<const std::bad_alloc*>(&failure) != nullptr) return "out of memory";
  return failure.what();
}

/// The type of /tf's messages.
constexpr std::string_view kTransformsType = "tf2_msgs/msg/TFMessage";

/// For `tf monitor`: a message of kTransformsType as [[child, parent, stamp_ns, published_ns], ...], both by the wall clock.
void append_transform_times(std::string& out, const Block& block, const Clock& clock) {
  const auto& message = *static_cast<const tf2_msgs::msg::TFMessage*>(block.message);
  const WallTime published = clock.wall_now() - (clock.now() - block.info.source_time);
  json rows = json::array();
  for (const auto& transform : message.transforms) {
    const auto& stamp = transform.header.stamp;
    rows.push_back({transform.child_frame_id, transform.header.frame_id,
                    std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec, published.nanoseconds()});
  }
  out += rows.dump(-1, ' ', false, json::error_handler_t::replace);
}

void append_hex(std::string& out, const msgs::MessageType& type, const void* message) {
  Bytes bytes(type.encoded_size(message));
  type.encode(message, bytes.data());
  out += to_hex(bytes);
}

}  // namespace

void Respondent::take_frame(control::Connection& from, const control::Frame&) {
  control::append_frame(from.out, control::FrameKind::Fault,
                        "this connection takes requests; open another one to publish");
}

RequestServer::Show RequestServer::show_of(const std::string& word) {
  if (word == "json") return Show::Json;
  if (word == "times") return Show::Times;
  if (word == "sizes") return Show::Sizes;
  if (word == "transforms") return Show::Transforms;
  if (word == "raw") return Show::Raw;
  return word == "ages" ? Show::Ages : Show::Yaml;
}

RequestServer::RequestServer(std::unique_ptr<Respondent> own, RequestLimits limits)
    : own_(std::move(own)), respondent_(*own_), limits_(limits) {}
RequestServer::RequestServer(Respondent& respondent, RequestLimits limits) : respondent_(respondent), limits_(limits) {}
RequestServer::~RequestServer() = default;

template <typename Act>
void RequestServer::guarded(Guest& guest, Act act) {
  try {
    act();
  } catch (const std::exception& failure) { take_leave(guest, reason_of(failure).c_str()); } catch (...) {
    take_leave(guest, "unknown exception");
  }
}

void RequestServer::take(std::unique_ptr<control::Connection> connection) {
  guests_.push_back({});
  guests_.back().connection = std::move(connection);
  guests_.back().said_at = respondent_.clock().now();
}

void RequestServer::take(control::ControlServer::HandedOver handed) {
  const bool has_room = guests_.size() < limits_.guests || make_room();
  take(std::move(handed.connection));
  Guest& guest = guests_.back();
  guarded(guest, [&] {
    if (has_room) {
      answer(guest, handed.request);
      read(guest);  // requests that came right behind the first one
      return;
    }
    send(guest, control::reply_of(
                    {"container", fmt::format("all {} connections for requests are in use", limits_.guests),
                     "close another client (topic echo, a pending call) and retry; `nacelle estop` still works"}));
    guest.gone = true;
  });
  remove_the_gone();
}

bool RequestServer::make_room() {
  Guest* idle = nullptr;
  for (Guest& guest : guests_) {
    if (guest.tap || guest.late || respondent_.clock().now() - guest.said_at < limits_.makes_room_after) continue;
    if (idle == nullptr || guest.said_at < idle->said_at) idle = &guest;
  }
  if (idle == nullptr) return false;
  take_leave(*idle, "closed as the longest idle connection: all client connections are in use");
  remove_the_gone();
  return true;
}

void RequestServer::take_leave(Guest& guest, const char* why) {
  guest.gone = true;
  guest.connection->say_farewell(why);
}

void RequestServer::remove_the_gone() {
  std::erase_if(guests_, [&](const Guest& guest) {
    if (guest.gone) respondent_.has_left(*guest.connection);
    return guest.gone;
  });
}

void RequestServer::send_half_away(const char* why) {
  for (std::size_t i = guests_.size() / 2; i < guests_.size(); ++i) take_leave(guests_[i], why);
  remove_the_gone();
}

void RequestServer::append_waits(std::vector<pollfd>& waits) {
  has_listed_ = false;
  waits.reserve(waits.size() + 2 * guests_.size());
  has_listed_ = true;
  for (Guest& guest : guests_) {
    const bool slow = guest.connection->is_slow();
    const int events = (slow || guest.late ? 0 : POLLIN) | (guest.connection->wants_to_write() ? POLLOUT : 0);
    waits.push_back({guest.connection->descriptor(), static_cast<short>(events), 0});
    // A slow guest's messages wait in the tap's queue, and there the oldest give way.
    guest.waits_for_tap = guest.tap && !slow;
    guest.waits_for_answer = guest.late != nullptr;
    if (guest.waits_for_tap) waits.push_back({guest.tap->descriptor(), POLLIN, 0});
    if (guest.waits_for_answer) waits.push_back({guest.late->bell->descriptor(), POLLIN, 0});
  }
}

void RequestServer::serve(const pollfd* waits) {
  if (!has_listed_) return;
  has_listed_ = false;
  bool has_answer = false;
  for (Guest& guest : guests_) {
    guest.events = (waits++)->revents;
    guest.has_message = guest.waits_for_tap && (waits++)->revents != 0;
    guest.has_answer = guest.waits_for_answer && (waits++)->revents != 0;
    has_answer |= guest.has_answer;
  }
  // Messages go ahead of answers, so that the feedback of a goal is there before its result. An answer may be seen by
  // poll() without the message before it.
  for (Guest& guest : guests_) {
    if (guest.has_message || (guest.waits_for_tap && has_answer)) guarded(guest, [&] { stream(guest); });
  }
  for (Guest& guest : guests_) guarded(guest, [&] { serve(guest); });
  end_hopeless_listening();
}

void RequestServer::end_hopeless_listening() {
  for (Guest& guest : guests_) {
    if (guest.gone || !guest.tap) continue;
    if (const auto problem = respondent_.problem_of(guest.tap->topic())) take_leave(guest, problem->text().c_str());
  }
  remove_the_gone();
}

void RequestServer::serve(Guest& guest) {
  if ((guest.events & (POLLERR | POLLNVAL)) != 0) guest.gone = true;
  if (guest.late) {
    if ((guest.events & POLLHUP) != 0) guest.gone = true;  // the client has left
    if (!guest.gone) finish(guest);
  } else if (!guest.gone && (guest.events & (POLLIN | POLLHUP)) != 0) {
    guest.gone = !guest.connection->read_some();
    guest.said_at = respondent_.clock().now();
    if (!guest.gone) read(guest);
  } else if (const auto end = end_of(guest); !guest.gone && end && *end <= respondent_.clock().now()) {
    take_leave(guest, "closed after being idle for too long");
  }
  if (!guest.gone) guest.gone = !guest.connection->write_some();
}

std::optional<MonotonicTime> RequestServer::end_of(const Guest& guest) const {
  if (guest.late) return guest.late->due;
  if (guest.tap || limits_.idle == Duration::max()) return std::nullopt;
  return guest.said_at + limits_.idle;
}

std::optional<MonotonicTime> RequestServer::next_due() const {
  std::optional<MonotonicTime> next;
  for (const Guest& guest : guests_) {
    if (const auto end = end_of(guest); end && (!next || *end < *next)) next = end;
  }
  return next;
}

void RequestServer::finish(Guest& guest) {
  if (!guest.has_answer && respondent_.clock().now() < guest.late->due) return;
  const std::unique_ptr<LateReply> late = std::move(guest.late);
  guest.said_at = respondent_.clock().now();
  send(guest, guest.has_answer ? late->finish() : control::reply_of(late->too_late));
  if (!guest.gone) read(guest);  // requests that came right behind
}

void RequestServer::read(Guest& guest) {
  while (!guest.gone && !guest.late && !guest.connection->is_slow()) {
    auto frame = guest.connection->in.next();
    if (!frame) {
      guest.gone = true;
      return;
    }
    if (!frame.value()) break;
    if (frame.value()->kind == control::FrameKind::Request) {
      answer(guest, std::string{as_text(frame.value()->payload)});
    } else {
      respondent_.take_frame(*guest.connection, *frame.value());
    }
  }
  if (!guest.gone) guest.gone = !guest.connection->write_some();
}

void RequestServer::answer(Guest& guest, const std::string& request_text) {
  const auto parsed = parse_json(request_text);
  Answer reply;
  try {
    if (!parsed) {
      reply = control::reply_of({"request", parsed.error().text(), ""});
    } else if (parsed.value().is_object()) {
      reply = reply_to(guest, parsed.value());
    } else {
      reply = control::reply_of({"request", "is not a JSON object", ""});
    }
  } catch (const json::exception& e) {
    // A field of a wrong type is the client's mistake, and reported to it.
    const std::string_view text = e.what();  // "[json.exception.type_error.302] type must be ..."
    const auto end = text.find("] ");
    reply = control::reply_of({"request", std::string{text.substr(end == std::string_view::npos ? 0 : end + 2)},
                               "use the `nacelle` that started the container"});
  } catch (const std::exception& failure) {
    reply = control::reply_of({"request", reason_of(failure), kTheRobotGoesOn});
  } catch (...) { reply = control::reply_of({"request", "unknown exception", kTheRobotGoesOn}); }
  if (auto* const late = std::get_if<std::unique_ptr<LateReply>>(&reply)) {
    guest.late = std::move(*late);
  } else {
    send(guest, std::get<json>(reply));
  }
}

void RequestServer::send(Guest& guest, const json& reply) {
  control::append_frame(guest.connection->out, control::FrameKind::Reply,
                        reply.dump(-1, ' ', false, json::error_handler_t::replace));
  if (!guest.gone) guest.gone = !guest.connection->write_some();
}

Answer RequestServer::reply_to(Guest& guest, const json& request) {
  const std::string verb = request.value("verb", "");
  if (verb == "topic.listen") return listen(guest, request);
  return respondent_.answer(verb, request);
}

json RequestServer::listen(Guest& guest, const json& request) {
  const Show show = show_of(request.value("show", "yaml"));
  TapWish wish{.topic = request.value("topic", ""), .type = request.value("type", "")};
  wish.is_measured = show != Show::Yaml && show != Show::Json && show != Show::Raw;
  wish.is_raw = show == Show::Raw;
  wish.needs_values = !wish.is_raw && show != Show::Times && show != Show::Sizes;
  auto tap = respondent_.tap(wish);
  if (!tap) return control::reply_of(tap.error());
  const msgs::MessageType* const type = &tap.value()->type();
  const std::string& topic = wish.topic;
  guest.show = show;
  guest.field.reset();
  if (const std::string path = request.value("field", ""); !path.empty()) {
    auto field = text::MessageField::find(*type, path);
    if (!field) return control::reply_of(field.error());
    guest.field = std::move(field).value();
  }
  if (guest.show == Show::Ages && !has_header(*type)) {
    return control::reply_of({"topic " + topic,
                              std::string{"its type "} + type->name + " has no header, and so no stamp",
                              "its rate can be measured: topic hz"});
  }
  if (guest.show == Show::Transforms && type->name != kTransformsType)
    return control::reply_of({"topic " + topic, std::string{"has the type "} + type->name, ""});
  guest.longest = request.value("longest", std::size_t{128});
  guest.tap = std::move(tap).value();
  return {{"ok", true}, {"type", type->name}, {"writers", guest.tap->writer_count()}};
}

void RequestServer::stream(Guest& guest) {
  while (!guest.connection->is_slow()) {
    Block* const block = guest.tap->take();
    if (block == nullptr) break;
    text_.clear();
    append_item(guest, *block);
    drop_reference(*block);
    control::append_frame(guest.connection->out, control::FrameKind::Item, text_);
  }
  guest.gone = !guest.connection->write_some();
}

void RequestServer::append_item(const Guest& guest, const Block& block) {
  const msgs::MessageType& type = guest.tap->type();
  const std::int64_t at_ns = block.info.source_time.nanoseconds();
  const auto out = std::back_inserter(text_);
  switch (guest.show) {
    case Show::Yaml:
      if (guest.field) {
        guest.field->append_yaml(text_, block.message, {guest.longest});
      } else {
        text::append_yaml(text_, type, block.message, {guest.longest});
      }
      break;
    case Show::Json:
      text_ = guest.field ? guest.field->to_json(block.message) : msgs::to_json(type, block.message);
      break;
    case Show::Raw: append_hex(text_, type, block.message); break;
    case Show::Times: fmt::format_to(out, "{}", at_ns); break;
    case Show::Sizes: fmt::format_to(out, "{} {}", at_ns, type.encoded_size(block.message)); break;
    case Show::Transforms: append_transform_times(text_, block, respondent_.clock()); break;
    case Show::Ages: {
      // When it was published, on the time line of stamps: it may have waited here for its turn.
      const Clock& clock = respondent_.clock();
      const std::int64_t wall_ns = (clock.wall_now() - (clock.now() - block.info.source_time)).nanoseconds();
      fmt::format_to(out, "{} {}", at_ns, wall_ns - stamp_ns(type, block.message));
      break;
    }
  }
}

}  // namespace nacelle::requests
