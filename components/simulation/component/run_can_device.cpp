// SPDX-License-Identifier: Apache-2.0
#include "simulation/component/run_can_device.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <array>

#include "simulation/component/end_signals.hpp"
#include "simulation/protocol/odrive_can_device.hpp"
#include "simulation/protocol/vesc_can_device.hpp"

namespace nacelle::simulation {
namespace {

constexpr Duration kStep = 2ms, kReopen = 100ms;

/// What is missing, and how a virtual interface is made.
Problem with_commands(Problem problem, const std::string& interface) {
  problem.way_out += fmt::format(
      "; `sudo modprobe vcan`, `sudo ip link add {0} type vcan` and `sudo ip link set {0} up` make a virtual one",
      interface);
  return problem;
}

}  // namespace

std::vector<std::string> can_device_names() { return {"odrive_can", "vesc_can"}; }

std::unique_ptr<MotorDevice> make_can_device(const std::string& name) {
  if (name == "odrive_can") return std::make_unique<OdriveCanDevice>(OdriveCanDevice::Settings{});
  if (name == "vesc_can") return std::make_unique<VescCanDevice>(VescCanDevice::Settings{});
  return nullptr;
}

void serve_can_device(MotorDevice& device, io::CanPort& port, const Clock& clock,
                      const std::function<bool(Duration wait)>& ends) {
  const MonotonicTime origin = clock.now();
  MonotonicTime before = origin, reopened = origin;
  double left_rad = 0.0, right_rad = 0.0;
  bool is_there = true;
  while (!ends(is_there ? Duration{} : kStep)) {
    // What a bus that is down does not take is lost, as on a cable that is out.
    const auto heard = port.read_until(clock.now() + kStep);
    const MonotonicTime now = clock.now();
    is_there = heard.has_value();
    if (heard && !heard->empty()) {
      if (const Bytes answer = device.on_bytes(*heard, now - origin); !answer.empty())
        static_cast<void>(port.write(answer));
    }
    if (!heard && now - reopened >= kReopen) {
      reopened = now;
      static_cast<void>(port.reopen());
    }
    left_rad += device.left_target_rps() * to_seconds(now - before);
    right_rad += device.right_target_rps() * to_seconds(now - before);
    before = now;
    if (const Bytes said = device.step(now - origin, left_rad, right_rad); !said.empty())
      static_cast<void>(port.write(said));
  }
}

Result<void, Problem> run_can_device(const CanDeviceRun& run, const Clock& clock,
                                     const std::function<void()>& on_ready) {
  const EndSignals signals;  // first: a signal from now on ends the device in order
  const auto device = make_can_device(run.name);
  if (!device) {
    const auto names = can_device_names();
    return err(Problem{"device '" + run.name + "'", "there is no simulated one of that name on a CAN bus",
                       fmt::format("{}: {}", suggestion(run.name, names), fmt::join(names, ", "))});
  }
  auto port = io::CanPort::open({.interface = run.interface}, clock);
  if (!port) return err(with_commands(std::move(port).error(), run.interface));
  on_ready();
  serve_can_device(*device, *port.value(), clock, [&](Duration wait) {
    std::array watched{pollfd{signals.descriptor(), POLLIN, 0}, pollfd{run.stop_descriptor, POLLIN, 0}};
    static_cast<void>(::poll(watched.data(), watched.size(), static_cast<int>(wait / 1ms)));
    return ((watched[0].revents & POLLIN) != 0 && signals.ask_to_end(true)) || (watched[1].revents & POLLIN) != 0;
  });
  return {};
}

}  // namespace nacelle::simulation
