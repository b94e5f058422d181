// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/history_options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace nacelle::ekf {
namespace {

// An hour: more is a mistake in the unit.
constexpr double kLongest_s = 3600.0;

// What goes together badly.
std::vector<Problem> doubts_of(const Node& node) {
  const bool smooths = node.get<bool>("smooth_lagged_data");
  const double length_s = node.get<double>("history_length");
  std::vector<Problem> doubts;
  if (smooths && length_s == 0.0)
    doubts.push_back({Place::of_parameter("smooth_lagged_data"),
                      "smooth_lagged_data is true and history_length is 0: no late measurement is fused",
                      "give history_length the largest delay of an input, s"});
  if (!smooths && length_s != 0.0)
    doubts.push_back({Place::of_parameter("history_length"),
                      fmt::format("history_length is {} s, but smooth_lagged_data is false: late measurements are not "
                                  "put into their place",
                                  length_s),
                      "set smooth_lagged_data: true, or leave history_length out"});
  if (node.get<bool>("reset_on_time_jump") && !node.get<bool>("use_sim_time"))
    doubts.push_back({Place::of_parameter("reset_on_time_jump"),
                      "reset_on_time_jump is true without use_sim_time: it has no effect",
                      "leave it out; a clock of the machine that is set back does not move the estimate"});
  return doubts;
}

}  // namespace

void declare_history_parameters(Node& node) {
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  node.declare_parameter("smooth_lagged_data", false,
                         say("Put measurements that come late into their place: go back in time and take all that is "
                             "newer again. Otherwise they correct the state of now."));
  node.declare_parameter("history_length", 0.0,
                         say("How far back smooth_lagged_data goes, s. Older measurements are not fused, but counted. "
                             "measurement_queue_limit is the most measurements that are kept; 4 kB each."));
  node.declare_parameter(
      "permit_corrected_publication", false,
      say("Publish a state that a late measurement corrected with its own stamp, even if that is not "
          "newer than the last one published."));
  node.declare_parameter("reset_on_time_jump", false,
                         say("With use_sim_time: reset the filter when the time jumps back by more than 1 s."));
}

Result<void, Problem> read_history(const Node& node, EkfOptions& options) {
  options.filter.permit_corrected_publication = node.get<bool>("permit_corrected_publication");
  options.filter.reset_on_time_jump = node.get<bool>("reset_on_time_jump") && node.get<bool>("use_sim_time");
  const double length_s = std::abs(node.get<double>("history_length"));  // robot_localization takes -1 for 1
  if (!(length_s <= kLongest_s)) {
    return err(Problem{Place::of_parameter("history_length"), fmt::format("is {}", length_s),
                       fmt::format("give seconds, 0 to {}", kLongest_s)});
  }
  if (node.get<bool>("smooth_lagged_data")) options.filter.history = from_seconds(length_s);
  for (const Problem& doubt : doubts_of(node)) options.notes.push_back(doubt.what + "; " + doubt.way_out);
  return {};
}

void declare_history_warnings(const Node& node) {
  for (const Problem& doubt : doubts_of(node)) node.declare_warning(doubt);
}

}  // namespace nacelle::ekf
