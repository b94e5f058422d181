// SPDX-License-Identifier: Apache-2.0
#include "look/component/parameter_questions.hpp"

#include <map>
#include <utility>

#include "look/component/parameter_json.hpp"
#include "rcl_interfaces/srv/get_parameters.hpp"
#include "rcl_interfaces/srv/list_parameters.hpp"
#include "rcl_interfaces/srv/set_parameters.hpp"

namespace nacelle::look {
namespace {

namespace srv = rcl_interfaces::srv;

/// Calls a node's service; `take` gets null if there is no answer.
template <typename S>
void call(RobotRequests& requests, const std::string& name, typename S::Request request,
          std::function<void(const typename S::Response*)> take) {
  msgs::AnyMessage any{S::Request::message_type()};
  *static_cast<typename S::Request*>(any.get()) = std::move(request);
  requests.call(
      name, S::Request::message_type(), S::Response::message_type(), std::move(any),
      [take = std::move(take)](const void* response) { take(static_cast<const typename S::Response*>(response)); });
}

std::string no_answer(const std::string& node) { return node + ": the node does not answer"; }

}  // namespace

ParameterName parameter_name(const std::string& name) {
  const auto dot = name.find('.');
  return dot == std::string::npos ? ParameterName{name, ""} : ParameterName{name.substr(0, dot), name.substr(dot + 1)};
}

ParameterQuestions::Shared ParameterQuestions::begin(MonotonicTime now, Take take) {
  auto question = std::make_shared<Question>();
  question->take = std::move(take);
  question->until = now + kPatience;
  question->waiting = 1;  // until all are asked
  open_.push_back(question);
  return question;
}

void ParameterQuestions::get(const std::vector<std::string>& names, const std::vector<std::string>& nodes,
                             MonotonicTime now, Take take) {
  const Shared question = begin(now, std::move(take));
  if (names.empty()) {
    for (const std::string& node : nodes) list(question, node);
  }
  std::map<std::string, std::vector<std::string>> by_node;
  for (const std::string& name : names) {
    const auto [node, parameter] = parameter_name(name);
    by_node[node].push_back(parameter);
  }
  for (const auto& [node, parameters] : by_node) get(question, node, parameters);
  answered(question);
}

void ParameterQuestions::list(const Shared& question, const std::string& node) {
  ++question->waiting;
  call<srv::ListParameters>(requests_, node + "/list_parameters", {}, [=, this](const auto* response) {
    if (question->is_over) return;
    if (response == nullptr) {
      question->problems.push_back(no_answer(node));
    } else {
      std::vector<std::string> names;
      for (const auto& name : response->result.names) names.emplace_back(name);
      get(question, node, names);
    }
    answered(question);
  });
}

void ParameterQuestions::get(const Shared& question, const std::string& node, const std::vector<std::string>& names) {
  ++question->waiting;
  srv::GetParameters::Request request;
  for (const std::string& name : names) request.names.emplace_back(name);
  call<srv::GetParameters>(requests_, node + "/get_parameters", std::move(request), [=, this](const auto* response) {
    if (question->is_over) return;
    if (response == nullptr) {
      question->problems.push_back(no_answer(node));
    } else {
      // One unknown name makes the whole answer empty, as with rclcpp.
      for (std::size_t i = 0; i < names.size() && i < response->values.size(); ++i)
        question->parameters.push_back(parameter_json(node + "." + names[i], response->values[i]));
    }
    answered(question);
  });
}

void ParameterQuestions::set(const std::vector<SetParameters::One>& wishes, MonotonicTime now, Take take) {
  const Shared question = begin(now, std::move(take));
  std::map<std::string, srv::SetParameters::Request> by_node;
  for (const SetParameters::One& wish : wishes) {
    const auto value = parameter_value(wish.value, wish.type);
    const auto [node, parameter] = parameter_name(wish.name);
    if (!value) {
      question->problems.push_back(wish.name + ": is no value of a parameter");
      continue;
    }
    auto& one = by_node[node].parameters.emplace_back();
    one.name = parameter;
    one.value = *value;
  }
  for (const auto& [node, request] : by_node) {
    ++question->waiting;
    std::vector<std::string> names;
    for (const auto& one : request.parameters) names.emplace_back(one.name);
    const std::string of = node;
    call<srv::SetParameters>(requests_, node + "/set_parameters", request, [=, this](const auto* response) {
      if (question->is_over) return;
      if (response == nullptr) {
        question->problems.push_back(no_answer(of));
      } else {
        for (std::size_t i = 0; i < names.size() && i < response->results.size(); ++i) {
          if (!response->results[i].successful)
            question->problems.push_back(of + "." + names[i] + ": " + std::string{response->results[i].reason});
        }
        get(question, of, names);
      }
      answered(question);
    });
  }
  answered(question);
}

void ParameterQuestions::answered(const Shared& question) {
  if (--question->waiting == 0) end(*question);
}

void ParameterQuestions::end(Question& question) {
  question.is_over = true;
  question.take(std::move(question.parameters), question.problems);
}

bool ParameterQuestions::look_at_time(MonotonicTime now) {
  for (const Shared& question : open_) {
    if (question->is_over || now < question->until) continue;
    question->problems.emplace_back("some nodes do not answer: their parameters are missing");
    end(*question);
  }
  std::erase_if(open_, [](const Shared& question) { return question->is_over; });
  return !open_.empty();
}

}  // namespace nacelle::look
