// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "recording_commands/bag_check.hpp"
#include "recording_commands/bag_info.hpp"
#include "recording_commands/bag_recover.hpp"
#include "recording_commands/commands.hpp"

namespace nacelle::cli {
namespace {

void add_info(Command& group) {
  auto wish = std::make_shared<BagInfoWish>();
  Command& command =
      group.add("info", "what a recording has, as `ros2 bag info`, and each topic's rate and longest gap");
  command.option("bag", wish->path, "an MCAP file, or the folder that `ros2 bag record` made")
      .required()
      .names_a(Names::File);
  command.flag("--json", wish->as_json, "print JSON");
  command.runs([wish] { return print_bag_info(*wish); });
}

void add_check(Command& group) {
  auto wish = std::make_shared<BagCheckWish>();
  Command& command = group.add("check", "verify checksums, indexes, counts and the bytes of each message");
  command.option("bag", wish->path, "an MCAP file, or the folder that `ros2 bag record` made")
      .required()
      .names_a(Names::File);
  command.flag("--json", wish->as_json, "print JSON");
  command.note(
      "Exit code 1 if something is wrong. Messages of types that are not installed are counted, and not decoded.");
  command.runs([wish] { return check_bag(*wish); });
}

void add_recover(Command& group) {
  auto wish = std::make_shared<BagRecoverWish>();
  Command& command = group.add("recover", "copy what can be read of a damaged or unfinished file into a new one");
  command.option("file", wish->file, "an MCAP file; it is not changed").required().names_a(Names::File);
  command.option("-o,--output", wish->output, "the new file; default: NAME.recovered.mcap beside it")
      .names_a(Names::File);
  command.option("--compression", wish->compression, "of the new file").one_of({"none", "lz4", "zstd"}).with_default();
  command.runs([wish] { return recover_bag(*wish); });
}

}  // namespace

void add_bag_commands(Command& root) {
  Command& group = root.add("bag", "recordings: MCAP files, as `ros2 bag` writes them");
  add_info(group);
  add_check(group);
  add_recover(group);
}

}  // namespace nacelle::cli
