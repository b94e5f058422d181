// SPDX-License-Identifier: Apache-2.0
#include "look/component/robot_requests.hpp"

#include <optional>

#include "look/protocol/look_fault.hpp"
#include "nacelle/msgs/json.hpp"
#include "std_msgs/msg/bool.hpp"

namespace nacelle::look {
namespace {

constexpr std::size_t kMostPosts = 1000;
constexpr const char* kStopName = "emergency_stop";

/// Reads a message. Errors: it is none of this type.
Result<void, Problem> read(const std::string& encoding, ByteView data, const msgs::MessageType& type, void* message) {
  if (encoding == "json") {
    auto done = msgs::from_json(as_text(data), type, message);
    if (!done) return err(Problem{done.error().text(), "is no " + std::string{type.name}, "", LookFault::BadEncoding});
    return {};
  }
  if (encoding != "cdr")
    return err(Problem{"encoding", "is neither cdr nor json", "use one of them", LookFault::BadEncoding});
  if (!type.decode(data, message)) {
    return err(Problem{"a message of " + std::to_string(data.size()) + " bytes",
                       "is no " + std::string{type.name} + " in CDR", "use the type's definition",
                       LookFault::BadEncoding});
  }
  return {};
}

}  // namespace

/// A client of one service, with the calls that have no response yet.
struct RobotRequests::ServiceClient {
  const msgs::MessageType* request = nullptr;
  std::map<std::int64_t, TakeResponse> waiting;
  std::unique_ptr<ClientHandle> handle;  // the last one: its callback does not run afterwards

  static void run(void* context, std::int64_t sequence, const void* response) {
    auto& self = *static_cast<ServiceClient*>(context);
    const auto found = self.waiting.find(sequence);
    if (found == self.waiting.end()) return;
    const TakeResponse take = std::move(found->second);
    self.waiting.erase(found);
    take(response);
  }
};

RobotRequests::RobotRequests(Node& node, GenericTopics topics, GenericServices services)
    : topics_(std::move(topics)), graph_(services), types_({msgs::TypeLibrary::own_folder()}) {
  wake_up_ = node.create_wake_up([this] { work(); });
}

RobotRequests::~RobotRequests() { wake_up_.reset(); }

bool RobotRequests::post(std::function<void()> work) {
  {
    const LockGuard lock{mutex_};
    if (posts_.size() >= kMostPosts) return false;
    posts_.push_back(std::move(work));
  }
  wake_up_->wake();
  return true;
}

void RobotRequests::work() {
  std::vector<std::function<void()>> now;
  {
    const LockGuard lock{mutex_};
    std::swap(now, posts_);
  }
  for (const auto& one : now) one();
}

Result<void, Problem> RobotRequests::open_writer(ViewerId viewer, std::uint32_t channel, const std::string& topic,
                                                 const std::string& type) {
  const auto known = types_.message(type);
  if (!known) {
    Problem problem = known.error();
    problem.code = LookFault::UnknownType;
    return err(std::move(problem));
  }
  if (is_emergency_stop(topic, type)) {
    auto& stop = stops_[topic];
    if (!stop) stop = topics_.write(topic, **known, QoS(KeepAll{}).reliable().transient_local());
    writers_[{viewer, channel}] = {topic, *known, stop};
  } else {
    writers_[{viewer, channel}] = {topic, *known, topics_.write(topic, **known, QoS{10})};
  }
  return {};
}

Result<void, Problem> RobotRequests::publish(ViewerId viewer, std::uint32_t channel, const std::string& encoding,
                                             ByteView data) {
  const auto found = writers_.find({viewer, channel});
  if (found == writers_.end())
    return err(Problem{"channel " + std::to_string(channel), "is not advertised", "advertise it first",
                       LookFault::UnknownChannel});
  Out& out = found->second;
  Block* const block = out.writer->borrow();
  if (block == nullptr) return {};  // its readers keep what they have: the message is dropped and counted
  if (auto done = read(encoding, data, *out.type, block->message); !done) {
    drop_reference(*block);
    Problem problem = done.error();
    problem.where = Place{out.topic + ": " + problem.where.text()};
    return err(std::move(problem));
  }
  static_cast<void>(out.writer->publish(*block));
  return {};
}

void RobotRequests::close_writer(ViewerId viewer, std::uint32_t channel) { writers_.erase({viewer, channel}); }

void RobotRequests::close_writers(ViewerId viewer) {
  std::erase_if(writers_, [&](const auto& entry) { return entry.first.first == viewer; });
}

void RobotRequests::call(const std::string& service, const msgs::MessageType& request_type,
                         const msgs::MessageType& response_type, msgs::AnyMessage request, TakeResponse take) {
  auto& client = clients_[service];
  if (!client || client->request != &request_type) {
    client = std::make_unique<ServiceClient>();
    client->request = &request_type;
    client->handle = graph_.client(service, request_type, response_type, {&ServiceClient::run, client.get()});
  }
  const std::int64_t sequence = client->handle->send(request.get());
  if (sequence == 0) return take(nullptr);
  client->waiting.emplace(sequence, std::move(take));
}

bool is_emergency_stop(const std::string& topic, const std::string& type) {
  return type == std_msgs::msg::Bool::message_type().name && topic.substr(topic.rfind('/') + 1) == kStopName;
}

bool sets_emergency_stop(const std::string& encoding, ByteView data) {
  std_msgs::msg::Bool message;
  return read(encoding, data, std_msgs::msg::Bool::message_type(), &message).has_value() && message.data;
}

}  // namespace nacelle::look
