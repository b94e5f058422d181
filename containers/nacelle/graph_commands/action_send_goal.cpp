// SPDX-License-Identifier: Apache-2.0
#include <poll.h>

#include <array>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <optional>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/action_commands.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/host/action_names.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "process/stop_signal.hpp"
#include "text/message_text.hpp"
#include "text/message_yaml.hpp"

namespace nacelle::cli {
namespace {

using action::GoalStatus;
using nlohmann::json;

/// The limit of a request for a result. A goal may take any time.
constexpr double kLongestGoal_s = 86400;

/// One goal from the command line: two connections, so that feedback comes while the result is waited for.
class Errand {
 public:
  Errand(const GoalWish& wish, control::Client asking, control::Client listening)
      : wish_(wish), asking_(std::move(asking)), listening_(std::move(listening)) {
    if (wish.timeout_s > 0) due_ = clock_.now() + from_seconds(wish.timeout_s);
  }

  int run();

 private:
  // Errors of the following: the exit code; the error has been printed.
  [[nodiscard]] Result<json, int> read_goal();
  [[nodiscard]] Result<void, int> wait_for_server();
  void warn_of_waiting(const std::map<std::string, ActionEnds>& actions, bool is_known) const;
  [[nodiscard]] int listen();
  [[nodiscard]] Result<bool, int> offer(const json& goal);
  int wait_for_result();
  int cancel(const char* why);
  int show_result(const json& response);
  void show_feedback();
  void say(const json& event, const std::string& text) const;
  [[nodiscard]] std::string yaml_of(const msgs::MessageType& type, const json& message) const;

  [[nodiscard]] std::string part(std::string_view which) const { return action::part_name(name_, which); }
  [[nodiscard]] json call_of(std::string_view which, const std::string& type, const json& request,
                             double limit_s) const {
    return {{"verb", "service.call"},
            {"service", part(which)},
            {"type", type},
            {"request", request},
            {"timeout_s", limit_s}};
  }
  [[nodiscard]] json id_json() const { return {{"uuid", id_}}; }
  [[nodiscard]] bool is_late() const { return due_ && clock_.now() >= *due_; }
  /// Waits for a signal, for the descriptors, or until the time limit, at most so long.
  void wait(std::initializer_list<int> descriptors, Duration at_most) const;

  const GoalWish& wish_;
  const SystemClock clock_;
  const process::StopSignal stop_{nullptr, process::FullOutput::Dropped};
  control::Client asking_, listening_;
  msgs::TypeLibrary library_{program_places().message_folders};
  const msgs::ActionType* type_ = nullptr;
  const std::string name_{absolute(wish_.action)};
  const action::GoalUUID id_{action::random_goal_id()};
  std::optional<MonotonicTime> due_;
};

void Errand::say(const json& event, const std::string& text) const {
  if (wish_.as_json) {
    if (!event.is_null()) std::printf("%s\n", event.dump().c_str());
  } else {
    print_text("%s\n", text.c_str());
  }
  std::fflush(stdout);
}

std::string Errand::yaml_of(const msgs::MessageType& type, const json& message) const {
  msgs::AnyMessage read{type};
  if (auto done = msgs::from_json(message.dump(), type, read.get()); !done) return message.dump();
  std::string text;
  text::append_yaml(text, type, read.get(), {0});
  return text;
}

void Errand::wait(std::initializer_list<int> descriptors, Duration at_most) const {
  std::vector<pollfd> waits{{stop_.descriptor(), POLLIN, 0}};
  for (const int descriptor : descriptors) waits.push_back({descriptor, POLLIN, 0});
  if (due_) at_most = std::min(at_most, *due_ - clock_.now());
  ::poll(waits.data(), waits.size(), std::max(0, static_cast<int>(at_most / 1ms) + 1));
}

Result<json, int> Errand::read_goal() {
  auto found = library_.find(full_type_name(wish_.type, "action"));
  if (!found) return err(complain(found.error()));
  type_ = found.value().action;
  if (type_ == nullptr) {
    return err(complain({found.value().name(), "is not an action", "see " + wish_.whom.command("action list -t")}));
  }
  const std::string values =
      wish_.from_stdin ? std::string{std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()}
                       : wish_.goal;
  auto text = text::read_message_text(values, type_->goal(), clock_.wall_now());
  if (!text) return err(complain_of_usage(text.error()));
  msgs::AnyMessage goal{type_->goal()};
  if (auto read = msgs::from_json(text.value().json, type_->goal(), goal.get()); !read)
    return err(complain_of_usage(read.error()));
  return parse_json_or_discard(msgs::to_json(type_->goal(), goal.get()));
}

void Errand::warn_of_waiting(const std::map<std::string, ActionEnds>& actions, bool is_known) const {
  const std::vector<std::string> names = names_of(actions);
  const Problem why{"action " + name_, is_known ? "its server is not active" : "no server offers it yet",
                    is_known        ? "see " + wish_.whom.command("lifecycle nodes")
                    : names.empty() ? "no action is there; see " + wish_.whom.command("component list")
                                    : suggestion(name_, names)};
  std::fprintf(stderr, "nacelle: warning: %s\n", why.text().c_str());
}

Result<void, int> Errand::wait_for_server() {
  say(nullptr, "Waiting for an action server to become available...");
  const MonotonicTime began = clock_.now();
  for (bool told = false; !stop_.is_raised() && !is_late();) {
    auto graph = ask::Nodes{asking_}.graph();
    if (!graph) return err(complain(graph.error()));
    const auto actions = actions_of(graph.value());
    const auto found = actions.find(name_);
    if (!told && clock_.now() - began >= 2s) {
      told = true;
      warn_of_waiting(actions, found != actions.end());
    }
    if (found != actions.end() && !found->second.servers.empty() && found->second.types.count(type_->name) == 0) {
      return err(complain(
          {"action " + name_,
           "has the type " + join({found->second.types.begin(), found->second.types.end()}) + ", not " + type_->name,
           ""}));
    }
    for (const auto& service : graph.value()["services"]) {
      if (text_of(service, "name") == part(action::kSendGoal) && service["server"].get<bool>() &&
          service["open"].get<bool>())
        return {};
    }
    wait({}, 50ms);
  }
  if (stop_.is_raised()) return err(kFailed);
  return err(complain({"action " + name_, "has no active server", "see " + wish_.whom.command("action list")}));
}

int Errand::listen() {
  if (!wish_.feedback) return kDone;
  auto reply = listening_.call({{"verb", "topic.listen"},
                                {"topic", part(action::kFeedback)},
                                {"type", type_->feedback_message().name},
                                {"show", "json"}},
                               kAnswerLimit);
  return reply ? kDone : complain(reply.error());
}

Result<bool, int> Errand::offer(const json& goal) {
  say(nullptr, "Sending goal:\n     " + yaml_of(type_->goal(), goal));
  auto reply = asking_.call(call_of(action::kSendGoal, type_->send_goal().name,
                                    {{"goal_id", id_json()}, {"goal", goal}}, to_seconds(kAnswerLimit)),
                            2 * kAnswerLimit);
  if (!reply) return err(complain(reply.error()));
  const bool accepted = reply.value()["response"]["accepted"].get<bool>();
  const std::string id = action::to_string(id_);
  if (accepted) {
    say({{"event", "accepted"}, {"goal_id", id}, {"stamp", reply.value()["response"]["stamp"]}},
        "Goal accepted with ID: " + id + "\n");
  } else {
    say({{"event", "rejected"}, {"goal_id", id}}, "Goal was rejected.");
  }
  return accepted;
}

void Errand::show_feedback() {
  while (wish_.feedback) {
    auto frame = listening_.receive(0ns);
    if (!frame || !frame.value()) return;
    if (frame.value()->kind != control::FrameKind::Item) continue;
    const json message = parse_json_or_discard(as_text(frame.value()->payload));
    if (!message.is_object() || message["goal_id"] != id_json()) continue;  // another goal's
    const json& feedback = message["feedback"];
    say({{"event", "feedback"}, {"feedback", feedback}}, "Feedback:\n    " + yaml_of(type_->feedback(), feedback));
  }
}

int Errand::show_result(const json& response) {
  const auto status = static_cast<GoalStatus>(response["status"].get<int>());
  say({{"event", "result"}, {"status", to_text(status)}, {"result", response["result"]}},
      "Result:\n    " + yaml_of(type_->result(), response["result"]) +
          "\nGoal finished with status: " + to_text(status));
  return status == GoalStatus::Succeeded ? kDone : kFailed;
}

int Errand::wait_for_result() {
  const json request = call_of(action::kGetResult, type_->get_result().name, {{"goal_id", id_json()}}, kLongestGoal_s);
  if (auto sent = asking_.send(control::FrameKind::Request, request.dump()); !sent) return complain(sent.error());
  while (true) {
    if (stop_.is_raised()) return cancel("");
    if (is_late()) return cancel("it has not ended in time");
    // Without feedback nothing is asked there, and the container may close it.
    wait({asking_.descriptor(), wish_.feedback ? listening_.descriptor() : -1}, 1h);
    auto frame = asking_.receive(0ns);
    if (!frame) return complain(frame.error());
    // The container sends feedback that came before the result ahead of it.
    show_feedback();
    if (!frame.value() || frame.value()->kind != control::FrameKind::Reply) continue;
    const json reply = parse_json_or_discard(as_text(frame.value()->payload));
    if (reply.is_object() && reply.value("ok", false)) return show_result(reply["response"]);
    const json problem = reply.is_object() ? reply.value("problem", json::object()) : json::object();
    return complain(problem.get<Problem>());
  }
}

int Errand::cancel(const char* why) {
  say({{"event", "canceling"}}, "Canceling goal...");
  // The connection that waits for the result takes no other request.
  auto third = connect(wish_.whom);
  if (!third) return third.error();
  auto reply = third.value().call(call_of(action::kCancelGoal, "action_msgs/srv/CancelGoal",
                                          {{"goal_info", {{"goal_id", id_json()}}}}, to_seconds(kAnswerLimit)),
                                  2 * kAnswerLimit);
  if (!reply) return complain(reply.error());
  if (reply.value()["response"]["goals_canceling"].empty())
    return complain({"goal " + action::to_string(id_), "Failed to cancel goal", "its server refused, or it has ended"});
  say({{"event", "canceled"}}, "Goal canceled.");
  return *why == '\0' ? kFailed : complain({"goal " + action::to_string(id_), why, "it was canceled"});
}

int Errand::run() {
  auto goal = read_goal();
  if (!goal) return goal.error();
  if (auto there = wait_for_server(); !there) return there.error();
  if (const int code = listen(); code != kDone) return code;
  auto accepted = offer(goal.value());
  if (!accepted) return accepted.error();
  return accepted.value() ? wait_for_result() : kFailed;
}

}  // namespace

int send_goal(const GoalWish& wish) {
  auto asking = connect(wish.whom);
  if (!asking) return asking.error();
  auto listening = connect(wish.whom);
  if (!listening) return listening.error();
  return Errand{wish, std::move(asking).value(), std::move(listening).value()}.run();
}

}  // namespace nacelle::cli
