// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/i2c_bus.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <ctime>

namespace nacelle::io {
namespace {

enum class I2cStep : std::uint8_t { Open, Functions, Claim };
struct I2cOpenFault {
  I2cStep step;
  int os_code;
};

Result<Descriptor, I2cOpenFault> open_adapter(const I2cSettings& settings) {
  Descriptor bus{::open(settings.path.c_str(), O_RDWR | O_CLOEXEC)};
  if (!bus.is_open()) return err(I2cOpenFault{I2cStep::Open, errno});
  unsigned long functions = 0;
  if (::ioctl(bus.number(), I2C_FUNCS, &functions) != 0) return err(I2cOpenFault{I2cStep::Functions, errno});
  if ((functions & I2C_FUNC_I2C) == 0) return err(I2cOpenFault{I2cStep::Functions, EOPNOTSUPP});
  // I2C_RDWR does not ask whether the address is taken; this does.
  if (::ioctl(bus.number(), I2C_SLAVE, static_cast<unsigned long>(settings.address)) != 0)
    return err(I2cOpenFault{I2cStep::Claim, errno});
  // Adapters that poll have no time-out of their own and ignore it; that is no failure.
  ::ioctl(bus.number(), I2C_TIMEOUT, static_cast<unsigned long>(settings.transfer_timeout / 10ms));
  return bus;
}

Problem explain(const I2cSettings& settings, I2cOpenFault fault) {
  Problem problem{settings.path, fmt::format("cannot be opened ({})", std::strerror(fault.os_code)),
                  "`ls /dev/i2c-*` lists the buses"};
  if (fault.step == I2cStep::Functions) {
    problem.what = fault.os_code == EOPNOTSUPP ? "the adapter has no I2C transfers (SMBus only)" : "not an I2C bus";
    problem.way_out = "give the path of another bus; `i2cdetect -l` lists them";
  } else if (fault.step == I2cStep::Claim) {
    problem.what = fault.os_code == EBUSY
                       ? fmt::format("a driver of the kernel uses address 0x{:02x}", settings.address)
                       : fmt::format("0x{:02x} is no address ({})", settings.address, std::strerror(fault.os_code));
    problem.way_out = fault.os_code == EBUSY ? "unbind that driver, see /sys/bus/i2c/devices" : "give 0x08 to 0x77";
  } else if (fault.os_code == ENOENT || fault.os_code == ENXIO || fault.os_code == ENODEV) {
    problem.what = "no such bus";
    problem.way_out = "is I2C enabled (`sudo raspi-config nonint do_i2c 0`) and i2c-dev loaded? `ls /dev/i2c-*`";
  } else if (fault.os_code == EACCES || fault.os_code == EPERM) {
    problem.what = "no right to open it";
    problem.way_out = "`sudo usermod -aG i2c $USER`, then log in again";
  }
  return problem;
}

bool is_missing(I2cOpenFault fault) {
  return fault.step == I2cStep::Open && (fault.os_code == ENOENT || fault.os_code == ENXIO || fault.os_code == ENODEV);
}

// Source: the kernel's Documentation/i2c/fault-codes.rst. Adapters differ in which code a missing acknowledge has.
StreamFault fault_of(int os_code, bool reading) {
  switch (os_code) {
    case ENXIO:
    case EREMOTEIO: return StreamFault::NoAnswer;
    case ETIMEDOUT:
    case EAGAIN:
    case EBUSY: return StreamFault::BusStuck;
    case ENODEV:
    case EBADF: return StreamFault::HungUp;
    default: return reading ? StreamFault::ReadFailed : StreamFault::WriteFailed;
  }
}

}  // namespace

I2cBus::I2cBus(I2cSettings settings, const Clock& clock, Descriptor bus)
    : settings_(std::move(settings)), clock_(clock), bus_(std::move(bus)) {}

Result<std::unique_ptr<I2cBus>, Problem> I2cBus::open(const I2cSettings& settings, const Clock& clock,
                                                      Duration patience) {
  const MonotonicTime deadline = clock.now() + patience;
  for (;;) {
    auto bus = open_adapter(settings);
    if (bus) return std::unique_ptr<I2cBus>{new I2cBus{settings, clock, std::move(bus).value()}};
    if (!is_missing(bus.error()) || clock.now() >= deadline) return err(explain(settings, bus.error()));
    timespec pause{0, 20'000'000};
    ::nanosleep(&pause, nullptr);
  }
}

Result<std::unique_ptr<I2cBus>, Problem> I2cBus::open_or_await(const I2cSettings& settings, const Clock& clock) {
  auto bus = open_adapter(settings);
  if (bus) return std::unique_ptr<I2cBus>{new I2cBus{settings, clock, std::move(bus).value()}};
  if (!is_missing(bus.error())) return err(explain(settings, bus.error()));
  std::unique_ptr<I2cBus> away{new I2cBus{settings, clock, Descriptor{}}};
  away->away_ = true;
  return away;
}

Result<void, StreamFault> I2cBus::transfer(std::uint8_t address, ByteView out, ByteSpan in) {
  if (is_away()) return err(StreamFault::NotFound);
  i2c_msg messages[2];
  unsigned count = 0;
  // The kernel does not write to the buffer of a message without I2C_M_RD.
  if (!out.empty()) { messages[count++] = {address, 0, static_cast<__u16>(out.size()), const_cast<__u8*>(out.data())}; }
  if (!in.empty()) messages[count++] = {address, I2C_M_RD, static_cast<__u16>(in.size()), in.data()};
  i2c_rdwr_ioctl_data request{messages, count};
  for (;;) {
    if (::ioctl(bus_.number(), I2C_RDWR, &request) >= 0) return {};
    if (errno != EINTR) return err(fault_of(errno, !in.empty()));
  }
}

bool I2cBus::wait_until(MonotonicTime time) { return wait_readable(-1, bell_, clock_, time) != Wake::Woken; }

Result<void, StreamFault> I2cBus::reopen() {
  // The kernel does not let an unplugged adapter go while it is open: its driver waits, and its number is not free for the one that returns.
  bus_ = Descriptor{};
  away_ = true;
  auto fresh = open_adapter(settings_);
  if (!fresh) return err(is_missing(fresh.error()) ? StreamFault::NotFound : StreamFault::NotUsable);
  bus_ = std::move(fresh).value();
  away_ = false;
  return {};
}

}  // namespace nacelle::io
