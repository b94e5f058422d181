// SPDX-License-Identifier: Apache-2.0
#include "parameter_services.hpp"

#include <algorithm>
#include <stdexcept>

#include "nacelle/runtime/parameter_messages.hpp"
#include "node_services.hpp"
#include "offer.hpp"

namespace nacelle::runtime {
namespace {

using rcl_interfaces::srv::DescribeParameters;
using rcl_interfaces::srv::GetParameters;
using rcl_interfaces::srv::GetParameterTypes;
using rcl_interfaces::srv::ListParameters;
using rcl_interfaces::srv::SetParameters;
using rcl_interfaces::srv::SetParametersAtomically;

/// Calls `take` with each of the named parameters. Returns false if one of them is not declared; some may have been
/// passed then.
template <typename Names, typename F>
bool for_named(const std::vector<ParameterReport>& all, const Names& names, F&& take) {
  for (const auto& name : names) {
    const auto found = std::ranges::find(all, name, &ParameterReport::name);
    if (found == all.end()) return false;
    take(*found);
  }
  return true;
}

rcl_interfaces::msg::SetParametersResult message_of(const SetParametersResult& result) {
  rcl_interfaces::msg::SetParametersResult message;
  message.successful = result.successful;
  message.reason = result.reason;
  return message;
}

// Errors: std::invalid_argument for an unknown type.
template <typename Sequence>
std::vector<Parameter> parameters_of(const Sequence& messages) {
  std::vector<Parameter> parameters;
  for (const auto& message : messages) parameters.emplace_back(message.name, value_of(message.name, message.value));
  return parameters;
}

}  // namespace

rcl_interfaces::msg::ListParametersResult listed(const std::vector<std::string>& names,
                                                 const ListParameters::Request& wish) {
  static_assert(ListParameters::Request::DEPTH_RECURSIVE == 0);
  auto found = nacelle::listed(names, {wish.prefixes.begin(), wish.prefixes.end()}, wish.depth);
  rcl_interfaces::msg::ListParametersResult result;
  result.names.assign(found.names.begin(), found.names.end());
  result.prefixes.assign(found.prefixes.begin(), found.prefixes.end());
  return result;
}

std::vector<ParameterReport> ParameterServices::read() const {
  auto all = desk_.parameters(id_);
  return all ? std::move(all).value() : std::vector<ParameterReport>{};
}

void ParameterServices::start(NodeRuntime& node, const std::shared_ptr<ParameterServices>& self) {
  self_ = self;
  describe_ = offer<DescribeParameters>(
      node, "describe_parameters",
      [this](const DescribeParameters::Request& asked, DescribeParameters::Response& told) {
        told = {};
        const auto take = [&](const ParameterReport& one) { told.descriptors.push_back(descriptor_of(one)); };
        if (!for_named(read(), asked.names, take)) told.descriptors.clear();
      });
  types_ = offer<GetParameterTypes>(node, "get_parameter_types",
                                    [this](const GetParameterTypes::Request& asked, GetParameterTypes::Response& told) {
                                      told = {};
                                      const auto take = [&](const ParameterReport& one) {
                                        told.types.push_back(static_cast<std::uint8_t>(type_of(one.value)));
                                      };
                                      if (!for_named(read(), asked.names, take)) told.types.clear();
                                    });
  get_ = offer<GetParameters>(
      node, "get_parameters", [this](const GetParameters::Request& asked, GetParameters::Response& told) {
        told = {};
        bool all_set = true;
        const auto take = [&](const ParameterReport& one) {
          all_set = all_set && (type_of(one.value) != ParameterType::NotSet || one.descriptor.dynamic_typing);
          told.values.push_back(runtime::message_of(one.value));
        };
        if (!for_named(read(), asked.names, take) || !all_set) told.values.clear();
      });
  list_ = offer<ListParameters>(node, "list_parameters",
                                [this](const ListParameters::Request& asked, ListParameters::Response& told) {
                                  std::vector<std::string> names;
                                  for (const auto& one : read()) names.push_back(one.name);
                                  told.result = listed(names, asked);
                                });
  set_ = offer<SetParameters>(node, "set_parameters",
                              [this](const RequestId& id, const SetParameters::Request& asked) { set(id, asked); });
  set_atomically_ = offer<SetParametersAtomically>(
      node, "set_parameters_atomically",
      [this](const RequestId& id, const SetParametersAtomically::Request& asked) { set(id, asked); });
}

void ParameterServices::set(const RequestId& id, const SetParameters::Request& request) {
  // An unreadable one is refused at its position, and the others are set.
  std::vector<Parameter> wanted;
  std::vector<std::string> unreadable;  // the reason, or empty
  for (const auto& message : request.parameters) {
    try {
      wanted.emplace_back(message.name, value_of(message.name, message.value));
      unreadable.emplace_back();
    } catch (const std::invalid_argument& e) { unreadable.emplace_back(e.what()); }
  }
  const auto answer = [self = self_, id, unreadable = std::move(unreadable)](auto done) {
    const auto services = self.lock();
    if (!services) return;
    SetParameters::Response response;
    std::size_t next = 0;
    for (const auto& why : unreadable) {
      const bool is_read = why.empty();
      SetParametersResult result{false, is_read && !done ? done.error().text() : why};
      if (is_read && done) result = done.value()[next++];
      response.results.push_back(message_of(result));
    }
    services->set_->send_response(id, std::move(response));
  };
  desk_.set_parameters(id_, std::move(wanted), false, self_, answer);
}

void ParameterServices::set(const RequestId& id, const SetParametersAtomically::Request& request) {
  const auto answer = [self = self_, id](auto done) {
    const auto services = self.lock();
    if (!services) return;
    SetParametersAtomically::Response response;
    response.result = message_of(done ? done.value().front() : SetParametersResult{false, done.error().text()});
    services->set_atomically_->send_response(id, std::move(response));
  };
  try {
    desk_.set_parameters(id_, parameters_of(request.parameters), true, self_, answer);
  } catch (const std::invalid_argument& e) {
    answer(Result<std::vector<SetParametersResult>, Problem>{std::vector<SetParametersResult>{{false, e.what()}}});
  }
}

}  // namespace nacelle::runtime
