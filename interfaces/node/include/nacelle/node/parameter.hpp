// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/policies/parameter_value.hpp"

namespace nacelle {

/// Numbered as rcl_interfaces/msg/ParameterType.
enum class ParameterType : std::uint8_t {
  NotSet,
  Bool,
  Integer,
  Double,
  String,
  ByteArray,
  BoolArray,
  IntegerArray,
  DoubleArray,
  StringArray
};

[[nodiscard]] inline ParameterType type_of(const ParameterValue& value) {
  return static_cast<ParameterType>(value.index());
}
[[nodiscard]] const char* to_text(ParameterType type);
[[nodiscard]] std::string to_text(const ParameterValue& value);

/// An inclusive range; step 0 means any value in it.
struct IntegerRange {
  std::int64_t from = 0, to = 0;
  std::uint64_t step = 0;
};
struct FloatingPointRange {
  double from = 0, to = 0, step = 0;
};

/// rcl_interfaces/msg/ParameterDescriptor, in C++.
struct ParameterDescriptor {
  std::string description;
  std::string additional_constraints;
  bool read_only = false;
  bool dynamic_typing = false;
  std::optional<IntegerRange> integer_range = std::nullopt;
  std::optional<FloatingPointRange> floating_point_range = std::nullopt;
};

struct SetParametersResult {
  bool successful = true;
  std::string reason;
};

/// A value that a parameter cannot have, as the launch file gave it.
struct ParameterFault {
  Problem
      problem;  ///< `where` has the parameter, if it is one, and the line, if it stands in a file that a parameter names.
  bool is_warning = false;  ///< Worth a look; the component works all the same.
};
/// Whether one of them is more than a warning.
[[nodiscard]] bool has_errors(const std::vector<ParameterFault>& faults);
/// Where such faults go. Threads: any.
using ParameterFaults = Guarded<std::vector<ParameterFault>>;

/// A name with its value.
class Parameter {
 public:
  Parameter() = default;
  Parameter(std::string name, ParameterValue value) : name_(std::move(name)), value_(std::move(value)) {}

  [[nodiscard]] const std::string& get_name() const { return name_; }
  [[nodiscard]] ParameterType get_type() const { return type_of(value_); }
  [[nodiscard]] const ParameterValue& get_parameter_value() const { return value_; }
  [[nodiscard]] bool as_bool() const { return std::get<bool>(value_); }
  [[nodiscard]] std::int64_t as_int() const { return std::get<std::int64_t>(value_); }
  [[nodiscard]] double as_double() const { return std::get<double>(value_); }
  [[nodiscard]] const std::string& as_string() const { return std::get<std::string>(value_); }
  [[nodiscard]] const std::vector<double>& as_double_array() const { return std::get<std::vector<double>>(value_); }
  [[nodiscard]] const std::vector<std::string>& as_string_array() const {
    return std::get<std::vector<std::string>>(value_);
  }
  /// As the type that is asked for: int and float too. Errors: InvalidParameterType.
  template <typename T>
  [[nodiscard]] T get_value() const;

 private:
  std::string name_;
  ParameterValue value_;
};

namespace exceptions {
// rclcpp's named exceptions, so that code written for it reads the same.
struct ParameterAlreadyDeclaredException : std::runtime_error {
  using runtime_error::runtime_error;
};
struct ParameterNotDeclaredException : std::runtime_error {
  using runtime_error::runtime_error;
};
struct InvalidParameterTypeException : std::runtime_error {
  using runtime_error::runtime_error;
};
struct InvalidParameterValueException : std::runtime_error {
  using runtime_error::runtime_error;
};
struct ParameterImmutableException : std::runtime_error {
  using runtime_error::runtime_error;
};
struct InvalidNameError : std::runtime_error {
  explicit InvalidNameError(const Problem& problem) : std::runtime_error(problem.text()), name(problem.value) {}
  std::string name;  ///< That is wrong, as it was given.
};
}  // namespace exceptions

namespace detail {
// Maps what a caller writes (int, float, const char*) to the stored alternative.
template <typename T>
struct StoredAs {
  using type = T;
};
template <typename T>
requires(std::is_integral_v<T> && !std::is_same_v<T, bool>) struct StoredAs<T> {
  using type = std::int64_t;
};
template <typename T>
requires std::is_floating_point_v<T>
struct StoredAs<T> {
  using type = double;
};
template <>
struct StoredAs<const char*> {
  using type = std::string;
};
template <>
struct StoredAs<std::vector<int>> {
  using type = std::vector<std::int64_t>;
};
}  // namespace detail

template <typename T>
T Parameter::get_value() const {
  using Stored = typename detail::StoredAs<T>::type;
  const auto* const stored = std::get_if<Stored>(&value_);
  if (stored == nullptr)
    throw exceptions::InvalidParameterTypeException("parameter '" + name_ + "' is " + to_text(get_type()));
  if constexpr (std::is_same_v<T, std::vector<int>>) {
    return T(stored->begin(), stored->end());
  } else {
    return static_cast<T>(*stored);
  }
}

/// A callback that may refuse values, asked as long as this lives; as rclcpp's.
struct OnSetParametersCallbackHandle {
  using SharedPtr = std::shared_ptr<OnSetParametersCallbackHandle>;
  using Callback = std::function<SetParametersResult(const std::vector<Parameter>&)>;
  Callback callback;
};

/// rcl_interfaces/msg/ListParametersResult, in C++.
struct ListParametersResult {
  std::vector<std::string> names, prefixes;
};
/// Of these names, those below the prefixes (all for none), at most `depth` parts deep behind them (0: any), and the prefixes that
/// they have. Source: rcl_interfaces/srv/ListParameters.
[[nodiscard]] ListParametersResult listed(const std::vector<std::string>& names,
                                          const std::vector<std::string>& prefixes, std::uint64_t depth);

/// What has become of some parameters, in rcl_interfaces/msg/ParameterEvent's parts.
struct ParameterChange {
  std::vector<Parameter> declared, set, undeclared;  ///< With their values; of the last one, names only.
};

/// Told of changes. Threads: the component's executor, after the change; keep it short.
class ParameterListener {
 public:
  virtual ~ParameterListener() = default;
  virtual void on_change(const ParameterChange& change) noexcept = 0;
};

/// The declared parameters of one node: typed once, held in their ranges, watched by callbacks.
///
/// An integer override for a double parameter is taken as that double (a person writes `rate: 50`).
/// Errors:  rclcpp's named exceptions; texts name node, parameter, value and range.
/// Threads: one executor, but for for_each(); a component copies what its own threads need.
class ParameterStore {
 public:
  /// If `faults` is set, declare() records a refused override there and uses the default, so that `nacelle check` reports every
  /// mistake. Otherwise it throws at the first one.
  ParameterStore(std::string node, std::map<std::string, ParameterValue> overrides,
                 std::shared_ptr<ParameterFaults> faults = nullptr);

  const ParameterValue& declare(const std::string& name, ParameterValue value, ParameterType type,
                                ParameterDescriptor descriptor);
  [[nodiscard]] bool has(const std::string& name) const { return entries_.count(name) != 0; }
  [[nodiscard]] const ParameterValue& get(const std::string& name) const;
  [[nodiscard]] const ParameterDescriptor& describe(const std::string& name) const;
  [[nodiscard]] ParameterType declared_type(const std::string& name) const;
  /// Calls `what(name, value, type, descriptor)` for each parameter in the order of their names, under the store's lock: `what`
  /// must not call the store. Threads: any.
  template <typename F>
  void for_each(F&& what) const {
    const LockGuard lock(mutex_);
    for (const auto& [name, entry] : entries_) what(name, entry.value, entry.type, entry.descriptor);
  }
  /// Sets all parameters or none. A refusal has rclcpp's reason. As in rclcpp, the value "not set" undeclares a parameter of
  /// dynamic type.
  SetParametersResult set_atomically(const std::vector<Parameter>& parameters);
  void undeclare(const std::string& name);
  /// Undeclares a parameter of dynamic type that is not read-only. Errors: rclcpp's named exceptions.
  void undeclare_dynamic(const std::string& name);
  [[nodiscard]] std::vector<std::string> list() const;
  /// Records a fault that declare() cannot detect. Does nothing without `faults`.
  void note_fault(ParameterFault fault) const {
    if (faults_) faults_->lock()->push_back(std::move(fault));
  }
  [[nodiscard]] OnSetParametersCallbackHandle::SharedPtr add_on_set(OnSetParametersCallbackHandle::Callback callback);
  void remove_on_set(const OnSetParametersCallbackHandle* handle);
  /// Replaces the listener; null removes it. Threads: any, while no callback of the component runs.
  void set_listener(std::shared_ptr<ParameterListener> listener) { listener_ = std::move(listener); }

  [[nodiscard]] const std::map<std::string, ParameterValue>& overrides() const { return overrides_; }
  /// Returns overrides without a declared parameter: most likely misspelt names.
  [[nodiscard]] std::vector<std::string> unused_overrides() const;

 private:
  struct Entry {
    ParameterValue value;
    ParameterType type;
    ParameterDescriptor descriptor;
  };
  [[nodiscard]] std::string refusal(const std::string& name, const Entry& entry, const ParameterValue& value) const;
  void take_override(const std::string& name, Entry& entry, const ParameterValue& given) const;
  [[nodiscard]] ParameterChange commit(const std::vector<Parameter>& wanted);

  std::string node_;
  std::map<std::string, ParameterValue> overrides_;
  std::shared_ptr<ParameterFaults> faults_;
  mutable Mutex mutex_;  // held to change entries_, and to read them on another thread
  std::map<std::string, Entry> entries_;
  std::vector<std::weak_ptr<OnSetParametersCallbackHandle>> on_set_;
  std::shared_ptr<ParameterListener> listener_;
};

}  // namespace nacelle
