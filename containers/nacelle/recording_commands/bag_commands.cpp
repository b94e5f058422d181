// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "recording_commands/bag_check.hpp"
#include "recording_commands/bag_copy.hpp"
#include "recording_commands/bag_info.hpp"
#include "recording_commands/bag_merge.hpp"
#include "recording_commands/commands.hpp"

namespace nacelle::cli {
namespace {

void add_info(Command& group) {
  auto wish = std::make_shared<BagInfoWish>();
  Command& command =
      group.add("info", "what a recording has, as `ros2 bag info`, and each topic's rate and longest gap");
  command.option("bag", wish->path, "an MCAP or .db3 file, or the folder that `ros2 bag record` made")
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

constexpr const char* kBag = "an MCAP or .db3 file, or the folder that `ros2 bag record` made; it is not changed";

void add_compression(Command& command, BagCopyWish& wish) {
  command.option("--compression", wish.compression, "of the new file").one_of({"none", "lz4", "zstd"}).with_default();
}

void add_recover(Command& group) {
  auto wish = std::make_shared<BagCopyWish>();
  wish->despite_problems = true;
  Command& command = group.add("recover", "copy what can be read of a damaged or unfinished recording into a new file");
  command.option("bag", wish->path, kBag).required().names_a(Names::File);
  command.option("-o,--output", wish->output, "the new file; default: NAME.recovered.mcap beside it")
      .names_a(Names::File);
  add_compression(command, *wish);
  command.runs([wish] { return copy_bag(*wish); });
}

void add_convert(Command& group) {
  auto wish = std::make_shared<BagCopyWish>();
  Command& command = group.add("convert", "copy a recording into one MCAP file, with another compression");
  command.option("bag", wish->path, kBag).required().names_a(Names::File);
  command.option("-o,--output", wish->output, "the new file").required().names_a(Names::File);
  add_compression(command, *wish);
  command.note(
      "Definitions that a .db3 file lacks (before ROS 2 Iron) are those of the installed message packages. A type that "
      "neither has gets an empty schema, and a warning.");
  command.runs([wish] { return copy_bag(*wish); });
}

void add_cut(Command& group) {
  auto wish = std::make_shared<BagCopyWish>();
  Command& command = group.add("cut", "copy a part of a recording's time into a new file");
  command.option("bag", wish->path, kBag).required().names_a(Names::File);
  command.option("-o,--output", wish->output, "the new file").required().names_a(Names::File);
  command.option("--start-offset", wish->start_offset_s, "begin so many s after the first message")
      .value("SECONDS")
      .with_default()
      .within(0.0, 1e9);
  command.option("--duration", wish->duration_s, "how much is copied, in s; 0: to the end")
      .value("SECONDS")
      .with_default()
      .within(0.0, 1e9);
  add_compression(command, *wish);
  command.runs([wish] { return copy_bag(*wish); });
}

void add_filter(Command& group) {
  auto wish = std::make_shared<BagCopyWish>();
  Command& command = group.add("filter", "copy some topics of a recording into a new file");
  command.option("bag", wish->path, kBag).required().names_a(Names::File);
  command.option("-o,--output", wish->output, "the new file").required().names_a(Names::File);
  command.option("--topics", wish->topics, "these topics");
  command.option("-e,--regex", wish->regex, "and those in which this regular expression is found").checked(wrong_regex);
  command.option("-x,--exclude-regex", wish->exclude_regex, "but none in which this one is found").checked(wrong_regex);
  command.note("Without --topics and --regex: all topics but the excluded ones.");
  add_compression(command, *wish);
  command.runs([wish] { return copy_bag(*wish); });
}

void add_merge(Command& group) {
  auto wish = std::make_shared<BagMergeWish>();
  Command& command = group.add("merge", "copy several recordings into one file, in the order of their log times");
  command
      .option("bags", wish->paths, "MCAP or .db3 files, or folders that `ros2 bag record` made; they are not changed")
      .required()
      .names_a(Names::File);
  command.option("-o,--output", wish->output, "the new file").required().names_a(Names::File);
  command.option("--compression", wish->compression, "of the new file").one_of({"none", "lz4", "zstd"}).with_default();
  command.note("A topic that has different types in two recordings is an error. Attachments and metadata are copied.");
  command.runs([wish] { return merge_bags(*wish); });
}

}  // namespace

void add_bag_commands(Command& root) {
  Command& group = root.add("bag", "recordings: MCAP and SQLite files, as `ros2 bag` writes them");
  add_info(group);
  add_check(group);
  add_recover(group);
  add_cut(group);
  add_filter(group);
  add_convert(group);
  add_merge(group);
}

}  // namespace nacelle::cli
