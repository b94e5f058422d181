// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/program.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/printable.hpp"
#include "offline_commands/commands.hpp"
#include "ros_import/ros_import.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr std::size_t kLargestFile = 1U << 20U;  // as for a launch file's parameter files

struct ImportWish {
  std::vector<std::string> files;
  std::string output;
  bool as_json = false;
};

std::string header(const ImportWish& wish) { return "# Written by `nacelle import " + join(wish.files, " ") + "`.\n"; }

int run(const ImportWish& wish) {
  if (const auto ok = ros_import::may_write(wish.output, wish.files); !ok) return complain(ok.error());
  ros_import::Imported imported;
  bool failed = false;
  for (const auto& path : wish.files) {
    const auto text = read_regular_file(path, kLargestFile);
    if (!text) {
      complain({path, text.error().what, "give a ROS 2 parameter file"});
      failed = true;
      continue;
    }
    const auto done = ros_import::import_file(*text, path, imported);
    if (done) continue;
    for (const auto& problem : done.error()) complain(problem);
    failed = true;
  }
  if (failed) return kFailed;
  const std::string yaml = header(wish) + imported.yaml();
  if (!wish.output.empty()) {
    if (const auto written = write_whole_file(wish.output, yaml); !written) return complain(written.error());
  }
  if (wish.as_json) {
    json rows = json::array();
    for (const auto& note : imported.notes)
      rows.push_back({{"fate", ros_import::to_text(note.fate)},
                      {"where", note.where},
                      {"node", note.node},
                      {"key", note.key},
                      {"text", note.text}});
    std::printf("%s\n", json{{"parameters", yaml}, {"keys", std::move(rows)}}.dump(2).c_str());
    return kDone;
  }
  if (wish.output.empty()) std::fputs(yaml.c_str(), stdout);
  for (const auto& note : imported.notes) std::fprintf(stderr, "%s\n", printable_entry(note.line()).c_str());
  return kDone;
}

}  // namespace

void add_import_command(Command& root) {
  const auto wish = std::make_shared<ImportWish>();
  Command& command = root.add("import", "convert parameter files of ROS 2 drivers");
  command
      .option("files", wish->files,
              "parameter files of diff_drive_controller and ros2_control, twist_mux,\n"
              "robot_localization, teleop_twist_joy, v4l2_camera, usb_cam or an LD06 driver")
      .required()
      .names_a(Names::File);
  command.option("-o,--output", wish->output, "write the parameters to this file instead of to stdout")
      .names_a(Names::File);
  command.flag("--json", wish->as_json, "print one JSON object: parameters, keys");
  command.note(
      "Prints one line per key to stderr: kept, translated, dropped, doubted, or added (ROS's default where Nacelle's\n"
      "differs). Check the doubted ones yourself; some are written only as comments.\n"
      "Exit codes: 0 success, 1 a file is not a parameter file or has no known driver, 2 wrong usage.");
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
