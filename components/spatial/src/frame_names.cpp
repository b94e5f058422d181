// SPDX-License-Identifier: Apache-2.0
#include "frame_names.hpp"

#include <bit>
#include <cstring>

namespace nacelle::spatial {
namespace {

// Eight bytes at a time, the last eight overlapping: names are short and looked up often. Its weakness against chosen names
// is bounded by the capacity of the table.
std::size_t hash_of(std::string_view name) {
  constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15ULL;  // 2^64 / golden ratio
  const auto mix = [](std::uint64_t h, std::uint64_t word) {
    h = (h ^ word) * kMultiplier;
    h = (h ^ (h >> 32U)) *
        kMultiplier;  // twice: the last letter stands in the highest byte and must reach the lowest bits
    return h ^ (h >> 32U);
  };
  const auto load = [](const char* from, std::size_t bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, from, bytes);
    return word;
  };
  std::uint64_t h = name.size();
  const char* p = name.data();
  std::size_t left = name.size();
  for (; left > 8; left -= 8, p += 8) h = mix(h, load(p, 8));
  if (name.size() >= 8) return mix(h, load(name.data() + name.size() - 8, 8));
  if (left >= 4) return mix(h, load(p, 4) | load(p + left - 4, 4) << 32U);
  for (std::size_t i = 0; i < left; ++i) h = mix(h, static_cast<unsigned char>(p[i]));
  return h;
}

}  // namespace

FrameNames::FrameNames(std::size_t capacity)
    : capacity_(capacity),
      mask_(std::bit_ceil(2 * capacity) - 1),
      names_(capacity),
      slots_(std::make_unique<std::atomic<std::uint32_t>[]>(mask_ + 1)) {}

std::uint32_t FrameNames::find(std::string_view name) const {
  for (std::size_t i = hash_of(name) & mask_;; i = (i + 1) & mask_) {
    const std::uint32_t id = slots_[i].load(std::memory_order_acquire);
    if (id == 0) return 0;
    if (names_[id - 1] == name) return id;
  }
}

std::uint32_t FrameNames::add(std::string_view name) {
  if (const std::uint32_t known = find(name); known != 0) return known;
  const std::uint32_t count = size_.load(std::memory_order_relaxed);
  if (count == capacity_) return 0;
  names_[count] = name;
  std::size_t i = hash_of(name) & mask_;
  while (slots_[i].load(std::memory_order_relaxed) != 0) i = (i + 1) & mask_;
  size_.store(count + 1, std::memory_order_release);
  slots_[i].store(count + 1, std::memory_order_release);
  return count + 1;
}

std::string_view FrameNames::name(std::uint32_t id) const {
  return id == 0 || id > size() ? std::string_view{} : std::string_view{names_[id - 1]};
}

}  // namespace nacelle::spatial
