// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/can_port.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <ctime>

#include "nacelle/base/expect.hpp"

namespace nacelle::io {
namespace {

static_assert(sizeof(can_frame) == kCanFrameBytes && offsetof(can_frame, data) == 8);
static_assert(CAN_EFF_FLAG == kCanExtended && CAN_RTR_FLAG == kCanRemote && CAN_ERR_FLAG == kCanError);

// The least that the kernel allows: six frames. What waits on a bus that takes nothing is sent when it returns, so little may wait.
constexpr int kSendBuffer = 2304;

enum class CanStep : std::uint8_t { Name, Find, Kind, Up, OnTheBus, Socket, Bind };
struct CanOpenFault {
  CanStep step;
  int os_code = 0;
};

std::optional<ifreq> request_for(const std::string& interface) {
  ifreq request{};
  if (interface.empty() || interface.size() >= sizeof request.ifr_name) return std::nullopt;
  std::copy(interface.begin(), interface.end(), request.ifr_name);
  return request;
}

std::optional<CanOpenFault> fault_of_interface(const std::string& interface) {
  auto request = request_for(interface);
  if (!request) return CanOpenFault{CanStep::Name};
  const Descriptor any{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (::ioctl(any.number(), SIOCGIFHWADDR, &*request) != 0) return CanOpenFault{CanStep::Find, errno};
  if (request->ifr_hwaddr.sa_family != ARPHRD_CAN) return CanOpenFault{CanStep::Kind};
  if (::ioctl(any.number(), SIOCGIFFLAGS, &*request) != 0) return CanOpenFault{CanStep::Find, errno};
  if ((request->ifr_flags & IFF_UP) == 0) return CanOpenFault{CanStep::Up};
  // The kernel takes the carrier away from a controller that is off the bus (can_bus_off(), drivers/net/can/dev).
  if ((request->ifr_flags & IFF_RUNNING) == 0) return CanOpenFault{CanStep::OnTheBus};
  return std::nullopt;
}

Descriptor new_socket() { return Descriptor{::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW)}; }

Result<Descriptor, CanOpenFault> open_socket(const CanSettings& settings) {
  if (const auto fault = fault_of_interface(settings.interface)) return err(*fault);
  Descriptor socket = new_socket();
  if (!socket.is_open()) return err(CanOpenFault{CanStep::Socket, errno});
  static_assert(sizeof(CanFilter) == sizeof(can_filter));
  const can_err_mask_t errors = CAN_ERR_MASK;
  const auto filter_bytes = static_cast<socklen_t>(settings.filters.size() * sizeof(CanFilter));
  if (::setsockopt(socket.number(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
      (filter_bytes != 0 &&
       ::setsockopt(socket.number(), SOL_CAN_RAW, CAN_RAW_FILTER, settings.filters.data(), filter_bytes) != 0)) {
    return err(CanOpenFault{CanStep::Socket, errno});
  }
  ::setsockopt(socket.number(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(settings.interface.c_str()));
  // Index 0 would be every interface.
  if (address.can_ifindex == 0) return err(CanOpenFault{CanStep::Find, ENODEV});
  if (::bind(socket.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return err(CanOpenFault{errno == ENODEV ? CanStep::Find : CanStep::Bind, errno});
  return socket;
}

bool is_denied(CanOpenFault fault) { return fault.os_code == EPERM || fault.os_code == EACCES; }

StreamFault stream_fault(CanOpenFault fault) {
  switch (fault.step) {
    case CanStep::Find: return StreamFault::NotFound;
    case CanStep::Up: return StreamFault::LineDown;
    case CanStep::OnTheBus: return StreamFault::BusOff;
    default: return is_denied(fault) ? StreamFault::NotPermitted : StreamFault::NotUsable;
  }
}

/// What time, a cable or a person may mend, while this program waits.
bool can_be_awaited(CanOpenFault fault) {
  return fault.step == CanStep::Find || fault.step == CanStep::Up || fault.step == CanStep::OnTheBus;
}

std::string others_than(const std::string& interface) {
  auto all = can_interfaces();
  std::erase(all, interface);
  return all.empty() ? "`ip -details link` lists the interfaces"
                     : fmt::format("CAN interfaces are {}", fmt::join(all, ", "));
}

Problem explain(const CanSettings& settings, CanOpenFault fault, Duration patience) {
  const std::string& name = settings.interface;
  std::string waited;
  if (can_be_awaited(fault) && patience > Duration::zero())
    waited = fmt::format(" (waited {:.1f} s for it)", to_seconds(patience));
  switch (fault.step) {
    case CanStep::Name: return {name, fmt::format("'{}' is no name of an interface", name), others_than(name)};
    case CanStep::Find:
      return {name, "no such CAN interface" + waited, "is the adapter plugged in? " + others_than(name)};
    case CanStep::Kind: return {name, "not a CAN interface", others_than(name)};
    case CanStep::Up:
      return {name, "the CAN interface is down" + waited,
              fmt::format("`sudo ip link set {} up type can bitrate 500000`, with the boards' bit rate", name)};
    case CanStep::OnTheBus:
      return {name, "the CAN controller is off the bus" + waited,
              fmt::format("check wiring, termination and bit rate, then `sudo ip link set {} type can restart`", name)};
    case CanStep::Socket:
    case CanStep::Bind: break;
  }
  if (is_denied(fault)) {
    return {name, fmt::format("no permission to open a CAN socket ({})", std::strerror(fault.os_code)),
            "does a container or a service's RestrictAddressFamilies keep AF_CAN away?"};
  }
  if (fault.os_code == EAFNOSUPPORT || fault.os_code == EPROTONOSUPPORT)
    return {name, "this kernel has no CAN sockets", "`sudo modprobe can_raw`"};
  return {name, fmt::format("cannot be opened ({})", std::strerror(fault.os_code)), others_than(name)};
}

StreamFault fault_of(int os_code, StreamFault otherwise) {
  switch (os_code) {
    case ENETDOWN: return StreamFault::LineDown;
    case ENODEV:
    case ENXIO:
    case EPIPE:
    case ECONNRESET: return StreamFault::HungUp;
    default: return otherwise;
  }
}

}  // namespace

std::vector<std::string> can_interfaces() {
  std::vector<std::string> names;
  const Descriptor any{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  struct if_nameindex* const all = ::if_nameindex();
  for (const struct if_nameindex* at = all; at != nullptr && at->if_index != 0; ++at) {
    auto request = request_for(at->if_name);
    if (request && ::ioctl(any.number(), SIOCGIFHWADDR, &*request) == 0 && request->ifr_hwaddr.sa_family == ARPHRD_CAN)
      names.emplace_back(at->if_name);
  }
  if (all != nullptr) ::if_freenameindex(all);
  std::sort(names.begin(), names.end());
  return names;
}

CanPort::CanPort(CanSettings settings, const Clock& clock, Descriptor socket)
    : settings_(std::move(settings)), clock_(clock), socket_(std::move(socket)) {}

Result<std::unique_ptr<CanPort>, Problem> CanPort::open(const CanSettings& settings, const Clock& clock,
                                                        Duration patience) {
  const MonotonicTime deadline = clock.now() + patience;
  for (;;) {
    auto socket = open_socket(settings);
    if (socket) return adopt(std::move(socket).value(), settings, clock);
    if (!can_be_awaited(socket.error()) || clock.now() >= deadline)
      return err(explain(settings, socket.error(), patience));
    timespec pause{0, 20'000'000};
    ::nanosleep(&pause, nullptr);
  }
}

Result<std::unique_ptr<CanPort>, Problem> CanPort::open_or_await(const CanSettings& settings, const Clock& clock) {
  auto socket = open_socket(settings);
  if (socket) return adopt(std::move(socket).value(), settings, clock);
  CanOpenFault fault = socket.error();
  // Bound to no interface, it refuses frames: a stop frame that cannot be sent does not count as written.
  Descriptor reserved = can_be_awaited(fault) ? new_socket() : Descriptor{};
  if (!reserved.is_open()) {
    if (can_be_awaited(fault)) fault = {CanStep::Socket, errno};
    return err(explain(settings, fault, {}));
  }
  auto port = adopt(std::move(reserved), settings, clock);
  port->away_as_ = stream_fault(fault);
  port->away_ = true;
  return port;
}

std::unique_ptr<CanPort> CanPort::adopt(Descriptor socket, const CanSettings& settings, const Clock& clock) {
  return std::unique_ptr<CanPort>{new CanPort{settings, clock, std::move(socket)}};
}

std::size_t CanPort::read_frames() {
  std::size_t used = 0;
  while (used + kCanFrameBytes <= buffer_.size() && !pending_) {
    std::uint8_t* const frame = buffer_.data() + used;
    const ssize_t count = ::recv(socket_.number(), frame, kCanFrameBytes, MSG_DONTWAIT | MSG_TRUNC);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) break;
    if (count <= 0) {
      pending_ = count == 0 ? StreamFault::HungUp : fault_of(errno, StreamFault::ReadFailed);
    } else if (count != static_cast<ssize_t>(kCanFrameBytes)) {
      ++stats_.odd_reads;
    } else {
      std::uint32_t id = 0;
      std::memcpy(&id, frame, sizeof id);
      if ((id & kCanError) == 0) {
        ++stats_.frames_in;
        used += kCanFrameBytes;
        continue;
      }
      ++stats_.error_frames;
      if ((id & CAN_ERR_BUSOFF) != 0) {
        ++stats_.bus_offs;
        pending_ = StreamFault::BusOff;
      }
    }
  }
  return used;
}

Result<ByteView, StreamFault> CanPort::read_until(MonotonicTime deadline) {
  if (is_away()) return err(away_as_);
  for (;;) {
    if (pending_) {
      const StreamFault fault = *pending_;
      pending_.reset();
      return err(fault);
    }
    switch (wait_readable(socket_.number(), bell_, clock_, deadline)) {
      case Wake::TimedOut:
      case Wake::Woken: return ByteView{};
      case Wake::HungUp:  // also how an interface that is set down wakes: reading tells it
      case Wake::Ready: break;
    }
    if (const std::size_t used = read_frames(); used != 0) return ByteView{buffer_.data(), used};
  }
}

Result<void, StreamFault> CanPort::write_frame(ByteView frame, MonotonicTime deadline) {
  for (;;) {
    const ssize_t count = ::send(socket_.number(), frame.data(), frame.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count == static_cast<ssize_t>(frame.size())) {
      ++stats_.frames_out;
      return {};
    }
    if (errno == EINTR) continue;
    if (errno == ENOBUFS) {
      // The interface's own queue is full, which no poll() waits for.
      if (clock_.now() >= deadline) return err(StreamFault::WouldBlock);
      timespec pause{0, 200'000};
      ::nanosleep(&pause, nullptr);
      continue;
    }
    if (errno != EAGAIN) return err(fault_of(errno, StreamFault::WriteFailed));
    switch (wait_writable(socket_.number(), clock_, deadline)) {
      case Wake::Ready:
      case Wake::HungUp: break;  // the next attempt tells it
      case Wake::TimedOut:
      case Wake::Woken: return err(StreamFault::WouldBlock);
    }
    if (clock_.now() >= deadline) return err(StreamFault::WouldBlock);
  }
}

Result<void, StreamFault> CanPort::write(ByteView frames) {
  NACELLE_EXPECT(frames.size() % kCanFrameBytes == 0, "a CAN socket takes whole frames");
  if (is_away()) return err(away_as_);
  const MonotonicTime deadline = clock_.now() + settings_.write_timeout;
  for (; !frames.empty(); frames = frames.subspan(kCanFrameBytes)) {
    if (const auto sent = write_frame(frames.first(kCanFrameBytes), deadline); !sent) return sent;
  }
  return {};
}

std::size_t CanPort::unsent() const noexcept {
  std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t length = sizeof memory;
  if (::getsockopt(socket_.number(), SOL_SOCKET, SO_MEMINFO, memory.data(), &length) != 0) return 0;
  return memory[SK_MEMINFO_WMEM_ALLOC];
}

Result<void, StreamFault> CanPort::reopen() {
  auto fresh = open_socket(settings_);
  if (!fresh) {
    const StreamFault fault = stream_fault(fresh.error());
    if (can_be_awaited(fresh.error())) {
      away_as_ = fault;
      away_ = true;
    }
    return err(fault);
  }
  if (::dup3(fresh.value().number(), socket_.number(), O_CLOEXEC) < 0) return err(StreamFault::NotUsable);
  pending_.reset();
  away_ = false;
  return {};
}

}  // namespace nacelle::io
