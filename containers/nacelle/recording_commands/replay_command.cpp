// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/inert_launch.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "process/stop_signal.hpp"
#include "record/port/recording_file.hpp"
#include "record/protocol/compression.hpp"
#include "recording_commands/commands.hpp"
#include "recording_commands/loaded_component.hpp"
#include "recording_commands/recording_files.hpp"
#include "replay/replay.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;
using record::OrderedMessages;

struct ReplayWish {
  std::string file;
  std::vector<std::string> arguments;
  std::string from, record, compression = "none";
  std::vector<std::string> nodes;
  bool all = false, as_json = false;
};

struct Recording {
  std::vector<std::string> files;
  std::vector<std::unique_ptr<record::FileSource>> sources;
  std::unique_ptr<OrderedMessages> messages;

  [[nodiscard]] static Result<Recording, Problem> open(const std::string& path) {
    const auto files = recording_files(path);
    if (!files) return err(files.error());
    Recording made{*files, {}, nullptr};
    std::vector<record::ByteSource*> sources;
    for (const auto& file : made.files) {
      auto source = record::FileSource::open(file);
      if (!source) return err(source.error());
      made.sources.push_back(std::move(*source));
      sources.push_back(made.sources.back().get());
    }
    auto messages = OrderedMessages::open(sources);
    if (!messages) return err(problem_of(made.files[messages.error().file], messages.error().problem));
    made.messages = std::move(*messages);
    if (made.messages->messages() == 0)
      return err(Problem{Place{path, 0}, "has no messages", "name another recording"});
    return made;
  }
  [[nodiscard]] std::set<std::string> topics() const {
    std::set<std::string> names;
    for (const auto& topic : messages->topics()) names.insert(topic.name);
    return names;
  }
};

/// What runs, what does not, and what nobody publishes.
struct Line {
  std::vector<replay::Role> roles;
  std::vector<replay::MissingTopic> missing;
  std::vector<std::string> programs;
};

void print_cast(const Line& line, bool is_chosen) {
  std::vector<std::string> running;
  for (const auto& role : line.roles) {
    if (role.runs()) running.push_back(role.node);
  }
  print_text("runs: %s\n", join(running, " ").c_str());
  // With --nodes the user has left them out.
  for (const auto& role : line.roles) {
    if (!role.runs() && !is_chosen) print_text("left out: %s (%s)\n", role.node.c_str(), role.left_out.c_str());
  }
  for (const auto& program : line.programs) print_text("left out: %s (a program)\n", program.c_str());
  for (const auto& [topic, readers, publisher] : line.missing) {
    if (publisher.empty())
      print_text("not recorded: %s (read by %s; no component of the launch file publishes it)\n", topic.c_str(),
                 join(readers).c_str());
  }
}

void warn(const std::string& text) {
  std::fflush(stdout);
  std::fprintf(stderr, "nacelle: warning: %s\n", text.c_str());
}

/// Of topics that a user may publish, such as set_pose, nobody misses the recording.
void warn_of_missing(const std::vector<replay::MissingTopic>& missing) {
  for (const auto& [topic, readers, publisher] : missing) {
    if (!publisher.empty())
      warn(fmt::format("{} was not recorded, and {} is left out; read by {}", topic, publisher, join(readers)));
  }
}

json to_json(const ReplayWish& wish, const Line& line, const replay::ReplayFigures& figures, double took_s,
             const std::vector<runtime::FaultEvent>& faults) {
  json runs = json::array(), left_out = json::object(), missing = json::array(), fault_rows = json::array();
  for (const auto& role : line.roles) {
    if (role.runs())
      runs.push_back(role.node);
    else
      left_out[role.node] = role.left_out;
  }
  for (const auto& [topic, readers, publisher] : line.missing)
    missing.push_back({{"topic", topic}, {"readers", readers}, {"left_out", publisher}});
  for (const auto& fault : faults)
    fault_rows.push_back({{"node", fault.node}, {"code", fault.code}, {"text", fault.text}});
  return {{"runs", std::move(runs)},
          {"left_out", std::move(left_out)},
          {"programs", line.programs},
          {"missing", std::move(missing)},
          {"faults", std::move(fault_rows)},
          {"recorded_s", figures.seconds},
          {"took_s", took_s},
          {"played", figures.inputs.played},
          {"undecoded", figures.inputs.undecoded},
          {"file", wish.record},
          {"messages", figures.outputs}};
}

void print_figures(const ReplayWish& wish, const replay::ReplayFigures& figures, double took_s) {
  std::uint64_t written = 0;
  std::size_t topics = 0;
  for (const auto& [topic, count] : figures.outputs) {
    written += count;
    topics += count > 0 ? 1 : 0;
  }
  print_text("%.1f s replayed in %.2f s: %zu messages played, %zu of %zu topic%s written to %s\n", figures.seconds,
             took_s, static_cast<std::size_t>(figures.inputs.played), static_cast<std::size_t>(written), topics,
             topics == 1 ? "" : "s", wish.record.c_str());
}

/// Removes a file that was not completed, unless it is told to stay.
class NewFile {
 public:
  explicit NewFile(std::string path) : path_(std::move(path)) {}
  ~NewFile() {
    std::error_code ignored;
    if (!stays_) std::filesystem::remove(path_, ignored);
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  void stay() { stays_ = true; }

 private:
  const std::string path_;
  bool stays_ = false;
};

int run_replay(const ReplayWish& wish, Recording& recording, const InertLaunch& launch, const Line& line) {
  auto sink = record::FileSink::create(wish.record);
  if (!sink) return complain(sink.error());
  NewFile file{wish.record};
  const process::StopSignal stop;
  msgs::TypeLibrary library{message_library_directories()};
  replay::Replay::Options options;
  options.component_folders = launch.places.component_folders;
  options.find_type = [&](const std::string& name) {
    const auto found = library.message(name);
    return found ? *found : nullptr;
  };
  options.compression = *record::compression_of(wish.compression == "none" ? "" : wish.compression);
  options.writes_inputs = wish.all;
  replay::Replay replay{*recording.messages, launch.plan, line.roles, **sink, std::move(options)};

  const auto begin = std::chrono::steady_clock::now();
  const auto up = replay.bring_up();
  if (!up) return complain(up.error());
  for (const auto& problem : *up) warn("left out, since it is not required: " + problem.text());
  for (const auto& topic : replay.refused()) warn(topic + "; it is not played");
  const bool is_written = replay.run([&](double done) {
    if (!wish.as_json) show_progress(fmt::format("{:.0f} %", done * 100.0));
    return !stop.is_raised();
  });
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!wish.as_json) show_progress("\r");
  if (stop.is_raised()) return complain(Problem{"replay", fmt::format("interrupted by {}", stop.name())});
  if (!is_written || !(*sink)->sync())
    return complain((*sink)->has_failed() ? (*sink)->problem()
                                          : Problem{Place{wish.record, 0}, "an MCAP file holds at most 65,535 topics"});
  file.stay();

  const auto figures = replay.figures();
  const auto faults = replay.faults();
  if (wish.as_json)
    std::printf(
        "%s\n",
        to_json(wish, line, figures, took_s, faults).dump(2, ' ', false, json::error_handler_t::replace).c_str());
  else
    print_figures(wish, figures, took_s);
  if (figures.inputs.undecoded > 0)
    warn(fmt::format("{} messages are not of their topic's type", figures.inputs.undecoded));
  bool is_good = true;
  for (const auto& problem : recording.messages->problems()) {
    complain(problem_of(recording.files[problem.file], problem.problem));
    is_good = false;
  }
  for (const auto& fault : faults) {
    if (fault.is_open_fault) continue;
    complain(Problem{Place::of_node(fault.node), fault.code + ": " + fault.text});
    is_good = false;
  }
  return is_good ? kDone : kFailed;
}

int run(const ReplayWish& wish) {
  auto recording = Recording::open(wish.from);
  if (!recording) return complain(recording.error());
  auto launch = open_inert_launch(wish.file, wish.arguments);
  if (!launch) return launch.error();
  set_log_level(LogLevel::Warn);
  const auto candidates = replay::candidates_of((*launch)->inert);
  const auto recorded = recording->topics();
  auto roles = replay::cast(candidates, recorded, wish.nodes);
  if (!roles) return complain(roles.error());
  Line line{std::move(*roles), {}, {}};
  line.missing = replay::missing_topics(candidates, line.roles, recorded);
  for (const auto& program : (*launch)->plan.programs) line.programs.push_back(program.label);
  // Their constructors have said what they declare; others are made for the replay.
  (*launch)->inert = {};
  if (!wish.as_json) print_cast(line, !wish.nodes.empty());
  bool is_any = false;
  for (const auto& role : line.roles) is_any = is_any || role.runs();
  if (!is_any)
    return complain(Problem{Place{wish.file, 0}, "no component of it can run on " + wish.from,
                            "name some: --nodes NAME; `nacelle bag info` lists the recorded topics"});
  warn_of_missing(line.missing);
  if (const auto users = replay::without_transforms(candidates, line.roles); !users.empty())
    warn(
        fmt::format("nothing that runs keeps transforms for {}; name the TransformsComponent, too", join(users, ", ")));
  return run_replay(wish, *recording, **launch, line);
}

}  // namespace

void add_replay_command(Command& root) {
  auto wish = std::make_shared<ReplayWish>();
  Command& command = root.add("replay", "run components of a launch file on a recording, the same way each time");
  command.option("file", wish->file, "a .launch.yaml, .launch.xml file").required().names_a(Names::File);
  command.option("arguments", wish->arguments, "name:=value for the file's arguments");
  command.option("--from", wish->from, "an MCAP file, or the folder that `nacelle bag record` made")
      .required()
      .value("FILE")
      .names_a(Names::File);
  command.option("--record", wish->record, "the MCAP file to make, with what the components publish")
      .required()
      .value("FILE")
      .names_a(Names::File);
  command.option("--nodes", wish->nodes, "run this component; again for each more").value("NAME");
  command.flag("--all", wish->all, "write what is played from the recording, too");
  command.option("--compression", wish->compression, "of the new file").one_of({"none", "lz4", "zstd"}).with_default();
  command.flag("--json", wish->as_json, "print JSON");
  command.note(
      "Time is that of the recording, as fast as the processor allows, and all callbacks run on one thread: two runs "
      "write the same "
      "bytes. Drivers do not run, no device is opened and no program is started. Without --nodes, all other components "
      "run that "
      "read something recorded. What a running component publishes is not played from the recording. Conditions of "
      "`after:` are an order only. Exit code 1 if a component fails.");
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
