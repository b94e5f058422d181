// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/program.hpp"
#include "new_package/new_package.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

struct NewWish {
  std::string name, language = "cpp";
  bool driver = false, filter = false;
};

std::string wrong_package_name(const std::string& name) {
  const auto valid = new_package::check_name(name);
  return valid ? std::string{} : valid.error().what + "; " + valid.error().way_out;
}

/// Returns the library that an installation of the package in Nacelle's prefix would replace; empty if there is none.
std::string installed_library(const std::string& name) {
  std::error_code ignored;
  for (const auto& libraries : message_library_directories()) {
    const auto library = libraries / "nacelle" / ("nacelle_" + name + ".so");
    if (std::filesystem::exists(library, ignored)) return library.string();
  }
  return {};
}

int run(const NewWish& wish) {
  if (const std::string library = installed_library(wish.name); !library.empty())
    return complain({"name", "there is a component '" + wish.name + "' already: " + library,
                     "use another name, such as my_" + wish.name});
  const std::string examples = template_folder();
  if (examples.empty())
    return complain({"share/nacelle/templates", "is not installed", "install the package nacelle-dev"});
  const std::string example = wish.driver ? "range_driver" : wish.filter ? "mean_filter" : "talker";
  auto files = new_package::read_template((std::filesystem::path{examples} / example).string());
  if (!files) return complain(files.error());
  files = new_package::rename(std::move(files).value(), example, wish.name);
  if (!files) return complain_of_usage(files.error());
  if (const auto written = new_package::write(wish.name, files.value()); !written) return complain(written.error());
  for (const auto& file : files.value()) std::printf("%s/%s\n", wish.name.c_str(), file.path.c_str());
  std::printf("build and start it: %s/README.md\n", wish.name.c_str());
  return kDone;
}

}  // namespace

void add_new_command(Command& root) {
  const auto wish = std::make_shared<NewWish>();
  Command& command = root.add("new", "create packages")
                         .add("component", "create a package with a component, its test and a launch file");
  command.option("name", wish->name, "of the package, its folder, its namespace and its node: wheel_counter")
      .required()
      .checked(wrong_package_name);
  command.flag("--driver", wish->driver, "a driver that reads a serial line, instead of a publisher");
  command.flag("--filter", wish->filter, "a filter of a topic with a service, instead of a publisher")
      .not_with("--driver");
  command.option("--lang", wish->language, "programming language").one_of({"cpp"}).with_default();
  command.note(
      "Writes the folder NAME in the current one. It builds with CMake against an installed Nacelle, or with colcon.\n"
      "Exit codes: 0 success, 1 the folder exists or cannot be written, 2 wrong usage.");
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
