// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/type_library.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>
#include <system_error>

namespace nacelle::msgs {
namespace {

constexpr std::string_view kPrefix = "libnacelle_msgs_";
constexpr std::string_view kSuffix = ".so";
/// Libraries of ours that are named like a package's.
constexpr std::string_view kNotPackages[] = {"json", "registry", "runtime"};

std::vector<std::filesystem::path> with_environment(std::vector<std::filesystem::path> directories) {
  const char* const more = std::getenv("NACELLE_INTERFACE_PATH");
  std::string_view rest = more == nullptr ? "" : more;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (end != 0) directories.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return directories;
}

/// Of "libnacelle_msgs_std_msgs.so" and of "libnacelle_msgs_std_msgs.so.0.1", "std_msgs". Debian's packages install the name
/// without a version for compilers only.
std::optional<std::string> package_of(const std::string& file) {
  if (!file.starts_with(kPrefix)) return std::nullopt;
  const std::size_t end = file.rfind(kSuffix);
  if (end == std::string::npos || end < kPrefix.size()) return std::nullopt;
  const std::string version = file.substr(end + kSuffix.size());
  if (!version.empty() && (version.front() != '.' || version.find_first_not_of(".0123456789") != std::string::npos))
    return std::nullopt;
  const std::string name = file.substr(kPrefix.size(), end - kPrefix.size());
  if (std::find(std::begin(kNotPackages), std::end(kNotPackages), name) != std::end(kNotPackages)) return std::nullopt;
  return name;
}

/// Services and actions have parts that are services and messages; a list for people shows the whole only.
struct Names {
  std::set<std::string> all;
  std::set<std::string> derived;
};

void add_service(const ServiceType& service, Names& names) {
  for (const auto part : {service.request, service.response, service.event}) names.derived.insert(part().name);
}

Names names_of(const PackageTable& table) {
  Names names;
  for (const auto message : table.messages) names.all.insert(message().name);
  for (const auto service : table.services) {
    names.all.insert(service().name);
    add_service(service(), names);
  }
  for (const auto action_type : table.actions) {
    const ActionType& action = action_type();
    names.all.insert(action.name);
    for (const auto part : {action.goal, action.result, action.feedback, action.feedback_message}) {
      names.derived.insert(part().name);
    }
    for (const auto service : {action.send_goal, action.get_result}) names.derived.insert(service().name);
  }
  return names;
}

std::optional<Interface> find_in(const PackageTable& table, std::string_view name) {
  for (const auto message : table.messages) {
    if (message().name == name) return Interface{&message(), nullptr, nullptr};
  }
  for (const auto service : table.services) {
    if (service().name == name) return Interface{nullptr, &service(), nullptr};
  }
  for (const auto action : table.actions) {
    if (action().name == name) return Interface{nullptr, nullptr, &action()};
  }
  return std::nullopt;
}

}  // namespace

const char* Interface::name() const {
  return message != nullptr ? message->name : service != nullptr ? service->name : action->name;
}
const char* Interface::hash() const {
  return message != nullptr ? message->hash : service != nullptr ? service->hash : action->hash;
}
const char* Interface::definition() const {
  return message != nullptr ? message->definition : service != nullptr ? service->definition : action->definition;
}

std::filesystem::path TypeLibrary::own_folder() {
  Dl_info self{};
  if (::dladdr(reinterpret_cast<const void*>(&TypeLibrary::own_folder), &self) == 0 || self.dli_fname == nullptr)
    return {};
  return std::filesystem::path{self.dli_fname}.parent_path();
}

TypeLibrary::TypeLibrary(const std::vector<std::filesystem::path>& directories) {
  for (const auto& directory : with_environment(directories)) {
    std::error_code none;                    // A directory that does not exist holds no packages.
    std::set<std::filesystem::path> sorted;  // a name without a version before those with one
    for (const auto& entry : std::filesystem::directory_iterator(directory, none)) sorted.insert(entry.path());
    for (const auto& file : sorted) {
      if (const auto package = package_of(file.filename().string())) files_.try_emplace(*package, file);
    }
  }
}

std::vector<std::string> TypeLibrary::packages() const {
  std::vector<std::string> names;
  for (const auto& [name, file] : files_) names.push_back(name);
  return names;
}

Result<const PackageTable*, Problem> TypeLibrary::package(std::string_view name) {
  if (const auto known = loaded_.find(name); known != loaded_.end()) return known->second;
  const auto file = files_.find(name);
  const std::string where = "message package " + std::string(name);
  if (file == files_.end()) {
    return err(Problem{where, "there is no such package",
                       files_.empty()        ? "set NACELLE_INTERFACE_PATH to the directory of libnacelle_msgs_*.so"
                       : name == "nav2_msgs" ? "Debian's package nacelle-nav2-msgs has it"
                                             : suggestion(name, packages())});
  }
  // A library looks for those that it needs beside the path that is opened, which may be a symbolic link to elsewhere.
  std::error_code is_gone;
  const std::filesystem::path own_path = std::filesystem::canonical(file->second, is_gone);
  void* const library = dlopen(is_gone ? file->second.c_str() : own_path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return err(Problem{where, dlerror(), "is the package built for this version of Nacelle?"});
  // POSIX guarantees that a function pointer survives the way through dlsym's void*.
  const auto entry = reinterpret_cast<PackageEntry>(dlsym(library, kPackageEntry));
  if (entry == nullptr) {
    dlclose(library);
    return err(Problem{where, file->second.string() + " has no symbol " + kPackageEntry,
                       "make it with nacelle_generate_interfaces()"});
  }
  return loaded_.emplace(name, entry()).first->second;
}

Result<Interface, Problem> TypeLibrary::find(std::string_view name) {
  const std::string_view package_name = name.substr(0, name.find('/'));
  if (files_.contains(package_name)) {
    const auto table = package(package_name);
    if (!table) return err(table.error());
    if (const auto found = find_in(**table, name)) return *found;
  }
  return err(unknown_type(name));
}

Result<const MessageType*, Problem> TypeLibrary::message(std::string_view name) {
  const auto found = find(name);
  if (!found) return err(found.error());
  if (found->message != nullptr) return found->message;
  const std::string text{name};
  if (found->service != nullptr) {
    return err(Problem{text, "is a service",
                       "its messages are " + text + "_Request, " + text + "_Response and " + text + "_Event"});
  }
  return err(
      Problem{text, "is an action",
              "its messages are " + text + "_Goal, _Result, _Feedback, _FeedbackMessage, _SendGoal_Request and so on"});
}

Result<std::vector<std::string>, Problem> TypeLibrary::names(std::string_view package_name, bool with_derived) {
  const auto table = package(package_name);
  if (!table) return err(table.error());
  const Names names = names_of(**table);
  std::vector<std::string> result;
  for (const auto& name : names.all) {
    if (with_derived || !names.derived.contains(name)) result.push_back(name);
  }
  return result;
}

Problem TypeLibrary::unknown_type(std::string_view name) {
  std::vector<std::string> candidates;
  for (const auto& package_name : packages()) {
    const auto some = names(package_name, true);
    if (some) candidates.insert(candidates.end(), some->begin(), some->end());
  }
  const std::string near = nearest_name(name, candidates);
  return {"type " + std::string(name), "there is no such type",
          near.empty() ? "`nacelle interface list` shows all types" : "did you mean '" + near + "'?"};
}

}  // namespace nacelle::msgs
