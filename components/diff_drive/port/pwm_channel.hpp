// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::diff_drive {

/// Which PWM output of the kernel, and how it is set.
struct PwmSettings {
  std::string chip = "/sys/class/pwm/pwmchip0";
  unsigned channel = 0;
  std::uint64_t period_ns = 1'000'000;
  bool is_inverted = false;  ///< The output is low while it is on.
  /// For so long after its export a channel may be without permissions, until udev has set them.
  Duration patience = 1s;
};

/// Why a channel cannot be used: the step that failed, and errno.
struct PwmFault {
  enum class Step : std::uint8_t {
    Chip,      ///< There is no such chip.
    Channel,   ///< It has fewer channels.
    Export,    ///< The kernel does not hand the channel out.
    Open,      ///< Its files cannot be written.
    Lock,      ///< Another program drives it.
    Period,    ///< The chip cannot do this frequency.
    Polarity,  ///< It cannot invert.
    Enable,
  };
  Step step = Step::Chip;
  int os_code = 0;
};
/// Says what is wrong and what to do.
[[nodiscard]] Problem explain_pwm(const PwmSettings& settings, const PwmFault& fault);

/// One PWM output of the kernel, through sysfs: on for a share of each period.
///
/// It is off from open() on, whatever a program that was killed has left behind, and again when it is destroyed; an inverted one stays enabled then,
/// at a share of zero. Whoever writes the bytes kStop to descriptor() switches it off. Each channel locks its file, so a second program that
/// opens the same channel is refused.
/// Threads:   one.
/// Allocates: nothing but in open() and reopen().
/// Source:    Linux, Documentation/driver-api/pwm.rst, "Using PWMs with the sysfs interface".
class PwmChannel {
 public:
  [[nodiscard]] static Result<std::unique_ptr<PwmChannel>, Problem> open(const PwmSettings& settings);
  ~PwmChannel();
  PwmChannel(const PwmChannel&) = delete;
  PwmChannel& operator=(const PwmChannel&) = delete;

  /// Returns false if the kernel refuses: the chip is gone. Precondition: 0 <= share <= 1.
  [[nodiscard]] bool set(double share);
  /// Opens it anew, under the same number of the descriptor. Returns false if it is still gone; then nothing has changed.
  [[nodiscard]] bool reopen();
  [[nodiscard]] int descriptor() const { return duty_.number(); }

  /// A duty cycle of 0 ns.
  static constexpr std::uint8_t kStop[] = {'0', '\n'};

 private:
  explicit PwmChannel(const PwmSettings& settings) : settings_(settings) {}
  [[nodiscard]] Result<io::Descriptor, PwmFault> prepared();
  [[nodiscard]] std::string file(const char* name) const;

  const PwmSettings settings_;
  io::Descriptor duty_;
  bool is_exported_here_ = false;
};

}  // namespace nacelle::diff_drive
