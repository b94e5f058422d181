// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::runtime {

/// A plugin library in the address space. Ownership: the handle; close() gives it back.
class PluginLibrary {
 public:
  /// Errors: a Problem with the file and dlopen's reason, a missing entry point, or another ABI version.
  [[nodiscard]] static Result<std::unique_ptr<PluginLibrary>, Problem> open(const std::string& file);
  ~PluginLibrary();
  PluginLibrary(const PluginLibrary&) = delete;
  PluginLibrary& operator=(const PluginLibrary&) = delete;

  [[nodiscard]] const ComponentClass* find(const std::string& class_name) const;
  [[nodiscard]] std::vector<std::string> class_names() const;
  [[nodiscard]] const std::string& file() const { return file_; }
  /// True if the library is mapped into the process, by whomever.
  [[nodiscard]] static bool is_loaded(const std::string& file);

 private:
  PluginLibrary(std::string file, void* handle, const ComponentTable& table)
      : file_(std::move(file)), handle_(handle), table_(table) {}
  const std::string file_;
  void* const handle_;
  const ComponentTable& table_;
};

/// One line of a plugin folder's index/.
struct PluginEntry {
  std::string class_name, file;
};

/// The plugins that the folders offer, the first folder winning. Reads <folder>/index/*, lines of "class;library".
[[nodiscard]] std::vector<PluginEntry> find_plugins(const std::vector<std::string>& folders);

}  // namespace nacelle::runtime
