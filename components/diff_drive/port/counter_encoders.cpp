// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/counter_encoders.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "nacelle/io/attribute_file.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr std::uint64_t kHighestCeiling = std::uint64_t{1} << 62U;

Problem explain(const std::string& folder, int os_code) {
  Problem problem{folder, fmt::format("cannot be read as a counter ({})", std::strerror(os_code)),
                  "`ls -d /sys/bus/counter/devices/*/count*` lists what the kernel counts"};
  switch (os_code) {
    case ENOENT:
    case ENODEV:
      problem.what = "no such counter";
      problem.way_out += "; without one, pwm.encoder: gpio counts edges of GPIO lines";
      break;
    case EACCES:
    case EPERM:
      problem.what = "no permission to use the counter";
      problem.way_out =
          "`sudo usermod -aG gpio $USER`, then log in again; the package's udev rule gives counters to this group";
      break;
    default: break;
  }
  return problem;
}

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{}) return std::nullopt;
  return number;
}

}  // namespace

Result<KernelCount, Problem> KernelCount::open(const std::string& folder) {
  KernelCount counter{folder};
  if (const int refused = counter.prepare(); refused != 0) return err(explain(folder, refused));
  return counter;
}

int KernelCount::prepare() {
  io::Descriptor file{::open((folder_ + "/count").c_str(), O_RDONLY | O_CLOEXEC)};
  if (!file.is_open()) return errno;
  if (io::read_attribute(folder_ + "/enable") == "0") {
    if (const int refused = io::write_attribute(folder_ + "/enable", "1\n"); refused != 0) return refused;
  }
  ceiling_ = number_in(io::read_attribute(folder_ + "/ceiling").value_or("")).value_or(0);
  if (ceiling_ > kHighestCeiling) ceiling_ = 0;  // it wraps as the integer does
  only_increases_ = io::read_attribute(folder_ + "/function") == "increase";
  file_ = std::move(file);
  const auto now_is = raw();
  if (!now_is) return errno == 0 ? EINVAL : errno;
  last_ = *now_is;
  return 0;
}

std::optional<std::uint64_t> KernelCount::raw() const {
  std::array<char, 32> text{};
  errno = 0;
  const ssize_t length = ::pread(file_.number(), text.data(), text.size(), 0);
  if (length <= 0) return std::nullopt;
  return number_in({text.data(), static_cast<std::size_t>(length)});
}

bool KernelCount::read() {
  const auto now_is = raw();
  if (!now_is) return false;
  const std::uint64_t step = *now_is - std::exchange(last_, *now_is);
  std::int64_t counted = 0;
  if (ceiling_ == 0) {
    counted = static_cast<std::int32_t>(static_cast<std::uint32_t>(step));
  } else {
    const auto range = static_cast<std::int64_t>(ceiling_) + 1;
    counted = static_cast<std::int64_t>(step) % range;
    if (counted > range / 2) counted -= range;
    if (counted < -(range / 2)) counted += range;
  }
  count_ += only_increases_ ? direction_ * counted : counted;
  return true;
}

void KernelCount::drive(int direction) {
  if (direction != 0) direction_ = direction;
}

bool KernelCount::reopen() { return prepare() == 0; }

Result<std::unique_ptr<WheelEncoders>, Problem> CounterEncoders::open(const std::string& left,
                                                                      const std::string& right) {
  auto left_count = KernelCount::open(left);
  if (!left_count) return err(left_count.error());
  auto right_count = KernelCount::open(right);
  if (!right_count) return err(right_count.error());
  return std::unique_ptr<WheelEncoders>{
      std::make_unique<CounterEncoders>(std::move(left_count).value(), std::move(right_count).value())};
}

bool CounterEncoders::read(WheelCount& left, WheelCount& right) {
  if (!left_.read() || !right_.read()) return false;
  left.count = left_.count();
  right.count = right_.count();
  return true;
}

void CounterEncoders::drive(int left, int right) {
  left_.drive(left);
  right_.drive(right);
}

}  // namespace nacelle::diff_drive
