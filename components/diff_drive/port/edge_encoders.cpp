// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/edge_encoders.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace nacelle::diff_drive {
namespace {

/// How far behind the number an edge is, across the wrap.
std::int32_t since(const io::GpioEdge& edge, std::uint32_t sequence) {
  return static_cast<std::int32_t>(edge.sequence - sequence);
}

}  // namespace

EdgeEncoders::EdgeEncoders(std::unique_ptr<io::GpioInputs> lines, bool has_b)
    : lines_(std::move(lines)), lines_a_wheel_(has_b ? 2 : 1), wheels_{EdgeCounter{has_b}, EdgeCounter{has_b}} {
  begin();
}

bool EdgeEncoders::begin() {
  const auto levels = lines_->levels();
  if (!levels) return false;
  sequence_ = 0;
  for (unsigned wheel = 0; wheel < wheels_.size(); ++wheel) {
    const std::uint64_t own = *levels >> (wheel * lines_a_wheel_);
    wheels_[wheel].begin((own & 1U) != 0, (own & 2U) != 0);
  }
  return true;
}

bool EdgeEncoders::read(WheelCount& left, WheelCount& right) {
  // A line that hums must not hold the loop: at most what the kernel remembers.
  std::size_t taken = 0;
  while (taken + io::GpioInputs::kBatch <= edges_.size()) {
    const auto edges = lines_->take();
    if (!edges) return false;
    if (edges->empty()) break;
    std::copy(edges->begin(), edges->end(), edges_.begin() + static_cast<std::ptrdiff_t>(taken));
    taken += edges->size();
  }
  const std::span<io::GpioEdge> all{edges_.data(), taken};
  std::sort(all.begin(), all.end(), [this](const io::GpioEdge& one, const io::GpioEdge& other) {
    // Two edges of a line may have one number in the request, as the kernel wrote it twice; never those of two lines.
    if (one.sequence == other.sequence) return static_cast<std::int32_t>(one.number - other.number) < 0;
    return since(one, sequence_) < since(other, sequence_);
  });
  for (const io::GpioEdge& edge : all) count(edge);
  left = {wheels_[0].count(), wheels_[0].edge_at()};
  right = {wheels_[1].count(), wheels_[1].edge_at()};
  return true;
}

void EdgeEncoders::count(const io::GpioEdge& edge) {
  const std::int32_t step = since(edge, sequence_);
  if (step > 1) {
    for (EdgeCounter& wheel : wheels_) wheel.gap();
  }
  if (step > 0) sequence_ = edge.sequence;  // else it was overtaken by one that was read before
  const auto channel = edge.line % lines_a_wheel_ == 0 ? EdgeCounter::Channel::A : EdgeCounter::Channel::B;
  wheels_.at(edge.line / lines_a_wheel_).edge(channel, edge.rising, edge.number, edge.at, step > 1);
}

void EdgeEncoders::drive(int left, int right) {
  wheels_[0].drive(left);
  wheels_[1].drive(right);
}

WheelEncoders::Stats EdgeEncoders::stats() const {
  return {wheels_[0].edges() + wheels_[1].edges(), wheels_[0].lost() + wheels_[1].lost()};
}

}  // namespace nacelle::diff_drive
