// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/message_type.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace nacelle::msgs {

/// What a type name stands for: exactly one of the three is set.
struct Interface {
  const MessageType* message = nullptr;
  const ServiceType* service = nullptr;
  const ActionType* action = nullptr;

  [[nodiscard]] const char* name() const;
  [[nodiscard]] const char* hash() const;
  [[nodiscard]] const char* definition() const;
};

/// Finds types by name at run time in the message packages' libraries (libnacelle_msgs_<package>.so).
///
/// A library is loaded when a name of its package is first asked for, and stays until the process ends: types handed
/// out are valid for ever.
/// Threads: one at a time.
class TypeLibrary {
 public:
  /// Looks in these directories, then in those of the environment variable NACELLE_INTERFACE_PATH (separated by ':').
  explicit TypeLibrary(const std::vector<std::filesystem::path>& directories);

  /// Returns the folder of this library's own file, where the packages that were installed with it are.
  [[nodiscard]] static std::filesystem::path own_folder();

  /// The names of the packages, sorted. A library that is none of ours appears too until it is asked for.
  [[nodiscard]] std::vector<std::string> packages() const;
  /// The types of a package.
  [[nodiscard]] Result<const PackageTable*, Problem> package(std::string_view name);
  /// Any type, derived ones (_Request, _Event, _SendGoal, ...) included.
  [[nodiscard]] Result<Interface, Problem> find(std::string_view name);
  /// A message; a service or an action is a problem that names its messages.
  [[nodiscard]] Result<const MessageType*, Problem> message(std::string_view name);
  /// All type names of a package, sorted; those of derived types only on request.
  [[nodiscard]] Result<std::vector<std::string>, Problem> names(std::string_view package, bool with_derived);

 private:
  [[nodiscard]] Problem unknown_type(std::string_view name);

  std::map<std::string, std::filesystem::path, std::less<>> files_;
  std::map<std::string, const PackageTable*, std::less<>> loaded_;
};

}  // namespace nacelle::msgs
