// SPDX-License-Identifier: Apache-2.0
// A component's parameters, read and set from outside: always between two of its callbacks, on its executor.
#include <algorithm>

#include "container_impl.hpp"

namespace nacelle::runtime {
namespace {

Problem out_of_reach(const std::string& node) {
  return {node, "runs in a process of its own, where its parameters are out of reach",
          "set them in the launch file, or take `isolate: process` out"};
}

/// As rclcpp: only what was declared without a fixed type can be taken away.
std::string undeclare(ParameterStore& store, const std::string& name) {
  const ParameterDescriptor& descriptor = store.describe(name);
  if (descriptor.read_only) return "parameter '" + name + "' cannot be undeclared because it is read-only";
  if (!descriptor.dynamic_typing) return "parameter '" + name + "' has a fixed type: its node declares it and needs it";
  store.undeclare(name);
  return {};
}

std::string set(ParameterStore& store, const Parameter& parameter) {
  const std::string& name = parameter.get_name();
  if (!store.has(name)) return "there is no such parameter; " + suggestion(name, store.list());
  try {
    if (parameter.get_type() == ParameterType::NotSet) return undeclare(store, name);
    const auto done = store.set_atomically({parameter});
    return done.successful ? "" : done.reason;
  } catch (const std::exception& e) { return e.what(); }
}

// All or nothing, with rclcpp's words.
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
    all.push_back({name, value, type, descriptor, store.overrides().count(name) != 0});
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

/// Runs something between two callbacks of a component. Errors: nobody is there to run it.
Result<void, Problem> Container::Impl::post_to(std::uint64_t id, const char* name, std::function<void(Record&)> what) {
  // Under the lock: who unloads takes the runtime away.
  const std::lock_guard lock(mutex);
  if (const auto other = foreign.find(id); other != foreign.end()) return err(out_of_reach(other->second->info().node));
  const auto found = records.find(id);
  if (found == records.end())
    return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`"});
  Record& record = *found->second;
  if (record.hung) {
    return err(Problem{record.runtime->identity().fully_qualified(), "hangs: " + record.fault.lock()->text,
                       "see `nacelle faults`"});
  }
  // By reference: what is posted runs, or is dropped, before the record goes.
  record.runtime->post(name, patience, [&record, what = std::move(what)] { what(record); });
  return {};
}

Result<std::vector<ParameterReport>, Problem> Container::Impl::parameters_of(std::uint64_t id) const {
  // Under the lock: who is listed is not destroyed.
  const std::lock_guard lock(mutex);
  if (const auto other = foreign.find(id); other != foreign.end()) return err(out_of_reach(other->second->info().node));
  const auto found = records.find(id);
  if (found == records.end())
    return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`"});
  return report_of(found->second->node->parameters());
}

void Container::Impl::change_parameters(std::uint64_t id, std::vector<Parameter> parameters, bool atomically,
                                        std::weak_ptr<void> asker, const NodeServices::Then& then) {
  const auto change = [this, parameters = std::move(parameters), atomically, asker = std::move(asker),
                       then](Record& record) {
    if (!asker.lock()) return;
    auto results =
        set_in(record.node->parameters(), parameters, atomically, [&record](const std::vector<Parameter>& some) {
          auto request = record.request.lock();
          for (const auto& parameter : some) keep_in(*request, parameter);
        });
    note_change();
    then(std::move(results));
  };
  auto posted = post_to(id, "set_parameters", change);
  if (!posted) then(err(posted.error()));
}

void Container::read_parameters(std::uint64_t id, std::weak_ptr<void> asker, ParametersRead then) {
  const auto told = std::make_shared<const ParametersRead>(std::move(then));  // by whoever comes to it
  auto posted = impl_->post_to(id, "parameters", [asker = std::move(asker), told](Record& record) {
    if (asker.lock()) (*told)(report_of(record.node->parameters()));
  });
  if (!posted) (*told)(err(posted.error()));
}

void Container::set_parameters(std::uint64_t id, std::vector<Parameter> parameters, std::weak_ptr<void> asker,
                               ParametersSet then) {
  const auto told = std::make_shared<const ParametersSet>(std::move(then));
  const auto set_all = [impl = impl_.get(), parameters = std::move(parameters), asker = std::move(asker),
                        told](Record& record) {
    // Whoever has been told that it took too long must not see it done later.
    if (!asker.lock()) return;
    std::vector<ParameterOutcome> outcomes;
    for (const auto& parameter : parameters) {
      outcomes.push_back({parameter.get_name(), set(record.node->parameters(), parameter)});
      if (!outcomes.back().refusal.empty()) continue;
      keep_in(*record.request.lock(), parameter);
    }
    impl->note_change();
    (*told)(std::move(outcomes));
  };
  auto posted = impl_->post_to(id, "set_parameters", set_all);
  if (!posted) (*told)(err(posted.error()));
}

Result<void, Problem> Container::set_parameter(std::uint64_t id, const Parameter& parameter) {
  const auto record = impl_->record(id);
  if (!record)
    return err(
        Problem{"component " + std::to_string(id), "is not loaded in this process", "see `nacelle component list`"});
  const std::string node = record->runtime->identity().fully_qualified();
  if (std::string why = impl_->why_not_wait_for(*record); !why.empty())
    return err(Problem{node, "its parameters cannot be set from here", std::move(why)});
  const std::lock_guard alone(record->one_at_a_time);
  if (record->node == nullptr || record->given_up || record->hung)
    return err(Problem{node, "is not there any more, or hangs", "see `nacelle faults`"});
  const auto result = std::make_shared<Result<void, Problem>>();
  const bool ended = record->runtime->run_and_wait(
      "set_parameters",
      [record, parameter, node, result] {
        auto& store = record->node->parameters();
        const std::string where = node + ", parameter " + parameter.get_name();
        if (!store.has(parameter.get_name())) {
          *result = err(Problem{where, "there is no such parameter", suggestion(parameter.get_name(), store.list())});
          return;
        }
        try {
          const auto set = store.set_atomically({parameter});
          if (!set.successful) *result = err(Problem{where, set.reason, ""});
        } catch (const std::exception& e) { *result = err(Problem{where, e.what(), ""}); }
      },
      impl_->deadline());
  if (!ended) return err(Problem{node, "its callbacks leave no time to set a parameter", "see `nacelle faults`"});
  if (!*result) return err(result->error());
  record->request.lock()->parameters[parameter.get_name()] = parameter.get_parameter_value();
  impl_->note_change();
  return {};
}

}  // namespace nacelle::runtime
