// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/sampling_map.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::image_proc {
namespace {

constexpr std::uint32_t kOne = 256;  // weights, and points, are in 1/256
constexpr std::uint16_t kOutside = 0xFFFF;

struct Place {
  std::uint16_t first, weight;
};

// The last pixel is the right neighbour of the one before it, so that each point has two neighbours; of one pixel alone both are that one.
Place place_of(double at, std::uint32_t count) {
  const auto parts = static_cast<std::uint32_t>(std::lround(at * kOne));
  const std::uint32_t first = std::min(parts / kOne, count < 2 ? 0 : count - 2);
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(parts - first * kOne)};
}

// The points that round to one outside are few; 1/512 pixel is what rounding forgives.
bool is_inside(double at, std::uint32_t count) {
  constexpr double kRounding = 0.5 / kOne;
  return at > -kRounding && at < count - 1 + kRounding;
}

}  // namespace

SamplingMap::SamplingMap(Size source, Size made)
    : source_(source), made_(made), taps_(std::size_t{made.width} * made.height, Tap{0, 0, kOutside, 0}) {}

void SamplingMap::set(std::uint32_t u, std::uint32_t v, SourcePoint from, Interpolation interpolation) {
  Tap& tap = taps_[std::size_t{v} * made_.width + u];
  if (interpolation == Interpolation::Nearest) from = {std::round(from.x), std::round(from.y)};
  if (!is_inside(from.x, source_.width) || !is_inside(from.y, source_.height)) {
    tap = {0, 0, kOutside, 0};
    return;
  }
  const Place x = place_of(std::max(from.x, 0.0), source_.width), y = place_of(std::max(from.y, 0.0), source_.height);
  tap = {x.first, y.first, x.weight, y.weight};
}

template <int kChannels>
void SamplingMap::apply_to(const Picture& picture, std::uint8_t* out) const {
  const std::size_t right = source_.width < 2 ? 0 : kChannels;
  const std::size_t below = source_.height < 2 ? 0 : picture.step;
  for (const Tap& tap : taps_) {
    if (tap.weight_x == kOutside) {
      std::fill(out, out + kChannels, std::uint8_t{0});
    } else {
      const std::uint8_t* const at = picture.pixels + tap.y * picture.step + std::size_t{tap.x} * kChannels;
      const std::uint32_t wx = tap.weight_x, wy = tap.weight_y;
      for (std::size_t c = 0; c < kChannels; ++c) {
        const std::uint32_t upper = at[c] * (kOne - wx) + at[c + right] * wx;
        const std::uint32_t lower = at[c + below] * (kOne - wx) + at[c + below + right] * wx;
        out[c] = static_cast<std::uint8_t>((upper * (kOne - wy) + lower * wy + kOne * kOne / 2) / (kOne * kOne));
      }
    }
    out += kChannels;
  }
}

void SamplingMap::apply(const Picture& picture, std::uint8_t* out) const {
  switch (picture.encoding.channels) {
    case 1: return apply_to<1>(picture, out);
    case 3: return apply_to<3>(picture, out);
    default: return apply_to<4>(picture, out);
  }
}

}  // namespace nacelle::image_proc
