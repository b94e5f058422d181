// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/program.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "proof/proof.hpp"

namespace nacelle::cli {

/// A launch file's plan with its components constructed and nothing started, for `check`, `qos check` and `params`.
struct InertLaunch {
  SystemClock clock;
  launch::Plan plan;
  loading::ProgramPlaces places;
  proof::InertRobot inert;
};

/// Parses the words `name:=value`. If a word has another form, prints the error to stderr and returns nothing.
[[nodiscard]] std::optional<std::map<std::string, std::string>> parse_or_complain(
    const std::vector<std::string>& words);
/// Loads a launch file and constructs its components. Errors: every problem of the launch file.
[[nodiscard]] Result<std::unique_ptr<InertLaunch>, std::vector<Problem>> load_inert_launch(
    const std::string& file, const std::map<std::string, std::string>& arguments);
/// Parses the words and loads the launch file. Errors: the exit code; every problem has been printed to stderr.
[[nodiscard]] Result<std::unique_ptr<InertLaunch>, int> open_inert_launch(const std::string& file,
                                                                          const std::vector<std::string>& words);
[[nodiscard]] std::size_t stream_count(const runtime::Container& container);

}  // namespace nacelle::cli
