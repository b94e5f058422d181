// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "recording_commands/bag_check.hpp"
#include "recording_commands/bag_copy.hpp"
#include "recording_commands/bag_diff.hpp"
#include "recording_commands/bag_info.hpp"
#include "recording_commands/bag_merge.hpp"
#include "recording_commands/bag_play.hpp"
#include "recording_commands/bag_plot.hpp"
#include "recording_commands/bag_record.hpp"
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

void add_diff(Command& group) {
  auto wish = std::make_shared<BagDiffWish>();
  Command& command = group.add("diff", "compare two recordings by topic, message and field");
  command.option("a", wish->a, "an MCAP file, or the folder that `ros2 bag record` made")
      .required()
      .names_a(Names::File);
  command.option("b", wish->b, "another").required().names_a(Names::File);
  command.option("--tolerance", wish->tolerance, "a YAML file: by how much fields may differ, and which are ignored")
      .value("FILE")
      .names_a(Names::File);
  command.option("--topics", wish->topics, "only these topics").value("TOPIC");
  command.flag("--json", wish->as_json, "print JSON");
  command.note(
      "The n-th message of a topic in A is compared with the n-th in B; the times at which they were recorded are not. "
      "Exit code 0: equal; 1: different; 2: they cannot be compared.");
  command.runs([wish] { return diff_bags(*wish); });
}

void add_plot(Command& group) {
  auto wish = std::make_shared<BagPlotWish>();
  Command& command = group.add("plot", "draw numeric fields of a recording into an SVG file");
  command.option("bag", wish->path, "an MCAP file, or the folder that `ros2 bag record` made")
      .required()
      .names_a(Names::File);
  command.option("fields", wish->fields, "a line each: /odom.pose.pose.position.x, /scan.ranges[3]")
      .required()
      .checked(wrong_topic_field);
  command.option("--x", wish->x, "over this field instead of the time; with x, y or z of a position: equal scales")
      .value("FIELD")
      .checked(wrong_topic_field);
  command.option("-o,--output", wish->output, "the SVG file; one that exists is replaced")
      .required()
      .value("FILE")
      .names_a(Names::File);
  command.runs([wish] { return plot_bag(*wish); });
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

void add_record(Command& group) {
  auto wish = std::make_shared<BagRecordWish>();
  Command& command = group.add("record", "record topics of a running container, until Ctrl-C");
  command.option("topics", wish->topics, "these topics").names_a(Names::Topic);
  command.flag("-a,--all", wish->all, "every topic of the container");
  command.option("-e,--regex", wish->regex, "and those in which this regular expression is found").checked(wrong_regex);
  command.option("-x,--exclude-regex", wish->exclude_regex, "but none in which this one is found").checked(wrong_regex);
  command.option("--exclude-topics", wish->exclude_topics, "nor these").names_a(Names::Topic);
  command.flag("--include-hidden-topics", wish->hidden, "with -a and -e, those with a part that begins with '_', too");
  command.option("-o,--output", wish->output, "the folder to make; default: rosbag2_YEAR_MONTH_DAY-HOUR_MINUTE_SECOND")
      .names_a(Names::File);
  command.option("-s,--storage", wish->storage, "the format").one_of({"mcap"}).with_default();
  command.option("--compression", wish->compression, "of the files' chunks")
      .one_of({"none", "lz4", "zstd"})
      .with_default();
  command.option("-b,--max-bag-size", wish->max_size, "bytes after which another file begins; 0: never")
      .value("BYTES")
      .with_default()
      .within(0.0, 1e15);
  command.option("-d,--max-bag-duration", wish->max_duration_s, "seconds after which another file begins; 0: never")
      .value("SECONDS")
      .with_default()
      .within(0.0, 1e9);
  command.option("--for", wish->for_s, "end by itself after so many seconds; 0: never")
      .value("SECONDS")
      .with_default()
      .within(0.0, 1e9);
  command.flag("--start-paused", wish->start_paused, "wait for the service ~/resume");
  command
      .option(
          "--ring", wish->ring,
          "keep the last so many seconds in memory only: 60s; `nacelle bag snapshot`, an emergency stop and a fault "
          "write them into a folder")
      .value("TIME")
      .checked(wrong_ring)
      .not_with("-b")
      .not_with("-d");
  command.option("--ring-size", wish->ring_size, "what --ring may take of /dev/shm; above it, it has fewer seconds")
      .value("SIZE")
      .with_default()
      .checked(wrong_ring_size);
  command.option("--node-name", wish->name, "the recorder's name").value("NAME").with_default();
  command.option("--container", wish->whom.container, "of several containers, this one").value("NAME");
  command.note(
      "The container writes the files, on threads beside the robot's, as nacelle::record::RecordComponent. The robot "
      "does not wait for the "
      "disk: where that is too slow, messages are lost and counted. Topics that begin meanwhile are recorded too.");
  command.runs([wish] { return record_bag(*wish); });
}

void add_snapshot(Command& group) {
  auto wish = std::make_shared<BagSnapshotWish>();
  Command& command = group.add("snapshot", "write what a recorder with a ring keeps in memory, and print the folder");
  command.option("--node", wish->node, "the recorder").value("NAME").with_default().names_a(Names::Node);
  command.option("--container", wish->whom.container, "of several containers, this one").value("NAME");
  command.note(
      "The recorder goes on meanwhile. It is one of `nacelle bag record --ring`, or has the parameter storage.ring.");
  command.runs([wish] { return snapshot_bag(*wish); });
}

void add_play(Command& group) {
  auto wish = std::make_shared<BagPlayWish>();
  Command& command = group.add("play", "publish a recording into a running container, or into one of its own");
  command.option("bag", wish->path, kBag).required().names_a(Names::File);
  command.option("-r,--rate", wish->rate, "how many times as fast").with_default().within(0.001, 1000.0);
  command.flag("-l,--loop", wish->loop, "begin again at the end, until Ctrl-C");
  command.flag("-p,--start-paused", wish->start_paused, "wait for the service ~/resume or ~/play_next");
  command.option("--start-offset", wish->start_offset_s, "begin so many s after the first message")
      .value("SECONDS")
      .with_default()
      .within(0.0, 1e9);
  command.option("--playback-duration,--duration", wish->duration_s, "how much is played, in s; 0: to the end")
      .value("SECONDS")
      .with_default()
      .within(0.0, 1e9);
  command.option("--topics", wish->topics, "these topics only").names_a(Names::Topic);
  command.option("-e,--regex", wish->regex, "and those in which this regular expression is found").checked(wrong_regex);
  command.option("-x,--exclude-regex", wish->exclude_regex, "but none in which this one is found").checked(wrong_regex);
  command.option("--exclude-topics", wish->exclude_topics, "nor these").names_a(Names::Topic);
  command.option("-m,--remap", wish->remaps, "publish a topic under another name").value("FROM:=TO");
  command.option("--clock", wish->clock_hz, "publish the recording's time on /clock, so often a second; 0: not at all")
      .value("HZ")
      .with_default()
      .within(0.0, 1000.0);
  command.option("--node-name", wish->name, "the player's name").value("NAME").with_default();
  command.option("--container", wish->whom.container, "of several containers, this one").value("NAME");
  command.note(
      "The container publishes, as nacelle::record::PlayComponent: recorded commands move a robot as others do. Topics "
      "have the QoS with which "
      "they were recorded. Messages of topics without a reader are not decoded.");
  command.runs([wish] { return play_bag(*wish); });
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
  add_record(group);
  add_snapshot(group);
  add_play(group);
  add_info(group);
  add_check(group);
  add_diff(group);
  add_plot(group);
  add_recover(group);
  add_cut(group);
  add_filter(group);
  add_convert(group);
  add_merge(group);
}

}  // namespace nacelle::cli
