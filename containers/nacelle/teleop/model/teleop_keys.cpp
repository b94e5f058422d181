// SPDX-License-Identifier: Apache-2.0
#include "teleop/model/teleop_keys.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace nacelle::teleop {
namespace {

struct Move {
  char key;
  int forward, left;
};
constexpr std::array<Move, 8> kMoves{
    {{'i', 1, 0}, {'o', 1, -1}, {'j', 0, 1}, {'l', 0, -1}, {'u', 1, 1}, {',', -1, 0}, {'.', -1, 1}, {'m', -1, -1}}};

struct SpeedChange {
  char key;
  double speed, yaw_rate;
};
constexpr std::array<SpeedChange, 6> kSpeeds{
    {{'q', 1.1, 1.1}, {'z', 0.9, 0.9}, {'w', 1.1, 1.0}, {'x', 0.9, 1.0}, {'e', 1.0, 1.1}, {'c', 1.0, 0.9}}};

constexpr std::string_view kHolonomic = "tbOIJLU<>M";
// One would do on a reliable stream; a few cost nothing and survive a reader that joined in between.
constexpr int kZeros = 5;

}  // namespace

TeleopKeys::TeleopKeys(const TeleopOptions& options) : options_(options) {}

KeyEffect TeleopKeys::press(char key, MonotonicTime now) {
  for (const auto& change : kSpeeds) {
    if (change.key != key) continue;
    options_.speed_mps = std::min(options_.speed_mps * change.speed, options_.top_speed_mps);
    options_.yaw_rate_rps = std::min(options_.yaw_rate_rps * change.yaw_rate, options_.top_yaw_rate_rps);
    return KeyEffect::Faster;
  }
  for (const auto& move : kMoves) {
    if (move.key != key) continue;
    command_ = {move.forward * options_.speed_mps, move.left * options_.yaw_rate_rps};
    pressed_at_ = now;
    held_ = true;
    return KeyEffect::Drive;
  }
  command_ = {};
  held_ = false;
  zeros_left_ = kZeros;
  return kHolonomic.find(key) != std::string_view::npos ? KeyEffect::Holonomic : KeyEffect::Stop;
}

std::optional<TeleopCommand> TeleopKeys::due(MonotonicTime now) {
  if (held_ && now - pressed_at_ >= options_.release_after) {
    command_ = {};
    held_ = false;
    zeros_left_ = kZeros;
    sent_at_.reset();  // the stop does not wait for its turn
  }
  if (!held_ && zeros_left_ == 0) return std::nullopt;
  if (sent_at_ && now - *sent_at_ < options_.period) return std::nullopt;
  sent_at_ = now;
  if (!held_) --zeros_left_;
  return command_;
}

}  // namespace nacelle::teleop
