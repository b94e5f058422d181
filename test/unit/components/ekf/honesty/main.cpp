// SPDX-License-Identifier: Apache-2.0
// Prints how honest the filter's uncertainty is, and draws it:
//   ekf_honesty                                     the simulated world, 11 seeds
//   ekf_honesty --data FOLDER [--turn COLUMN]       a recorded drive
//   ekf_honesty ... --pictures FOLDER               track, error and 95 % band as SVG
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <string>

#include "nees.hpp"
#include "pictures.hpp"

namespace nacelle::ekf::honesty {
namespace {

constexpr int kSeeds = 11;

void print(const char* what, const std::vector<Drive>& drives, const Setup& setup, double window_s) {
  std::vector<double> position, yaw;
  double position_m2 = 0.0, yaw_rad2 = 0.0;
  for (const Drive& drive : drives) {
    const WindowErrors errors = relative_errors(drive, setup, window_s);
    position.insert(position.end(), errors.position.begin(), errors.position.end());
    yaw.insert(yaw.end(), errors.yaw.begin(), errors.yaw.end());
    position_m2 += errors.position_m2;
    yaw_rad2 += errors.yaw_rad2;
  }
  const Honesty p = honesty_of(position, 2), y = honesty_of(yaw, 1);
  const double windows = static_cast<double>(std::max<std::size_t>(position.size(), 1));
  std::printf("%-38s %4.0f s %6zu  %8.3f %8.3f %6.1f %%  %8.2f %8.3f %6.1f %%\n", what, window_s, position.size(),
              std::sqrt(position_m2 / windows), p.mean, 100.0 * p.coverage,
              std::sqrt(yaw_rad2 / windows) * 180.0 / std::numbers::pi, y.mean, 100.0 * y.coverage);
}

void print_both(const char* what, const std::vector<Drive>& drives, const Setup& setup) {
  print(what, drives, setup, 2.0);
  print(what, drives, setup, 10.0);
}

// "limits.speed" and the like, for experiments.
void change(Setup& setup, const std::map<std::string, double>& given) {
  const std::pair<const char*, double*> known[] = {
      {"slip.distance", &setup.slip.distance_m}, {"slip.lateral", &setup.slip.lateral_m},
      {"slip.heading", &setup.slip.heading_rad}, {"slip.turn", &setup.slip.turn_rad},
      {"speed", &setup.limits.speed_mps},        {"acceleration", &setup.limits.acceleration_mps2},
      {"yaw_rate", &setup.limits.yaw_rate_rps},  {"yaw_acceleration", &setup.limits.yaw_acceleration_rps2},
      {"interval", &setup.limits.interval_s},    {"frequency", &setup.frequency_hz}};
  for (const auto& [name, into] : known) {
    if (const auto found = given.find(name); found != given.end()) *into = found->second;
  }
}

int main(int argc, char** argv) {
  std::string data, turn = "dyaw_rad", pictures;
  std::map<std::string, double> given;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string option = argv[i], value = argv[i + 1];
    if (option == "--data") data = value;
    if (option == "--turn") turn = value;
    if (option == "--pictures") pictures = value;
    if (option.starts_with("--")) given[option.substr(2)] = std::atof(value.c_str());
  }
  std::vector<Drive> drives;
  Setup setup = data.empty() ? default_robot() : outdoor_vehicle();
  change(setup, given);
  std::printf("%-38s window windows  RMS, m  NEES/2 in 95 %%  RMS, deg   NEES  in 95 %%\n", "");
  if (data.empty()) {
    std::vector<Drive> calibrated;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      drives.push_back(simulated({.seed = static_cast<std::uint64_t>(seed), .calibrates_gyro = false}));
      calibrated.push_back(simulated({.seed = static_cast<std::uint64_t>(seed)}));
    }
    print_both("wheeled", drives, setup);
    print_both("wheeled, gyro calibrated at rest", calibrated, setup);
  } else {
    drives.push_back(recorded(data, turn));
    if (drives.front().wheels.empty()) {
      std::fprintf(stderr, "%s: no odometry.csv and truth.csv\n", data.c_str());
      return EXIT_FAILURE;
    }
    print_both("wheeled", drives, setup);
  }
  Setup adaptive = setup, old = setup;
  adaptive.adaptive = true;
  print_both("wheeled, adaptive", drives, adaptive);
  old.wheeled = false;
  print_both("robot_localization's process noise", drives, old);
  if (!pictures.empty() && !draw(pictures, drives.front(), setup)) return EXIT_FAILURE;
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace nacelle::ekf::honesty

int main(int argc, char** argv) { return nacelle::ekf::honesty::main(argc, argv); }
