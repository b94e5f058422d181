// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/plugin_library.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>

namespace nacelle::runtime {
namespace {

std::string last_dl_error() {
  const char* const text = dlerror();
  return text != nullptr ? text : "unknown reason";
}

std::span<const ComponentClass> classes_of(const ComponentTable& table) { return {table.classes, table.class_count}; }

}  // namespace

Result<std::unique_ptr<PluginLibrary>, Problem> PluginLibrary::open(const std::string& file) {
  void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    return err(Problem{file, "cannot be loaded: " + last_dl_error(),
                       "build or install it for this version of Nacelle (`ldd " + file + "` shows what is missing)"});
  }
  using Entry = const ComponentTable* (*)();
  const auto entry = reinterpret_cast<Entry>(dlsym(handle, kComponentEntry));
  if (entry == nullptr) {
    dlclose(handle);
    return err(Problem{file, std::string("is no component library: it has no symbol ") + kComponentEntry,
                       "end one source file with NACELLE_REGISTER_COMPONENT(Class)"});
  }
  const ComponentTable* const table = entry();
  if (table == nullptr || table->abi != kComponentAbi) {
    const std::string version = table == nullptr ? "none" : std::to_string(table->abi);
    dlclose(handle);
    return err(Problem{
        file, "was built for component ABI " + version + ", this container has " + std::to_string(kComponentAbi),
        "build it again"});
  }
  return std::unique_ptr<PluginLibrary>(new PluginLibrary(file, handle, *table));
}

PluginLibrary::~PluginLibrary() { dlclose(handle_); }

const ComponentClass* PluginLibrary::find(const std::string& class_name) const {
  for (const auto& candidate : classes_of(table_)) {
    if (class_name == candidate.name) return &candidate;
  }
  return nullptr;
}

std::vector<std::string> PluginLibrary::class_names() const {
  std::vector<std::string> names;
  for (const auto& candidate : classes_of(table_)) names.emplace_back(candidate.name);
  return names;
}

bool PluginLibrary::is_loaded(const std::string& file) {
  void* const handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_NOLOAD);
  if (handle == nullptr) return false;
  dlclose(handle);
  return true;
}

std::vector<PluginEntry> find_plugins(const std::vector<std::string>& folders) {
  namespace fs = std::filesystem;
  std::vector<PluginEntry> found;
  for (const auto& folder : folders) {
    std::error_code ignored;
    std::vector<fs::path> files;
    for (const auto& file : fs::directory_iterator(fs::path(folder) / "index", ignored)) files.push_back(file.path());
    std::ranges::sort(files);
    for (const auto& file : files) {
      std::ifstream lines(file);
      for (std::string line; std::getline(lines, line);) {
        const auto semicolon = line.find(';');
        if (semicolon == std::string::npos) continue;
        std::string name = line.substr(0, semicolon);
        if (std::ranges::find(found, name, &PluginEntry::class_name) != found.end()) continue;
        found.push_back({std::move(name), (fs::path(folder) / line.substr(semicolon + 1)).string()});
      }
    }
  }
  return found;
}

}  // namespace nacelle::runtime
