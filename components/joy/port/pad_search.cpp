// SPDX-License-Identifier: Apache-2.0
#include "joy/port/pad_search.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/input.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <vector>

namespace nacelle::joy {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJoinGroup = "`sudo usermod -aG input $USER`, then log in again";

template <std::size_t kBits>
std::optional<std::bitset<kBits>> bits_of(int device, unsigned long request) {
  std::array<std::uint8_t, kBits / 8> bytes{};
  if (::ioctl(device, request, bytes.data()) < 0) return std::nullopt;
  std::bitset<kBits> bits;
  for (std::size_t bit = 0; bit < kBits; ++bit) bits[bit] = (bytes[bit / 8] >> (bit % 8) & 1U) != 0;
  return bits;
}

/// The numbers N of eventN, smallest first.
std::vector<unsigned> event_numbers(const fs::path& folder) {
  std::vector<unsigned> numbers;
  std::error_code ignored;
  for (fs::directory_iterator at{folder, ignored}, end; !ignored && at != end; at.increment(ignored)) {
    const std::string name = at->path().filename();
    constexpr std::string_view kBeginning = "event";
    unsigned number = 0;
    if (!name.starts_with(kBeginning)) continue;
    const auto read = std::from_chars(name.data() + kBeginning.size(), name.data() + name.size(), number);
    if (read.ec == std::errc{} && read.ptr == name.data() + name.size()) numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

io::Descriptor open_device(const std::string& path) {
  return io::Descriptor{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
}

/// Times of CLOCK_MONOTONIC instead of the wall clock, which may step.
void use_monotonic_times(int device) {
  int clock = CLOCK_MONOTONIC;
  ::ioctl(device, EVIOCSCLOCKID, &clock);
}

Result<FoundPad, NoPad> open_path(const std::string& path) {
  io::Descriptor device = open_device(path);
  if (!device.is_open()) {
    const bool is_missing = errno == ENOENT || errno == ENODEV || errno == ENXIO;
    if (is_missing)
      return err(NoPad{io::StreamFault::NotFound,
                       {path, "no such device", "is the gamepad plugged in, or paired and switched on?"}});
    const bool is_forbidden = errno == EACCES || errno == EPERM;
    return err(NoPad{io::StreamFault::NotUsable,
                     {path,
                      is_forbidden ? "no permission to open it: members of group input may"
                                   : fmt::format("cannot be opened ({})", std::strerror(errno)),
                      is_forbidden ? kJoinGroup : "give /dev/input/by-id/...-event-joystick, or leave `dev` empty"}});
  }
  auto info = inspect_device(device.number(), path);
  if (!info || !is_gamepad(*info)) {
    return err(NoPad{io::StreamFault::NotUsable,
                     {path, info ? fmt::format("'{}' is no gamepad", info->name) : "not an event device",
                      "give /dev/input/by-id/...-event-joystick (not jsN), or leave `dev` empty"}});
  }
  use_monotonic_times(device.number());
  return FoundPad{std::move(device), std::move(*info)};
}

}  // namespace

std::optional<PadInfo> inspect_device(int device, const std::string& path) {
  PadInfo pad;
  const auto keys = bits_of<pad_codes::kKeyCount>(device, EVIOCGBIT(EV_KEY, pad_codes::kKeyCount / 8));
  const auto axes = bits_of<pad_codes::kAxisCount>(device, EVIOCGBIT(EV_ABS, pad_codes::kAxisCount / 8));
  const auto pressed = bits_of<pad_codes::kKeyCount>(device, EVIOCGKEY(pad_codes::kKeyCount / 8));
  if (!keys || !axes || !pressed) return std::nullopt;
  pad.buttons = *keys;
  pad.pressed = *pressed;
  for (unsigned code = 0; code < pad_codes::kAxisCount; ++code) {
    input_absinfo axis{};
    if (!axes->test(code)) continue;
    if (::ioctl(device, EVIOCGABS(code), &axis) < 0) return std::nullopt;
    pad.axes[code] = PadAxis{axis.value, axis.minimum, axis.maximum};
  }
  std::array<char, 256> name{};
  if (::ioctl(device, EVIOCGNAME(name.size() - 1), name.data()) >= 0) pad.name = name.data();
  pad.path = path;
  return pad;
}

Result<FoundPad, NoPad> find_pad(const PadWish& wish) {
  if (!wish.path.empty()) return open_path(wish.path);
  std::vector<std::string> names;
  std::size_t forbidden = 0;
  for (const unsigned number : event_numbers(wish.folder)) {
    const std::string path = wish.folder / fmt::format("event{}", number);
    io::Descriptor device = open_device(path);
    if (!device.is_open()) {
      forbidden += errno == EACCES || errno == EPERM ? 1 : 0;
      continue;
    }
    auto info = inspect_device(device.number(), path);
    if (!info || !is_gamepad(*info)) continue;
    names.push_back(info->name);
    if (wish.name.empty() ? names.size() <= wish.index : info->name != wish.name) continue;
    use_monotonic_times(device.number());
    return FoundPad{std::move(device), std::move(*info)};
  }
  Problem problem{wish.folder.string(), "no gamepad is there", "is it plugged in, or paired and switched on?"};
  if (!wish.name.empty()) problem.what = fmt::format("no gamepad called '{}' is there", wish.name);
  if (wish.name.empty() && wish.index > 0) problem.what = fmt::format("there is no gamepad number {}", wish.index);
  if (!names.empty())
    problem.way_out = fmt::format("those that are there, from number 0: '{}'", fmt::join(names, "', '"));
  if (forbidden > 0) {
    problem.what += fmt::format(", but {} input devices may not be opened", forbidden);
    problem.way_out = kJoinGroup;
  }
  return err(NoPad{io::StreamFault::NotFound, std::move(problem)});
}

}  // namespace nacelle::joy
