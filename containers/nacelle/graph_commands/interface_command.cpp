// SPDX-License-Identifier: Apache-2.0
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"

#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

namespace nacelle::cli {
namespace {

/// What the person typed; lives as long as the commands do.
struct InterfaceWish {
  std::vector<std::filesystem::path> directories;
  std::string type;
  std::string package;
  bool all = false;
};

std::string standard_input() { return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()}; }

int list(const InterfaceWish& wish) {
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

/// "std_msgs/msg/Bool" from "std_msgs/Bool", as topic and service commands take it too. Other names are returned unchanged.
std::string whole_name(msgs::TypeLibrary& library, const std::string& name) {
  const auto slash = name.find('/');
  if (slash == std::string::npos || slash != name.rfind('/')) return name;
  for (const char* const kind : {"msg", "srv", "action"}) {
    std::string whole = name.substr(0, slash + 1) + kind + name.substr(slash);
    if (library.find(whole)) return whole;
  }
  return name;
}

int show(const InterfaceWish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto found = library.find(whole_name(library, wish.type));
  if (!found) return complain(found.error());
  std::cout << found->definition();
  return 0;
}

int hash(const InterfaceWish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto found = library.find(whole_name(library, wish.type));
  if (!found) return complain(found.error());
  std::cout << found->hash() << '\n';
  return 0;
}

int encode(const InterfaceWish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto type = library.message(whole_name(library, wish.type));
  if (!type) return complain(type.error());
  msgs::AnyMessage message{**type};
  if (const auto done = msgs::from_json(standard_input(), **type, message.get()); !done) return complain(done.error());
  std::cout << to_hex(message.encoded()) << '\n';
  return 0;
}

int decode(const InterfaceWish& wish) {
  msgs::TypeLibrary library{wish.directories};
  const auto type = library.message(whole_name(library, wish.type));
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

void add_interface_command(Command& root) {
  auto wish = std::make_shared<InterfaceWish>();
  wish->directories = message_library_directories();
  Command& command = root.add("interface", "show and convert message, service and action types");

  Command& list_command = command.add("list", "print the names of the types");
  list_command.option("--package", wish->package, "only this package's");
  list_command.flag("--all", wish->all, "also the messages that services and actions consist of");
  list_command.runs([wish] { return list(*wish); });

  const auto add = [&](const char* name, const char* what, int (*run)(const InterfaceWish&)) {
    Command& one = command.add(name, what);
    one.option("TYPE", wish->type, "e.g. sensor_msgs/msg/Imu, sensor_msgs/Imu or std_srvs/srv/SetBool_Request")
        .required()
        .names_a(Names::Type);
    one.runs([wish, run] { return run(*wish); });
  };
  add("show", "print the definition of a type", &show);
  add("hash", "print the RIHS01 hash of a type", &hash);
  add("encode", "read JSON and print CDR in hexadecimal", &encode);
  add("decode", "read CDR in hexadecimal and print JSON", &decode);
}

}  // namespace nacelle::cli
