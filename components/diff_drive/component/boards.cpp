// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/boards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cmath>

#include "diff_drive/component/hiwonder_board.hpp"
#include "diff_drive/component/home_made_board.hpp"
#include "diff_drive/component/odrive_board.hpp"
#include "diff_drive/component/odrive_can_board.hpp"
#include "diff_drive/component/roboclaw_board.hpp"
#include "diff_drive/component/vesc_board.hpp"
#include "diff_drive/component/vesc_can_board.hpp"
#include "diff_drive/component/waveshare_board.hpp"
#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr int kNone = -1;  // every VESC has an id of its own from the factory

constexpr BoardKind kKinds[] = {
    {.name = "waveshare"},
    {.name = "roboclaw",
     .usual_baud = 38400,
     .lowest_channel = 1,
     .highest_channel = 2,
     .usual_left = 1,
     .usual_right = 2},
    {.name = "vesc",
     .lowest_channel = VescPrinter::kOnTheLine,
     .highest_channel = 253,
     .usual_left = VescPrinter::kOnTheLine,
     .usual_right = VescPrinter::kOnTheLine},
    {.name = "odrive",
     .lowest_channel = 0,
     .highest_channel = 1,
     .usual_left = 0,
     .usual_right = 1,
     .usual_counts_per_turn = 1.0},
    {.name = "odrive_can",
     .is_on_can = true,
     .lowest_channel = 0,
     .highest_channel = kOdriveHighestNode,
     .usual_left = 0,
     .usual_right = 1,
     .usual_counts_per_turn = 1.0},
    {.name = "vesc_can",
     .is_on_can = true,
     .lowest_channel = 0,
     .highest_channel = kVescHighestId,
     .usual_left = kNone,
     .usual_right = kNone},
    {.name = "hiwonder",
     .usual_baud = 1000000,
     .lowest_channel = 1,
     .highest_channel = 4,
     .usual_left = 1,
     .usual_right = 2,
     .usual_counts_per_turn = 1.0,
     .reports_wheels = false,
     .has_watchdog = false},
    {.name = "framed"},
    {.name = "text"},
    {.name = "pwm",
     .is_pwm = true,
     .lowest_channel = 0,
     .highest_channel = 63,
     .usual_left = 0,
     .usual_right = 1,
     .has_watchdog = false},
};
constexpr std::int64_t kRoboclawFirst = 0x80, kRoboclawLast = 0x87;

std::chrono::milliseconds watchdog_of(const DiffDriveOptions& options) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(from_seconds(options.motor_watchdog_s));
}

int channel_of(std::int64_t parameter, int usual) {
  // What fits no int fits no board either: the check names the largest.
  return parameter < 0 ? usual : static_cast<int>(std::min<std::int64_t>(parameter, INT_MAX));
}

BaseWiring wiring_of(const DiffDriveOptions& options, const BoardKind& kind) {
  return {{channel_of(options.left_channel, kind.usual_left), options.left_reversed},
          {channel_of(options.right_channel, kind.usual_right), options.right_reversed},
          options.counts_per_turn > 0.0 ? options.counts_per_turn : kind.usual_counts_per_turn};
}

std::optional<Problem> problem_of_channels(const DiffDriveOptions& options, const BoardKind& kind,
                                           const std::string& node) {
  const BaseWiring wiring = wiring_of(options, kind);
  const auto problem_of = [&](const char* parameter, int channel) -> std::optional<Problem> {
    if (channel >= kind.lowest_channel && channel <= kind.highest_channel) return std::nullopt;
    return Problem{
        Place::of_parameter(parameter, node), fmt::format("{} is no channel of a {} board", channel, kind.name),
        kind.usual_left == kNone && kind.lowest_channel > kNone
            ? fmt::format("set it: {} to {}", kind.lowest_channel, kind.highest_channel)
            : fmt::format("they are {} to {}; -1 is the usual one", kind.lowest_channel, kind.highest_channel)};
  };
  if (auto problem = problem_of("left_channel", wiring.left.channel)) return problem;
  if (auto problem = problem_of("right_channel", wiring.right.channel)) return problem;
  if (wiring.left.channel == wiring.right.channel) {
    return Problem{Place::of_parameter("right_channel", node),
                   fmt::format("both wheels are on channel {}", wiring.right.channel),
                   "name the other motor's channel"};
  }
  return std::nullopt;
}

}  // namespace

const BoardKind* board_kind(std::string_view hardware) {
  for (const BoardKind& kind : kKinds) {
    if (kind.name == hardware) return &kind;
  }
  return nullptr;
}

const std::vector<std::string>& hardware_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const BoardKind& kind : kKinds) names.emplace_back(kind.name);
    names.emplace_back("loopback");
    return names;
  }();
  return kNames;
}

std::optional<Problem> problem_of_board(const DiffDriveOptions& options, const std::string& node) {
  const BoardKind* const kind = board_kind(options.hardware);
  NACELLE_EXPECT(kind != nullptr, "loopback has no board");
  if (kind->lowest_channel != kind->highest_channel) {
    if (auto problem = problem_of_channels(options, *kind, node)) return problem;
  }
  if (kind->name != "waveshare" && wiring_of(options, *kind).counts_per_turn <= 0.0) {
    return Problem{Place::of_parameter("counts_per_turn", node),
                   fmt::format("a {} board counts, and how many counts a turn of the wheel has is not set", kind->name),
                   "for an encoder: 4 * lines * gear ratio"};
  }
  if (kind->is_pwm) return problem_of_pwm(options.pwm, node);
  if (options.hardware == "roboclaw" && options.board_address != 0 &&
      (options.board_address < kRoboclawFirst || options.board_address > kRoboclawLast)) {
    return Problem{Place::of_parameter("board_address", node),
                   fmt::format("{} is no address of a RoboClaw", options.board_address),
                   "128 to 135, as set in Motion Studio; 0 is 128"};
  }
  return std::nullopt;
}

BaseWiring wiring_of_board(const DiffDriveOptions& options) {
  const BoardKind* const kind = board_kind(options.hardware);
  NACELLE_EXPECT(kind != nullptr, "loopback has no channels");
  return wiring_of(options, *kind);
}

std::unique_ptr<MotorBoard> make_board(const DiffDriveOptions& options) {
  const BoardKind* const kind = board_kind(options.hardware);
  NACELLE_EXPECT(kind != nullptr, "loopback has no board");
  // Of a cycle, so that its jitter skips no round.
  const Duration period = from_seconds(0.75 / options.update_rate_hz);
  if (kind->name == "roboclaw") {
    const auto address = options.board_address == 0 ? kRoboclawFirst : options.board_address;
    return std::make_unique<RoboclawBoard>(RoboclawBoard::Settings{
        static_cast<std::uint8_t>(address), wiring_of(options, *kind), watchdog_of(options), period});
  }
  if (kind->name == "vesc") return std::make_unique<VescBoard>(VescBoard::Settings{wiring_of(options, *kind), period});
  if (kind->name == "odrive") {
    return std::make_unique<OdriveBoard>(
        OdriveBoard::Settings{wiring_of(options, *kind), watchdog_of(options), period});
  }
  if (kind->name == "odrive_can")
    return std::make_unique<OdriveCanBoard>(OdriveCanBoard::Settings{wiring_of(options, *kind), period});
  if (kind->name == "vesc_can")
    return std::make_unique<VescCanBoard>(VescCanBoard::Settings{wiring_of(options, *kind)});
  if (kind->name == "hiwonder")
    return std::make_unique<HiwonderBoard>(HiwonderBoard::Settings{wiring_of(options, *kind), period});
  if (kind->name == "framed" || kind->name == "text") {
    const HomeMadeSettings settings{wiring_of(options, *kind), watchdog_of(options),
                                    std::chrono::milliseconds{std::lround(1000.0 / options.update_rate_hz)}};
    if (kind->name == "text") return std::make_unique<TextBoard>(settings);
    return std::make_unique<FramedBoard>(settings);
  }
  return std::make_unique<WaveshareBoard>(WaveshareBoard::Settings{options.wheel_radius_m, watchdog_of(options)});
}

std::vector<io::CanFilter> filters_of_board(const DiffDriveOptions& options) {
  const BoardKind* const kind = board_kind(options.hardware);
  NACELLE_EXPECT(kind != nullptr && kind->is_on_can, "only boards on CAN have filters");
  const BaseWiring wiring = wiring_of(options, *kind);
  const auto left = static_cast<std::uint32_t>(wiring.left.channel);
  const auto right = static_cast<std::uint32_t>(wiring.right.channel);
  // Requests of other programs are none of ours.
  constexpr std::uint32_t kFlags = io::kCanExtended | io::kCanRemote;
  if (kind->name == "odrive_can") {
    constexpr std::uint32_t kMask = kFlags | (0x3FU << kOdriveCommandBits);
    return {{left << kOdriveCommandBits, kMask}, {right << kOdriveCommandBits, kMask}};
  }
  constexpr std::uint32_t kMask = kFlags | 0xFF;
  return {{io::kCanExtended | left, kMask}, {io::kCanExtended | right, kMask}, {io::kCanExtended | kVescHostId, kMask}};
}

void warn_of_board(const DiffDriveOptions& options, std::vector<std::string>& warnings) {
  const BoardKind* const kind = board_kind(options.hardware);
  if (kind == nullptr) return;
  if (!kind->reports_wheels) {
    warnings.push_back(fmt::format(
        "a {} board reports nothing about its wheels: joint_states hold what was commanded (open loop), and "
        "odometry made of them does not notice a wheel that slips or stands",
        kind->name));
  }
  if (kind->is_pwm) {
    warnings.emplace_back(
        "the kernel's PWM has no watchdog: the wheels keep their speed when this computer hangs, or when this program "
        "and "
        "its watcher are killed at once");
  } else if (!kind->has_watchdog) {
    warnings.push_back(fmt::format(
        "a {} board has no watchdog: its wheels keep their speed when its cable or this computer fails", kind->name));
  }
}

const std::string& line_of_board(const DiffDriveOptions& options) {
  const BoardKind* const kind = board_kind(options.hardware);
  if (kind == nullptr) return options.hardware;
  if (kind->is_pwm) return options.pwm.chip;
  return kind->is_on_can ? options.can_interface : options.serial_port;
}

}  // namespace nacelle::diff_drive
