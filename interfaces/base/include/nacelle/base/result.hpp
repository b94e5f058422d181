// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <type_traits>
#include <utility>
#include <variant>

namespace nacelle {

/// Carries the reason of a failure into a Result; made by err().
template <typename E>
struct Err {
  E reason;
};

/// Marks a value as the reason of a failure: `return err(ParseFault::Empty);`.
template <typename E>
[[nodiscard]] constexpr Err<std::decay_t<E>> err(E&& reason) {
  return {std::forward<E>(reason)};
}

/// A value, or the reason why there is none.
///
/// Errors:  value() on a failure and error() on a success stop the process: both are bugs of the caller.
/// Threads: a value like any other.
template <typename T, typename E>
class [[nodiscard]] Result {
 public:
  using value_type = T;
  using error_type = E;

  // Implicit on purpose: `return value;` and `return err(reason);` are the two ways to make one.
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  template <typename F>
  requires std::is_constructible_v<E, F&&> Result(Err<F> failure)  // NOLINT(google-explicit-constructor)
      : state_(std::in_place_index<1>, std::move(failure.reason)) {}

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] T& value() & { return has_value() ? *std::get_if<0>(&state_) : misuse<T&>(); }
  [[nodiscard]] const T& value() const& { return has_value() ? *std::get_if<0>(&state_) : misuse<const T&>(); }
  [[nodiscard]] T&& value() && { return std::move(value()); }
  [[nodiscard]] T value_or(T other) const { return has_value() ? value() : std::move(other); }
  [[nodiscard]] const E& error() const& { return has_value() ? misuse<const E&>() : *std::get_if<1>(&state_); }
  [[nodiscard]] E&& error() && { return has_value() ? misuse<E&&>() : std::move(*std::get_if<1>(&state_)); }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  template <typename R>
  [[noreturn]] static R misuse() {
    std::abort();
  }
  std::variant<T, E> state_;
};

/// Success without a value, or the reason of the failure.
template <typename E>
class [[nodiscard]] Result<void, E> {
 public:
  using value_type = void;
  using error_type = E;

  Result() = default;
  template <typename F>
  requires std::is_constructible_v<E, F&&> Result(Err<F> failure)  // NOLINT(google-explicit-constructor)
      : state_(std::in_place_index<1>, std::move(failure.reason)) {}

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }
  [[nodiscard]] const E& error() const {
    if (has_value()) std::abort();
    return *std::get_if<1>(&state_);
  }

 private:
  std::variant<std::monostate, E> state_;
};

}  // namespace nacelle
