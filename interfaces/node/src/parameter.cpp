// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/parameter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/reversed.hpp"

namespace nacelle {
namespace {

// rclcpp's equality for ranges: relative to the magnitude, a hundred units in the last place.
bool about_equal(double x, double y) {
  return std::abs(x - y) <= std::numeric_limits<double>::epsilon() * std::abs(x + y) * 100;
}

bool in_range(const FloatingPointRange& range, double v) {
  if (about_equal(v, range.from) || about_equal(v, range.to)) return true;
  if (!(v > range.from && v < range.to)) return false;  // also refuses NaN
  if (range.step == 0.0) return true;
  return about_equal(v, range.from + std::round((v - range.from) / range.step) * range.step);
}

bool in_range(const IntegerRange& range, std::int64_t v) {
  if (v == range.from || v == range.to) return true;
  if (v < range.from || v > range.to) return false;
  return range.step == 0 || (static_cast<std::uint64_t>(v) - static_cast<std::uint64_t>(range.from)) % range.step == 0;
}

// A person writes `rate: 50` for a double, and `[1, 2]` for doubles.
ParameterValue widened(ParameterValue value, ParameterType type) {
  if (type == ParameterType::Double && type_of(value) == ParameterType::Integer) {
    return static_cast<double>(std::get<std::int64_t>(value));
  }
  if (type == ParameterType::DoubleArray && type_of(value) == ParameterType::IntegerArray) {
    const auto& whole = std::get<std::vector<std::int64_t>>(value);
    return std::vector<double>(whole.begin(), whole.end());
  }
  return value;
}

bool is_shallow(std::string_view name, std::uint64_t depth) {
  return static_cast<std::uint64_t>(std::ranges::count(name, '.')) < depth;
}

bool is_listed(const std::string& name, const std::vector<std::string>& prefixes, std::uint64_t depth) {
  if (prefixes.empty()) return depth == 0 || is_shallow(name, depth);
  return std::ranges::any_of(prefixes, [&](const std::string& prefix) {
    if (name == prefix) return true;
    if (!name.starts_with(prefix + ".")) return false;
    return depth == 0 || is_shallow(std::string_view{name}.substr(prefix.size() + 1), depth);
  });
}

template <typename T>
std::string list_text(const std::vector<T>& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

}  // namespace

ListParametersResult listed(const std::vector<std::string>& names, const std::vector<std::string>& prefixes,
                            std::uint64_t depth) {
  ListParametersResult result;
  for (const auto& name : names) {
    if (!is_listed(name, prefixes, depth)) continue;
    result.names.push_back(name);
    const auto dot = name.rfind('.');
    if (dot == std::string::npos) continue;
    const std::string prefix = name.substr(0, dot);
    if (std::ranges::find(result.prefixes, prefix) == result.prefixes.end()) result.prefixes.push_back(prefix);
  }
  return result;
}

const char* to_text(ParameterType type) {
  static constexpr const char* kNames[] = {"not set",    "bool",       "integer",       "double",       "string",
                                           "byte array", "bool array", "integer array", "double array", "string array"};
  return kNames[static_cast<std::size_t>(type)];
}

std::string to_text(const ParameterValue& value) {
  struct Print {
    std::string operator()(std::monostate) const { return "(not set)"; }
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const { return fmt::format("{}", v); }
    std::string operator()(const std::string& v) const { return v; }
    std::string operator()(const std::vector<std::uint8_t>& v) const { return list_text(v); }
    std::string operator()(const std::vector<bool>& v) const { return list_text(std::vector<int>(v.begin(), v.end())); }
    std::string operator()(const std::vector<std::int64_t>& v) const { return list_text(v); }
    std::string operator()(const std::vector<double>& v) const { return list_text(v); }
    std::string operator()(const std::vector<std::string>& v) const { return list_text(v); }
  };
  return std::visit(Print{}, value);
}

ParameterStore::ParameterStore(std::string node, std::map<std::string, ParameterValue> overrides,
                               std::shared_ptr<ParameterFaults> faults)
    : node_(std::move(node)), overrides_(std::move(overrides)), faults_(std::move(faults)) {}

std::string ParameterStore::refusal(const std::string& name, const Entry& entry, const ParameterValue& value) const {
  if (!entry.descriptor.dynamic_typing && type_of(value) != entry.type) {
    return fmt::format("Wrong parameter type, parameter {{{}}} is of type {{{}}}, setting it to {{{}}} is not allowed.",
                       name, to_text(entry.type), to_text(type_of(value)));
  }
  if (const auto& range = entry.descriptor.integer_range; range && type_of(value) == ParameterType::Integer) {
    if (!in_range(*range, std::get<std::int64_t>(value))) {
      return fmt::format("Parameter {{{}}} doesn't comply with integer range: {} is not in {} to {}{}.", name,
                         to_text(value), range->from, range->to,
                         range->step == 0 ? "" : fmt::format(" in steps of {}", range->step));
    }
  }
  if (const auto& range = entry.descriptor.floating_point_range; range && type_of(value) == ParameterType::Double) {
    if (!in_range(*range, std::get<double>(value))) {
      return fmt::format("Parameter {{{}}} doesn't comply with floating point range: {} is not in {} to {}{}.", name,
                         to_text(value), range->from, range->to,
                         range->step == 0 ? "" : fmt::format(" in steps of {}", range->step));
    }
  }
  return {};
}

void ParameterStore::take_override(const std::string& name, Entry& entry, const ParameterValue& given) const {
  const ParameterType type = entry.type;
  ParameterValue wanted = widened(given, type);
  if (!entry.descriptor.dynamic_typing && type_of(wanted) != type) {
    std::string what = fmt::format("parameter '{}' is {} but was given {} ({})", name, to_text(type),
                                   to_text(type_of(wanted)), to_text(wanted));
    const std::string_view wanted_type = to_text(type);
    const bool has_vowel = std::string_view{"aeiou"}.find(wanted_type.front()) != std::string_view::npos;
    std::string way_out = fmt::format("write {} {} value", has_vowel ? "an" : "a", wanted_type);
    if (faults_) return note_fault({{Place::of_parameter(name, node_), std::move(what), std::move(way_out)}});
    throw exceptions::InvalidParameterTypeException(fmt::format("node {}: {}; {}", node_, what, way_out));
  }
  if (faults_) {
    if (std::string why = refusal(name, entry, wanted); !why.empty())
      return note_fault(
          {{Place::of_parameter(name, node_), std::move(why), fmt::format("its default is {}", to_text(entry.value))}});
  }
  entry.value = std::move(wanted);
}

const ParameterValue& ParameterStore::declare(const std::string& name, ParameterValue value, ParameterType type,
                                              ParameterDescriptor descriptor) {
  if (entries_.count(name) != 0) {
    throw exceptions::ParameterAlreadyDeclaredException(
        fmt::format("node {}: parameter '{}' has already been declared", node_, name));
  }
  Entry entry{std::move(value), type, std::move(descriptor)};
  const bool optional = type_of(entry.value) == ParameterType::NotSet;
  if (const auto given = overrides_.find(name); given != overrides_.end()) take_override(name, entry, given->second);
  if (!(optional && type_of(entry.value) == ParameterType::NotSet)) {
    if (const auto why = refusal(name, entry, entry.value); !why.empty()) {
      throw exceptions::InvalidParameterValueException(fmt::format("node {}: {}", node_, why));
    }
  }
  const ParameterValue* declared = nullptr;
  {
    const LockGuard lock(mutex_);
    declared = &entries_.emplace(name, std::move(entry)).first->second.value;
  }
  if (listener_) listener_->on_change({{{name, *declared}}, {}, {}});
  return *declared;
}

const ParameterValue& ParameterStore::get(const std::string& name) const {
  const auto entry = entries_.find(name);
  if (entry == entries_.end()) {
    throw exceptions::ParameterNotDeclaredException(
        fmt::format("node {}: parameter '{}' is not declared; {}", node_, name, suggestion(name, list())));
  }
  return entry->second.value;
}

const ParameterDescriptor& ParameterStore::describe(const std::string& name) const {
  static_cast<void>(get(name));  // throws for an unknown name
  return entries_.at(name).descriptor;
}

ParameterType ParameterStore::declared_type(const std::string& name) const {
  static_cast<void>(get(name));
  return entries_.at(name).type;
}

SetParametersResult ParameterStore::set_atomically(const std::vector<Parameter>& parameters) {
  std::vector<Parameter> wanted;
  for (const auto& parameter : parameters) {
    const auto& name = parameter.get_name();
    const auto found = entries_.find(name);
    if (found == entries_.end())
      return {false, fmt::format("parameter '{}' cannot be set because it was not declared", name)};
    if (found->second.descriptor.read_only)
      return {false, fmt::format("parameter '{}' cannot be set because it is read-only", name)};
    ParameterValue value = widened(parameter.get_parameter_value(), found->second.type);
    if (type_of(value) == ParameterType::NotSet && type_of(found->second.value) != ParameterType::NotSet &&
        !found->second.descriptor.dynamic_typing)
      return {false, "cannot undeclare a statically typed parameter"};
    if (const auto why = refusal(name, found->second, value); !why.empty()) return {false, why};
    wanted.emplace_back(name, std::move(value));
  }
  std::erase_if(on_set_, [](const auto& handle) { return handle.expired(); });
  const auto handles = on_set_;  // a callback may add one
  for (const auto& weak : reversed(handles)) {
    const auto handle = weak.lock();
    if (!handle) continue;
    if (auto result = handle->callback(wanted); !result.successful) return result;
  }
  const ParameterChange change = commit(wanted);
  if (listener_) listener_->on_change(change);
  return {};
}

ParameterChange ParameterStore::commit(const std::vector<Parameter>& wanted) {
  ParameterChange change;
  const LockGuard lock(mutex_);
  for (const auto& parameter : wanted) {
    const auto found = entries_.find(parameter.get_name());
    if (found == entries_.end()) continue;  // twice in the list, and undeclared by the first
    const bool goes =
        parameter.get_type() == ParameterType::NotSet && type_of(found->second.value) != ParameterType::NotSet;
    if (listener_) (goes ? change.undeclared : change.set).push_back(parameter);
    if (goes) {
      entries_.erase(found);
    } else {
      found->second.value = parameter.get_parameter_value();
    }
  }
  return change;
}

void ParameterStore::undeclare(const std::string& name) {
  {
    const LockGuard lock(mutex_);
    if (entries_.erase(name) == 0) return;
  }
  if (listener_) listener_->on_change({{}, {}, {{name, ParameterValue{}}}});
}

void ParameterStore::undeclare_dynamic(const std::string& name) {
  const ParameterDescriptor& descriptor = describe(name);
  if (descriptor.read_only)
    throw exceptions::ParameterImmutableException(
        fmt::format("node {}: parameter '{}' cannot be undeclared because it is read-only", node_, name));
  if (!descriptor.dynamic_typing)
    throw exceptions::InvalidParameterTypeException(
        fmt::format("node {}: parameter '{}' cannot be undeclared because its type is fixed", node_, name));
  undeclare(name);
}

OnSetParametersCallbackHandle::SharedPtr ParameterStore::add_on_set(OnSetParametersCallbackHandle::Callback callback) {
  auto handle = std::make_shared<OnSetParametersCallbackHandle>();
  handle->callback = std::move(callback);
  on_set_.push_back(handle);
  return handle;
}

void ParameterStore::remove_on_set(const OnSetParametersCallbackHandle* handle) {
  std::erase_if(on_set_, [handle](const auto& weak) { return weak.lock().get() == handle; });
}

std::vector<std::string> ParameterStore::list() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

std::vector<std::string> ParameterStore::unused_overrides() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : overrides_) {
    if (entries_.count(name) == 0) names.push_back(name);
  }
  return names;
}

bool has_errors(const std::vector<ParameterFault>& faults) {
  return std::any_of(faults.begin(), faults.end(), [](const ParameterFault& fault) { return !fault.is_warning; });
}

}  // namespace nacelle
