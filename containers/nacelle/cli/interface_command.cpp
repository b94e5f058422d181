// SPDX-License-Identifier: Apache-2.0
#include "interface_command.hpp"

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"

#include <CLI/CLI.hpp>

#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

namespace nacelle::cli {
namespace {

/// What the person typed; lives as long as the commands do.
struct Wish {
  std::vector<std::filesystem::path> directories;
  std::string type;
  std::string package;
  bool all = false;
};

int complain(const Problem& problem) {
  std::cerr << problem.text() << '\n';
  return 1;
}

std::string standard_input() { return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()}; }

int list(const Wish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto packages = wish.package.empty() ? library.packages() : std::vector<std::string>{wish.package};
  if (packages.empty()) {
    return complain({"message packages", "there is no libnacelle_msgs_*.so in the directories searched",
                     "set NACELLE_INTERFACE_PATH to where they are"});
  }
  for (const auto& package : packages) {
    const auto names = library.names(package, wish.all);
    if (!names) return complain(names.error());
    for (const auto& name : *names) std::cout << name << '\n';
  }
  return 0;
}

int show(const Wish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto found = library.find(wish.type);
  if (!found) return complain(found.error());
  std::cout << found->definition();
  return 0;
}

int hash(const Wish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto found = library.find(wish.type);
  if (!found) return complain(found.error());
  std::cout << found->hash() << '\n';
  return 0;
}

int encode(const Wish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto type = library.message(wish.type);
  if (!type) return complain(type.error());
  msgs::AnyMessage message{**type};
  if (const auto done = msgs::from_json(standard_input(), **type, message.get()); !done) return complain(done.error());
  std::cout << to_hex(message.encoded()) << '\n';
  return 0;
}

int decode(const Wish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto type = library.message(wish.type);
  if (!type) return complain(type.error());
  Bytes bytes;
  if (!from_hex(standard_input(), bytes)) {
    return complain({"standard input", "is not hexadecimal (0-9 a-f, two digits a byte)", ""});
  }
  msgs::AnyMessage message{**type};
  if (const auto done = (*type)->decode(bytes, message.get()); !done) {
    return complain(
        {std::to_string(bytes.size()) + " bytes", std::string("are no ") + wish.type, msgs::explain(done.error())});
  }
  std::cout << msgs::to_json(**type, message.get()) << '\n';
  return 0;
}

}  // namespace

std::vector<std::filesystem::path> message_library_directories() {
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (unknown) return {};
  const auto prefix = program.parent_path().parent_path();
  std::vector<std::filesystem::path> directories{prefix / "lib"};
  for (const auto& entry : std::filesystem::directory_iterator(prefix / "lib", unknown)) {
    // Debian's multi-architecture folders: lib/aarch64-linux-gnu.
    if (entry.path().filename().string().ends_with("-linux-gnu")) directories.push_back(entry.path());
  }
  return directories;
}

void add_interface_command(CLI::App& app, int& exit_code, std::vector<std::filesystem::path> library_directories) {
  auto wish = std::make_shared<Wish>();
  wish->directories = std::move(library_directories);
  CLI::App* const command = app.add_subcommand("interface", "Message, service and action types, and their wire form");
  command->require_subcommand(1);

  CLI::App* const list_command = command->add_subcommand("list", "Print the names of the types");
  list_command->add_option("--package", wish->package, "Only this package's");
  list_command->add_flag("--all", wish->all, "Also the messages that services and actions consist of");
  list_command->callback([wish, &exit_code] { exit_code = list(*wish); });

  const auto add = [&](const char* name, const char* what, int (*run)(const Wish&)) {
    CLI::App* const one = command->add_subcommand(name, what);
    one->add_option("TYPE", wish->type, "For example sensor_msgs/msg/Imu or std_srvs/srv/SetBool_Request")->required();
    one->callback([wish, run, &exit_code] { exit_code = run(*wish); });
  };
  add("show", "Print the definition", &show);
  add("hash", "Print the RIHS01 hash", &hash);
  add("encode", "Read JSON, print CDR in hexadecimal", &encode);
  add("decode", "Read CDR in hexadecimal, print JSON", &decode);
}

}  // namespace nacelle::cli
