// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/pwm_channel.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>

#include "nacelle/io/attribute_file.hpp"
#include "nacelle/io/device_access.hpp"

namespace nacelle::diff_drive {
namespace {

using Step = PwmFault::Step;

constexpr Duration kLookAgainAfter = 10ms;

void rest(Duration length) {
  const timespec left{0, length.count()};
  ::nanosleep(&left, nullptr);
}

std::string file_of(const PwmSettings& settings, const char* name) {
  return fmt::format("{}/pwm{}/{}", settings.chip, settings.channel, name);
}

/// Returns who has the channel's file open.
std::string holders(const PwmSettings& settings) {
  std::error_code unknown;
  const auto path = std::filesystem::canonical(file_of(settings, "duty_cycle"), unknown);
  return io::names_of(io::holders_of(path.string()));
}

}  // namespace

Problem explain_pwm(const PwmSettings& settings, const PwmFault& fault) {
  Problem problem{fmt::format("PWM channel {} of {}", settings.channel, settings.chip),
                  fmt::format("cannot be used ({})", std::strerror(fault.os_code)),
                  "`ls /sys/class/pwm` lists the chips"};
  if (fault.os_code == EACCES || fault.os_code == EPERM) {
    problem.what = "no permission to write its files";
    problem.way_out =
        "`sudo usermod -aG gpio $USER`, then log in again; the package's udev rule gives PWM to this group";
    return problem;
  }
  switch (fault.step) {
    case Step::Chip:
      problem.what = "no such chip";
      problem.way_out =
          "on a Raspberry Pi: add `dtoverlay=pwm-2chan,pin=12,func=4,pin2=13,func2=4` to /boot/firmware/config.txt and "
          "start it anew; `ls /sys/class/pwm` lists the chips";
      break;
    case Step::Channel:
      problem.what = "the chip has no such channel";
      problem.way_out = fmt::format("`cat {}/npwm` says how many it has; they count from 0", settings.chip);
      break;
    case Step::Export:
      if (fault.os_code != EBUSY) break;
      problem.what = "in use by a driver of the kernel (a fan, a backlight, sound)";
      problem.way_out = "`sudo cat /sys/kernel/debug/pwm` names it; use another channel";
      break;
    case Step::Lock: {
      const std::string who = holders(settings);
      problem.what = who.empty() ? "in use by another program" : "in use by " + who;
      problem.way_out = "end that program";
      break;
    }
    case Step::Period:
      problem.what = fmt::format("the chip does not do {:.6g} Hz ({})", 1e9 / static_cast<double>(settings.period_ns),
                                 std::strerror(fault.os_code));
      problem.way_out = "try another pwm.frequency; some chips have one for all their channels";
      break;
    case Step::Polarity:
      problem.what = "the chip cannot invert its output";
      problem.way_out = "set pwm.inverted: false, and invert it in the circuit";
      break;
    case Step::Open:
    case Step::Enable: break;
  }
  return problem;
}

std::string PwmChannel::file(const char* name) const { return file_of(settings_, name); }

Result<std::unique_ptr<PwmChannel>, Problem> PwmChannel::open(const PwmSettings& settings) {
  std::unique_ptr<PwmChannel> channel{new PwmChannel(settings)};
  auto duty = channel->prepared();
  if (!duty) return err(explain_pwm(settings, duty.error()));
  channel->duty_ = std::move(duty).value();
  return channel;
}

PwmChannel::~PwmChannel() {
  if (!duty_.is_open()) return;
  static_cast<void>(set(0.0));
  // Chips put a channel that is disabled low, whatever its polarity: that would be on.
  if (settings_.is_inverted) return;
  static_cast<void>(io::write_attribute(file("enable"), "0\n"));
  if (is_exported_here_)
    static_cast<void>(io::write_attribute(settings_.chip + "/unexport", fmt::format("{}\n", settings_.channel)));
}

Result<io::Descriptor, PwmFault> PwmChannel::prepared() {
  const auto channels = io::read_attribute(settings_.chip + "/npwm");
  if (!channels) return err(PwmFault{Step::Chip, errno});
  unsigned count = 0;
  std::from_chars(channels->data(), channels->data() + channels->size(), count);
  if (settings_.channel >= count) return err(PwmFault{Step::Channel, ENODEV});

  std::error_code unknown;
  if (!std::filesystem::exists(file("duty_cycle"), unknown)) {
    if (const int refused = io::write_attribute(settings_.chip + "/export", fmt::format("{}\n", settings_.channel));
        refused != 0) {
      return err(PwmFault{Step::Export, refused});
    }
    is_exported_here_ = true;
  }
  // udev gives the files of a channel that was just exported to the group, a moment later.
  io::Descriptor duty;
  for (Duration waited{};; waited += kLookAgainAfter) {
    duty = io::Descriptor{::open(file("duty_cycle").c_str(), O_WRONLY | O_CLOEXEC)};
    if (duty.is_open() && ::access(file("enable").c_str(), W_OK) == 0) break;
    const int refused = errno;
    const bool is_early = is_exported_here_ && (refused == EACCES || refused == ENOENT);
    if (!is_early || waited >= settings_.patience) return err(PwmFault{Step::Open, refused});
    rest(kLookAgainAfter);
  }
  if (::flock(duty.number(), LOCK_EX | LOCK_NB) != 0) return err(PwmFault{Step::Lock, errno});

  // A channel that has no period yet refuses even this; one that a killed program left behind stops here.
  static_cast<void>(!::pwrite(duty.number(), kStop, sizeof kStop, 0));
  if (io::read_attribute(file("enable")) != "0") {
    if (const int refused = io::write_attribute(file("enable"), "0\n"); refused != 0)
      return err(PwmFault{Step::Enable, refused});
  }
  if (const int refused = io::write_attribute(file("period"), fmt::format("{}\n", settings_.period_ns)); refused != 0)
    return err(PwmFault{Step::Period, refused});
  const std::string polarity = settings_.is_inverted ? "inversed" : "normal";
  // Chips that cannot invert have no such file, or refuse to write it.
  if (const auto now_is = io::read_attribute(file("polarity")).value_or("normal"); now_is != polarity) {
    if (const int refused = io::write_attribute(file("polarity"), polarity + "\n"); refused != 0)
      return err(PwmFault{Step::Polarity, refused});
  }
  if (::pwrite(duty.number(), kStop, sizeof kStop, 0) != sizeof kStop) return err(PwmFault{Step::Open, errno});
  if (const int refused = io::write_attribute(file("enable"), "1\n"); refused != 0)
    return err(PwmFault{Step::Enable, refused});
  return duty;
}

bool PwmChannel::set(double share) {
  std::array<char, 24> text{};
  const auto on_ns = static_cast<std::uint64_t>(std::lround(share * static_cast<double>(settings_.period_ns)));
  char* const end = std::to_chars(text.data(), text.data() + text.size() - 1, on_ns).ptr;
  *end = '\n';
  const auto length = static_cast<std::size_t>(end + 1 - text.data());
  return ::pwrite(duty_.number(), text.data(), length, 0) == static_cast<ssize_t>(length);
}

bool PwmChannel::reopen() {
  // The old file's lock would keep this program out of a channel that never went away.
  ::flock(duty_.number(), LOCK_UN);
  auto again = prepared();
  // Who registered the number keeps it.
  return again && ::dup3(again->number(), duty_.number(), O_CLOEXEC) == duty_.number();
}

}  // namespace nacelle::diff_drive
