// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "ask/frames.hpp"
#include "cli/asking.hpp"
#include "cli/live.hpp"
#include "cli/program.hpp"
#include "drawing/frame_tree.hpp"
#include "drawing/graphviz.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/printable.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/spatial/rigid_transform.hpp"
#include "report/frame_delays.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct TfWish {
  Whom whom;
  std::string source, target, svg, pdf, dot;
  std::vector<std::string> frames;
  bool as_json = false, once = false, with_matrix = false;
  double rate_hz = 1.0, interval_s = 1.0;
  std::uint32_t precision = 3;
};

// --- tree ---------------------------------------------------------------------------------------------------------------

std::vector<drawing::FrameEdge> edges_of(const json& frames) {
  std::vector<drawing::FrameEdge> edges;
  for (const auto& row : frames)
    edges.push_back({row["child"], row["parent"], row["owner"], row["static"], row["rate_hz"], row["age_s"]});
  return edges;
}

int draw_tree(const std::string& path, const std::string& dot_text) {
  if (path.empty()) return kDone;
  const auto told = drawing::write_drawing(path, dot_text);
  if (!told) return complain(told.error());
  if (!told.value().empty()) std::fprintf(stderr, "nacelle: %s\n", told.value().c_str());
  return kDone;
}

/// What the option's file has to be called, so that the option and the name ask for one format.
bool is_named_for(const std::string& path, const char* format) {
  if (path.empty() || drawing::drawing_format(path) == format) return true;
  complain({"--" + std::string{format} + " " + path, "is no ." + std::string{format} + " file",
            "name it so, e.g. tree." + std::string{format}});
  return false;
}

/// Returns a line for each machine whose clock differs, with the frames that it sends.
std::string skews_text(const json& frames) {
  std::map<std::string, std::vector<std::string>> sent;
  for (const auto& frame : frames) {
    if (frame.contains("clock_skew"))
      sent[printable_line(frame["clock_skew"].get<std::string>())].push_back(
          printable_line(frame["child"].get<std::string>()));
  }
  std::string text;
  for (const auto& [skew, children] : sent) text += "clock skew: " + skew + " (" + join(children) + ")\n";
  return text;
}

int tree(const TfWish& wish) {
  if (!is_named_for(wish.svg, "svg") || !is_named_for(wish.pdf, "pdf") || !is_named_for(wish.dot, "dot")) return kUsage;
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  auto reply = ask::list_frames(nodes, wish.whom.container);
  if (!reply) return complain(reply.error());
  const auto edges = edges_of(reply.value()["frames"]);
  const std::string dot_text = drawing::tree_dot(edges);
  int worst = kDone;
  for (const auto* const path : {&wish.svg, &wish.pdf, &wish.dot}) worst = std::max(worst, draw_tree(*path, dot_text));
  if (wish.as_json) {
    std::printf("%s\n", json{{"frames", reply.value()["frames"]}}.dump().c_str());
  } else if (wish.svg.empty() && wish.pdf.empty() && wish.dot.empty()) {
    std::fputs(edges.empty() ? "no transform has been sent yet\n" : drawing::tree_text(edges).c_str(), stdout);
    std::fputs(skews_text(reply.value()["frames"]).c_str(), stdout);
  }
  return worst;
}

// --- echo ---------------------------------------------------------------------------------------------------------------

/// As tf2_echo writes it.
std::string echo_text(const json& transform, unsigned precision, bool with_matrix) {
  const auto list = [&](const json& values, double factor = 1.0) {
    std::string text;
    for (const auto& value : values)
      text += fmt::format("{}{:.{}f}", text.empty() ? "" : ", ", value.get<double>() * factor, precision);
    return "[" + text + "]";
  };
  const auto stamp_ns = transform["stamp_ns"].get<std::int64_t>();
  std::string out = fmt::format("At time {}.{:09}\n", stamp_ns / 1'000'000'000, stamp_ns % 1'000'000'000);
  out += "- Translation: " + list(transform["translation_m"]) + "\n";
  out += "- Rotation: in Quaternion (xyzw) " + list(transform["rotation_xyzw"]) + "\n";
  out += "- Rotation: in RPY (radian) " + list(transform["rpy_rad"]) + "\n";
  out += "- Rotation: in RPY (degree) " + list(transform["rpy_rad"], 180.0 / M_PI) + "\n";
  if (!with_matrix) return out;
  const auto& t = transform["translation_m"];
  const auto& q = transform["rotation_xyzw"];
  spatial::RigidTransform X;
  X.translation_m = {t[0].get<double>(), t[1].get<double>(), t[2].get<double>()};
  X.rotation = Eigen::Quaterniond{q[3].get<double>(), q[0].get<double>(), q[1].get<double>(), q[2].get<double>()};
  const Eigen::Matrix4d matrix = X.isometry().matrix();
  out += "- Matrix:\n";
  for (Eigen::Index row = 0; row < 4; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) out += fmt::format(" {:6.{}f}", matrix(row, column), precision);
    out += "\n";
  }
  return out;
}

int echo(const TfWish& wish) {
  LiveText live;
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  const SystemClock clock;
  const MonotonicTime patience = clock.now() + 1s;  // tf2_echo's: the first transforms may be about to come
  std::string last_trouble;
  do {
    // target and source in tf2_echo's words: where SOURCE's axes see TARGET.
    const auto reply = ask::lookup_transform(nodes, wish.whom.container, wish.source, wish.target);
    if (reply) {
      last_trouble.clear();
      live.add(wish.as_json ? reply.value().dump() + "\n" : echo_text(reply.value(), wish.precision, wish.with_matrix));
      if (wish.once) return kDone;
    } else if (wish.once ? clock.now() > patience : reply.error().text() != last_trouble) {
      last_trouble = reply.error().text();
      complain(reply.error());
      // A container that has ended does not come back on this connection.
      if (wish.once || !nodes.container(wish.whom.container)) return kFailed;
    }
  } while (live.wait(wish.once ? 50ms : from_seconds(1.0 / wish.rate_hz)));
  return kDone;
}

// --- monitor ------------------------------------------------------------------------------------------------------------

/// What is watched: everything, the chain between two frames, or the frames named.
struct Watched {
  std::vector<std::string> frames;  ///< Children of edges, in the order in which they are shown.
  std::vector<std::string> chain;
};

Result<Watched, Problem> watched_by(const std::vector<std::string>& wanted, const json& frames) {
  std::map<std::string, std::string> parents;
  std::vector<std::string> names;
  for (const auto& row : frames) {
    parents[row["child"]] = row["parent"];
    for (const char* const end : {"child", "parent"}) names.push_back(row[end]);
  }
  Watched watched;
  for (const auto& name : wanted) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      return err(Problem{"frame " + name, "no transform names it", suggestion(name, names), NameFault::Unknown, name});
  }
  if (wanted.size() == 2) {
    watched.chain = report::chain_between(parents, wanted[0], wanted[1]);
    if (watched.chain.empty())
      return err(
          Problem{wanted[0] + " and " + wanted[1], "no chain of transforms joins them", "see `nacelle tf tree`"});
  }
  const auto& shown = wanted.size() == 2 ? watched.chain : wanted;
  for (const auto& row : frames) {
    const std::string child = row["child"];
    const bool is_shown = wanted.empty() || std::find(shown.begin(), shown.end(), child) != shown.end();
    // The chain's topmost frame hangs from one that is not of the chain.
    const bool leaves_chain =
        wanted.size() == 2 && std::find(shown.begin(), shown.end(), row["parent"].get<std::string>()) == shown.end();
    if (is_shown && !leaves_chain) watched.frames.push_back(child);
  }
  return watched;
}

json monitor_json(const Watched& watched, const json& frames, const report::FrameDelays& delays) {
  json rows = json::array(), broadcasters = json::array();
  std::map<std::string, std::vector<std::string>> by_owner;
  for (const auto& row : frames) {
    const std::string child = row["child"], owner = row["owner"];
    if (std::find(watched.frames.begin(), watched.frames.end(), child) == watched.frames.end()) continue;
    const auto figures = delays.of(child);
    rows.push_back({{"frame", child},
                    {"parent", row["parent"]},
                    {"owner", owner},
                    {"static", row["static"]},
                    {"rate_hz", figures.rate_hz},
                    {"average_delay_s", figures.average_delay_s},
                    {"max_delay_s", figures.max_delay_s},
                    {"count", figures.count}});
    if (figures.count != 0) by_owner[owner].push_back(child);
  }
  for (const auto& [owner, children] : by_owner) {
    const auto figures = delays.of_all(children);
    broadcasters.push_back({{"node", owner},
                            {"rate_hz", figures.rate_hz},
                            {"average_delay_s", figures.average_delay_s},
                            {"max_delay_s", figures.max_delay_s}});
  }
  return {{"chain", watched.chain}, {"frames", std::move(rows)}, {"broadcasters", std::move(broadcasters)}};
}

/// In tf2_monitor's words, with the rate of each edge.
std::string monitor_text(const json& figures) {
  const auto owner_of = [](const json& row, const char* key) {
    const std::string owner = row[key];
    return owner.empty() ? std::string{"<no authority available>"} : printable_line(owner);
  };
  std::vector<std::string> chain;
  for (const auto& frame : figures["chain"]) chain.push_back(printable_line(frame.get<std::string>()));
  std::string out;
  if (chain.empty()) {
    out = "RESULTS: for all Frames\n";
  } else {
    out = fmt::format("RESULTS: for {} to {}\nChain is: {}\n", chain.front(), chain.back(), join(chain, " -> "));
  }
  out += "\nFrames:\n";
  for (const auto& row : figures["frames"]) {
    out += fmt::format("Frame: {}, published by {}", printable_line(row["frame"].get<std::string>()),
                       owner_of(row, "owner"));
    out += row["static"].get<bool>()
               ? ", static\n"
               : fmt::format(", {:.3f} Hz, Average Delay: {:.6f}, Max Delay: {:.6f}\n", row["rate_hz"].get<double>(),
                             row["average_delay_s"].get<double>(), row["max_delay_s"].get<double>());
  }
  out += "\nAll Broadcasters:\n";
  for (const auto& row : figures["broadcasters"]) {
    out += fmt::format("Node: {} {:.3f} Hz, Average Delay: {:.6f}, Max Delay: {:.6f}\n", owner_of(row, "node"),
                       row["rate_hz"].get<double>(), row["average_delay_s"].get<double>(),
                       row["max_delay_s"].get<double>());
  }
  return out;
}

/// Records the received messages. Errors: the container has ended.
Result<void, Problem> take_in(control::Client& listener, report::FrameDelays& delays) {
  while (true) {
    auto frame = listener.receive(0ns);
    if (!frame) return err(frame.error());
    if (!frame.value()) return {};
    if (frame.value()->kind != control::FrameKind::Item) continue;
    for (const auto& row : parse_json_or_discard(as_text(frame.value()->payload)))
      delays.note(row[0], row[2].get<std::int64_t>(), row[3].get<std::int64_t>());
  }
}

int monitor(const TfWish& wish) {
  LiveText live;
  auto client = connect(wish.whom);
  if (!client) return client.error();
  auto listener = connect(wish.whom);
  if (!listener) return listener.error();
  ask::Nodes nodes{client.value()};
  auto tree = ask::list_frames(nodes, wish.whom.container);
  if (!tree) return complain(tree.error());
  if (auto watched = watched_by(wish.frames, tree.value()["frames"]); !watched) return complain(watched.error());
  auto listens = listener.value().call(
      {{"verb", "topic.listen"}, {"topic", tree.value()["tf_topic"]}, {"show", "transforms"}}, kAnswerLimit);
  if (!listens) return complain(listens.error());

  const SystemClock clock;
  report::FrameDelays delays;
  for (MonotonicTime next = clock.now() + from_seconds(wish.interval_s);;) {
    if (!live.wait(next - clock.now(), listener.value().descriptor())) return kDone;
    if (auto taken = take_in(listener.value(), delays); !taken) return complain(taken.error());
    if (clock.now() < next) continue;
    next += from_seconds(wish.interval_s);
    tree = ask::list_frames(nodes, wish.whom.container);  // frames may be added and removed, and change owners
    if (!tree) return complain(tree.error());
    const auto watched = watched_by(wish.frames, tree.value()["frames"]);
    if (!watched) return complain(watched.error());
    const json figures = monitor_json(watched.value(), tree.value()["frames"], delays);
    if (wish.as_json) {
      live.add(figures.dump() + "\n");
    } else {
      live.show(monitor_text(figures));
    }
    if (wish.once) return kDone;
  }
}

}  // namespace

void add_tf_commands(Command& root) {
  auto wish = std::make_shared<TfWish>();
  Command& group = root.add("tf", "show the transform tree: owner, rate and delay of each frame");

  Command& tree_command = group.add("tree", "print every frame with the owner, rate and age of its transform");
  tree_command.option("--svg", wish->svg, "draw it with Graphviz").value("FILE").names_a(Names::File);
  tree_command.option("--pdf", wish->pdf, "draw it with Graphviz").value("FILE").names_a(Names::File);
  tree_command.option("--dot", wish->dot, "write it in Graphviz's DOT language").value("FILE").names_a(Names::File);
  add_common_options(tree_command, wish->whom, wish->as_json);
  tree_command.note("In a drawing, transforms older than a second are red.");
  tree_command.runs([wish] { return tree(*wish); });

  Command& echo_command = group.add("echo", "print the transform between two frames repeatedly, like tf2_echo");
  echo_command.option("source", wish->source, "the reference frame").required().names_a(Names::Frame);
  echo_command.option("target", wish->target, "the frame whose pose is printed").required().names_a(Names::Frame);
  echo_command.option("-r,--rate", wish->rate_hz, "times per second").within(0.001, 1000.0).with_default().value("HZ");
  echo_command.option("-p,--precision", wish->precision, "number of decimals").within(0, 15).with_default();
  echo_command.flag("--matrix", wish->with_matrix, "also print the 4 x 4 matrix");
  echo_command.flag("--once", wish->once, "print one transform and exit; exit code 1 if there is none within a second");
  add_common_options(echo_command, wish->whom, wish->as_json);
  echo_command.runs([wish] { return echo(*wish); });

  Command& monitor_command = group.add("monitor", "print rate, delay and owner of each transform, like tf2_monitor");
  monitor_command.option("frames", wish->frames, "two frames: the chain between them; otherwise only these frames")
      .names_a(Names::Frame);
  monitor_command.option("--interval", wish->interval_s, "seconds between two tables")
      .within(0.1, 3600.0)
      .with_default()
      .value("SECONDS");
  monitor_command.flag("--once", wish->once, "print one table and exit");
  add_common_options(monitor_command, wish->whom, wish->as_json);
  monitor_command.note("Delay: from a transform's stamp to its publication, over its last thousand messages.");
  monitor_command.runs([wish] { return monitor(*wish); });
}

}  // namespace nacelle::cli
