// SPDX-License-Identifier: Apache-2.0
#include "simulation/component/run_device.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <algorithm>
#include <array>

#include "nacelle/io/pty_pair.hpp"
#include "simulation/component/end_signals.hpp"
#include "simulation/model/ld_lidar.hpp"
#include "simulation/model/nmea_gps.hpp"
#include "simulation/model/paced_line.hpp"
#include "simulation/model/rplidar.hpp"
#include "simulation/model/ydlidar.hpp"

namespace nacelle::simulation {
namespace {

// A machine that stood still for longer is not caught up with: the device's clock jumps.
constexpr Duration kMostCatchUp = 200ms;

struct LdModel {
  const char* name;
  unsigned baud;
  double points_per_second;
};
constexpr std::array kLdModels{LdModel{"ld06", 230400, 4500.0}, LdModel{"ld19", 230400, 4500.0},
                               LdModel{"stl19p", 230400, 5000.0}, LdModel{"stl27l", 921600, 21600.0}};
constexpr const char* kNmeaGps = "nmea_gps";
constexpr std::array kRplidars{"rplidar_a1", "rplidar_a2", "rplidar_a3", "rplidar_c1", "rplidar_s1", "rplidar_s2"};
constexpr std::array kYdlidars{"ydlidar_x2", "ydlidar_x4", "ydlidar_g2", "ydlidar_g4", "ydlidar_g6"};

}  // namespace

std::vector<std::string> device_names() {
  std::vector<std::string> names;
  for (const LdModel& model : kLdModels) names.emplace_back(model.name);
  names.insert(names.end(), kRplidars.begin(), kRplidars.end());
  names.insert(names.end(), kYdlidars.begin(), kYdlidars.end());
  names.emplace_back(kNmeaGps);
  return names;
}

std::unique_ptr<SerialDevice> make_device(const std::string& name, std::uint64_t seed) {
  if (name == kNmeaGps) return std::make_unique<NmeaGps>(seed);
  const Room room = Room::with_two_boxes();
  for (const LdModel& model : kLdModels) {
    if (name != model.name) continue;
    const LidarRotor::Settings rotor{.points_per_second = model.points_per_second, .seed = seed};
    return std::make_unique<LdLidar>(model.baud, rotor, room);
  }
  if (std::ranges::find(kRplidars, name) != kRplidars.end()) {
    Rplidar::Settings settings = Rplidar::settings_of(name);
    settings.rotor.seed = seed;
    return std::make_unique<Rplidar>(std::move(settings), room);
  }
  if (std::ranges::find(kYdlidars, name) != kYdlidars.end()) {
    Ydlidar::Settings settings = Ydlidar::settings_of(name);
    settings.rotor.seed = seed;
    return std::make_unique<Ydlidar>(settings, room);
  }
  return nullptr;
}

Result<void, Problem> run_device(const DeviceRun& run, const Clock& clock,
                                 const std::function<void(const std::string& path)>& on_ready) {
  const EndSignals signals;  // first: a signal from now on ends the device in order
  const auto device = make_device(run.name, run.seed);
  if (!device) {
    const auto names = device_names();
    return err(Problem{"device '" + run.name + "'", "there is no simulated one of that name",
                       fmt::format("{}: {}", suggestion(run.name, names), fmt::join(names, ", "))});
  }
  auto pty = io::PtyPair::create();
  if (!pty) return err(std::move(pty).error());
  io::PtyPair& line = *pty.value();
  if (!run.link.empty()) {
    if (auto linked = line.link_as(run.link); !linked) return linked;
  }
  on_ready(line.path());

  PacedLine paced{device->baud()};
  MonotonicTime origin = clock.now();
  Duration last{};
  for (;;) {
    std::array watched{pollfd{line.device_end(), POLLIN, 0}, pollfd{signals.descriptor(), POLLIN, 0},
                       pollfd{run.stop_descriptor, POLLIN, 0}};
    static_cast<void>(::poll(watched.data(), watched.size(), 1));
    if ((watched[1].revents & POLLIN) != 0 && signals.ask_to_end(true)) return {};
    if ((watched[2].revents & POLLIN) != 0) return {};
    if (clock.now() - origin - last > kMostCatchUp) origin = clock.now() - last;
    const Duration now = last = clock.now() - origin;
    if (const auto bytes = line.read(); bytes && !bytes->empty()) device->receive(*bytes, now);
    device->advance(now, [&](Duration at, ByteView bytes) { paced.send(at, bytes); });
    paced.release(now, [&](ByteView bytes) { static_cast<void>(line.write_some(bytes)); });
  }
}

}  // namespace nacelle::simulation
