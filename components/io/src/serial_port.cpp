// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/serial_port.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>

#include "nacelle/io/baud.hpp"
#include "nacelle/io/device_access.hpp"

namespace nacelle::io {
namespace {

struct BaudName {
  unsigned baud;
  speed_t name;
};
constexpr speed_t kByNumber = B0;  // no name
constexpr std::array kBauds{
    BaudName{1200, B1200},       BaudName{2400, B2400},       BaudName{4800, B4800},       BaudName{9600, B9600},
    BaudName{19200, B19200},     BaudName{38400, B38400},     BaudName{57600, B57600},     BaudName{115200, B115200},
    BaudName{128000, kByNumber}, BaudName{153600, kByNumber}, BaudName{230400, B230400},   BaudName{256000, kByNumber},
    BaudName{512000, kByNumber}, BaudName{460800, B460800},   BaudName{500000, B500000},   BaudName{576000, B576000},
    BaudName{921600, B921600},   BaudName{1000000, B1000000}, BaudName{1152000, B1152000}, BaudName{1500000, B1500000},
    BaudName{2000000, B2000000}, BaudName{2500000, B2500000}, BaudName{3000000, B3000000}, BaudName{3500000, B3500000},
    BaudName{4000000, B4000000}};

std::optional<speed_t> speed_of(unsigned baud) {
  for (const auto& known : kBauds) {
    if (known.baud == baud) return known.name;
  }
  return std::nullopt;
}

enum class OpenStep : std::uint8_t { Open, Identify, Lock, Configure };
struct OpenFault {
  OpenStep step;
  int os_code;
};

// Unix98 pty slaves have the majors 136 to 143 (kernel, Documentation/admin-guide/devices.txt).
bool is_pty(const struct stat& status) { return major(status.st_rdev) >= 136 && major(status.st_rdev) <= 143; }

Result<Descriptor, OpenFault> open_line(const SerialSettings& settings) {
  Descriptor line{::open(settings.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (!line.is_open()) return err(OpenFault{OpenStep::Open, errno});
  struct stat status {};
  termios options{};
  if (::fstat(line.number(), &status) != 0 || ::tcgetattr(line.number(), &options) != 0) {
    return err(OpenFault{OpenStep::Identify, errno});
  }
  if (::flock(line.number(), LOCK_EX | LOCK_NB) != 0) return err(OpenFault{OpenStep::Lock, errno});
  // Not every driver knows TIOCEXCL; flock() above is what two programs of ours agree on.
  if (!is_pty(status)) ::ioctl(line.number(), TIOCEXCL);

  ::cfmakeraw(&options);
  options.c_cflag |= CLOCAL | CREAD;
  options.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  options.c_cc[VMIN] = 1;
  options.c_cc[VTIME] = 0;
  const auto named = speed_of(settings.baud).value_or(B115200);
  const auto speed = named == kByNumber ? B115200 : named;
  if (::cfsetispeed(&options, speed) != 0 || ::cfsetospeed(&options, speed) != 0 ||
      ::tcsetattr(line.number(), TCSANOW, &options) != 0 ||
      (named == kByNumber && !set_baud_by_number(line.number(), settings.baud))) {
    return err(OpenFault{OpenStep::Configure, errno});
  }
  // Bytes that waited in the kernel were sent before the line was opened: their time of receipt would be wrong.
  ::tcflush(line.number(), TCIFLUSH);
  return line;
}

bool is_missing(OpenFault fault) {
  return fault.step == OpenStep::Open &&
         (fault.os_code == ENOENT || fault.os_code == ENXIO || fault.os_code == ENODEV || fault.os_code == EIO);
}

StreamFault stream_fault(OpenFault fault) {
  if (is_missing(fault)) return StreamFault::NotFound;
  if (fault.os_code == EACCES || fault.os_code == EPERM) return StreamFault::NotPermitted;
  return fault.step == OpenStep::Lock || fault.os_code == EBUSY ? StreamFault::InUse : StreamFault::NotUsable;
}

Problem explain(const SerialSettings& settings, OpenFault fault, Duration patience) {
  if (fault.step == OpenStep::Identify) {
    return {settings.path, "not a serial line", "give the path of a terminal device, as in `ls -l /dev/serial/by-id`"};
  }
  if (fault.step == OpenStep::Configure) {
    return {settings.path,
            fmt::format("does not take 8N1 at {} baud ({})", settings.baud, std::strerror(fault.os_code)),
            "is the device on another port?"};
  }
  Problem problem = why_not_opened(settings.path, fault.step == OpenStep::Lock ? EBUSY : fault.os_code);
  if (is_missing(fault) && patience > Duration::zero())
    problem.what += fmt::format(" (waited {:.1f} s for it)", to_seconds(patience));
  return problem;
}

}  // namespace

bool is_standard_baud(unsigned baud) { return speed_of(baud).has_value(); }

SerialPort::SerialPort(SerialSettings settings, const Clock& clock, Descriptor line)
    : settings_(std::move(settings)), clock_(clock), line_(std::move(line)) {}

Result<std::unique_ptr<SerialPort>, Problem> SerialPort::open(const SerialSettings& settings, const Clock& clock,
                                                              Duration patience) {
  if (!is_standard_baud(settings.baud)) {
    return err(Problem{settings.path, fmt::format("{} is not a standard baud rate", settings.baud),
                       "usual ones are 9600, 57600, 115200, 230400, 460800 and 921600"});
  }
  const MonotonicTime deadline = clock.now() + patience;
  for (;;) {
    auto line = open_line(settings);
    if (line) return std::unique_ptr<SerialPort>{new SerialPort{settings, clock, std::move(line).value()}};
    if (!is_missing(line.error()) || clock.now() >= deadline) return err(explain(settings, line.error(), patience));
    // udev makes the link some tens of milliseconds after the device; looking at that pace costs nothing.
    timespec pause{0, 20'000'000};
    ::nanosleep(&pause, nullptr);
  }
}

Result<std::unique_ptr<SerialPort>, Problem> SerialPort::open_or_await(const SerialSettings& settings,
                                                                       const Clock& clock) {
  if (!is_standard_baud(settings.baud)) return open(settings, clock);  // which says so
  auto line = open_line(settings);
  if (line) return std::unique_ptr<SerialPort>{new SerialPort{settings, clock, std::move(line).value()}};
  Descriptor reserved{is_missing(line.error()) ? ::open("/dev/null", O_RDWR | O_CLOEXEC) : -1};
  if (!reserved.is_open()) return err(explain(settings, line.error(), {}));
  std::unique_ptr<SerialPort> port{new SerialPort{settings, clock, std::move(reserved)}};
  port->away_ = true;
  return port;
}

Result<ByteView, StreamFault> SerialPort::read_until(MonotonicTime deadline) {
  if (is_away()) return err(StreamFault::NotFound);
  for (;;) {
    switch (wait_readable(line_.number(), bell_, clock_, deadline)) {
      case Wake::TimedOut:
      case Wake::Woken: return ByteView{};
      case Wake::HungUp: return err(StreamFault::HungUp);
      case Wake::Ready: break;
    }
    const ssize_t count = ::read(line_.number(), buffer_.data(), buffer_.size());
    if (count > 0) return ByteView{buffer_.data(), static_cast<std::size_t>(count)};
    // poll() said that there is something: no byte then is how a vanished device reads.
    if (count == 0 || errno == EIO || errno == ENXIO || errno == ENODEV) return err(StreamFault::HungUp);
    if (errno != EAGAIN && errno != EINTR) return err(StreamFault::ReadFailed);
  }
}

Result<void, StreamFault> SerialPort::write(ByteView bytes) {
  if (is_away()) return err(StreamFault::NotFound);
  while (!bytes.empty()) {
    const ssize_t count = ::write(line_.number(), bytes.data(), bytes.size());
    if (count > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
      continue;
    }
    if (count < 0 && (errno == EIO || errno == ENXIO || errno == ENODEV)) return err(StreamFault::HungUp);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return err(StreamFault::WriteFailed);
    switch (wait_writable(line_.number(), clock_, clock_.now() + settings_.write_timeout)) {
      case Wake::Ready: break;
      case Wake::HungUp: return err(StreamFault::HungUp);
      case Wake::TimedOut:
      case Wake::Woken: return err(StreamFault::WouldBlock);
    }
  }
  return {};
}

std::size_t SerialPort::unsent() const noexcept {
  int waiting = 0;
  return ::ioctl(line_.number(), TIOCOUTQ, &waiting) == 0 && waiting > 0 ? static_cast<std::size_t>(waiting) : 0;
}

void SerialPort::drop_unsent() noexcept { ::tcflush(line_.number(), TCOFLUSH); }

Result<void, StreamFault> SerialPort::set_data_terminal_ready(bool ready) {
  if (is_away()) return err(StreamFault::NotFound);
  const int line = TIOCM_DTR;
  if (::ioctl(line_.number(), ready ? TIOCMBIS : TIOCMBIC, &line) == 0) return {};
  if (errno == EIO || errno == ENXIO || errno == ENODEV) return err(StreamFault::HungUp);
  // A pty, or an adapter without the line, has no motor on it either.
  return errno == ENOTTY || errno == EINVAL ? Result<void, StreamFault>{} : err(StreamFault::WriteFailed);
}

Result<void, StreamFault> SerialPort::reopen() {
  // The old line's locks would refuse the new one if both are the same device.
  ::flock(line_.number(), LOCK_UN);
  ::ioctl(line_.number(), TIOCNXCL);
  auto fresh = open_line(settings_);
  if (!fresh) {
    if (!is_missing(fresh.error())) return err(stream_fault(fresh.error()));
    // The kernel keeps a line's number while it is open: a device that was ttyACM0 would return as ttyACM1.
    const Descriptor nothing{is_away() ? -1 : ::open("/dev/null", O_RDWR | O_CLOEXEC)};
    if (nothing.is_open() && ::dup3(nothing.number(), line_.number(), O_CLOEXEC) >= 0) away_ = true;
    return err(StreamFault::NotFound);
  }
  if (::dup3(fresh.value().number(), line_.number(), O_CLOEXEC) < 0) return err(StreamFault::NotUsable);
  away_ = false;
  return {};
}

}  // namespace nacelle::io
