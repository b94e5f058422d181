// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "diff_drive/port/wheel_encoders.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::diff_drive {

/// One count of the kernel's counter subsystem: /sys/bus/counter/devices/counterN/countM.
///
/// It wraps at its ceiling if it has one, else as an integer of 32 bits, or of 64, which is the same for steps that are no larger.
/// Source: Linux, Documentation/ABI/testing/sysfs-bus-counter.
class KernelCount {
 public:
  [[nodiscard]] static Result<KernelCount, Problem> open(const std::string& folder);

  /// Adds what was counted since the last read. Returns false if it cannot be read.
  [[nodiscard]] bool read();
  [[nodiscard]] bool reopen();
  void drive(int direction);
  [[nodiscard]] std::int64_t count() const { return count_; }

 private:
  explicit KernelCount(std::string folder) : folder_(std::move(folder)) {}
  /// Returns 0, or errno.
  [[nodiscard]] int prepare();
  [[nodiscard]] std::optional<std::uint64_t> raw() const;

  std::string folder_;
  io::Descriptor file_;
  std::uint64_t ceiling_ = 0;    // 0: none
  bool only_increases_ = false;  // it counts pulses, whichever way the wheel turns
  int direction_ = 1;
  std::uint64_t last_ = 0;
  std::int64_t count_ = 0;
};

/// Encoders that the kernel counts.
class CounterEncoders final : public WheelEncoders {
 public:
  /// The folders of two counts. Errors: a Problem that names the folder.
  [[nodiscard]] static Result<std::unique_ptr<WheelEncoders>, Problem> open(const std::string& left,
                                                                            const std::string& right);
  CounterEncoders(KernelCount left, KernelCount right) : left_(std::move(left)), right_(std::move(right)) {}

  [[nodiscard]] bool read(WheelCount& left, WheelCount& right) override;
  void drive(int left, int right) override;
  [[nodiscard]] bool reopen() override { return left_.reopen() && right_.reopen(); }

 private:
  KernelCount left_, right_;
};

}  // namespace nacelle::diff_drive
