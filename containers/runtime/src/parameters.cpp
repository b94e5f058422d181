// SPDX-License-Identifier: Apache-2.0
// Access to a component's parameters for its services: reads happen beside its callbacks, sets between two of them
// on its executor.
#include <algorithm>
#include <exception>

#include "container_impl.hpp"
#include "nacelle/base/name_fault.hpp"

namespace nacelle::runtime {
namespace {

// All or nothing, with rclcpp's texts.
SetParametersResult set_together(ParameterStore& store, const std::vector<Parameter>& parameters) {
  if (parameters.empty())
    return {false,
            "parameter list cannot be empty, this might be due to pre_set_parameters_callback modifying the original "
            "parameters list."};
  for (const auto& parameter : parameters) {
    if (parameter.get_name().empty()) return {false, "parameter name must not be empty"};
  }
  try {
    return store.set_atomically(parameters);
  } catch (const std::exception& e) { return {false, e.what()}; }
}

void keep_in(LoadRequest& request, const Parameter& parameter) {
  if (parameter.get_type() == ParameterType::NotSet) {
    request.parameters.erase(parameter.get_name());
  } else {
    request.parameters[parameter.get_name()] = parameter.get_parameter_value();
  }
}

}  // namespace

std::vector<ParameterReport> report_of(const ParameterStore& store) {
  std::vector<ParameterReport> all;
  store.for_each([&](const std::string& name, const ParameterValue& value, ParameterType type,
                     const ParameterDescriptor& descriptor) {
    all.push_back({name, value, type, descriptor});
  });
  return all;
}

std::vector<SetParametersResult> set_in(ParameterStore& store, const std::vector<Parameter>& parameters,
                                        bool atomically,
                                        const std::function<void(const std::vector<Parameter>&)>& on_set) {
  std::vector<SetParametersResult> results;
  const auto set_some = [&](const std::vector<Parameter>& some) {
    results.push_back(set_together(store, some));
    if (results.back().successful) on_set(some);
  };
  const auto is_unknown = [&](const Parameter& parameter) { return !store.has(parameter.get_name()); };
  if (!atomically) {
    for (const auto& parameter : parameters) set_some({parameter});
  } else if (std::ranges::any_of(parameters, is_unknown)) {
    results.push_back({false, "One or more parameters were not declared before setting"});
  } else {
    set_some(parameters);
  }
  return results;
}

Container::Impl::Found Container::Impl::find_node(std::uint64_t id) const {
  if (const auto found = records.find(id); found != records.end()) return {found->second.get(), found->second.get()};
  for (const auto& [component, record] : records) {
    auto others = record->others.lock();
    for (const auto& other : *others) {
      if (other->id == id) return {record.get(), other.get()};
    }
  }
  return {};
}

/// Runs something between two callbacks of a node. Errors: the component cannot run it.
Result<void, Problem> Container::Impl::post_to(std::uint64_t id, const char* name,
                                               std::function<void(Record&, NodeRecord&)> what) {
  // Under the lock, because an unload moves the runtime out.
  const LockGuard lock(mutex);
  const Found found = find_node(id);
  Record* const record = found.record;
  NodeRecord* const node = found.node;
  if (record == nullptr)
    return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`",
                       NameFault::Unknown, std::to_string(id)});
  if (record->hung) {
    return err(Problem{node->runtime->identity().fully_qualified(), "hangs: " + record->fault.lock()->text,
                       "see `nacelle faults`"});
  }
  // By reference: a posted task runs, or is dropped, before the records are destroyed.
  node->runtime->post(name, patience,
                      [&owner = *record, &target = *node, what = std::move(what)] { what(owner, target); });
  return {};
}

Result<std::vector<ParameterReport>, Problem> Container::Impl::parameters_of(std::uint64_t id) const {
  // Under the lock: a listed component is not destroyed meanwhile.
  const LockGuard lock(mutex);
  const auto [record, node] = find_node(id);
  if (record == nullptr)
    return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`",
                       NameFault::Unknown, std::to_string(id)});
  return report_of(*node->parameters);
}

void Container::Impl::change_parameters(std::uint64_t id, std::vector<Parameter> parameters, bool atomically,
                                        std::weak_ptr<void> asker, const NodeServices::Then& then) {
  const auto change = [this, parameters = std::move(parameters), atomically, asker = std::move(asker), then](
                          Record& record, NodeRecord& node) {
    if (!asker.lock()) return;
    // Parameters of other nodes are the code's: a restart begins with its values.
    const auto on_set = [&](const std::vector<Parameter>& some) {
      if (&node != &record) return;
      auto request = record.request.lock();
      for (const auto& parameter : some) keep_in(*request, parameter);
    };
    auto results = set_in(*node.parameters, parameters, atomically, on_set);
    note_change();
    then(std::move(results));
  };
  auto posted = post_to(id, "set_parameters", change);
  if (!posted) then(err(posted.error()));
}

}  // namespace nacelle::runtime
