// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>

namespace nacelle::process {

/// Writes "nacelle: container: WHAT: WHY" to stderr. Allocates: nothing.
void say_failed(const char* what, const char* why) noexcept;

/// Runs a step of a loop that must continue if the step fails for lack of memory, threads or descriptors. If the step
/// throws, reports the exception and returns false.
template <typename Act>
bool attempt(const char* what, const Act& act) {
  try {
    act();
    return true;
  } catch (const std::exception& failure) { say_failed(what, failure.what()); }
  return false;
}

}  // namespace nacelle::process
