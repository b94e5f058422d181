// SPDX-License-Identifier: Apache-2.0
#include "camera/port/v4l2_calls.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace nacelle::camera {
namespace {

class KernelCalls final : public V4l2Calls {
 public:
  int open(const char* device) override {
    const int descriptor = ::open(device, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return descriptor < 0 ? -errno : descriptor;
  }
  void close(int descriptor) override { ::close(descriptor); }
  int control(int descriptor, unsigned long request, void* argument) override {
    return ::ioctl(descriptor, request, argument) < 0 ? -errno : 0;
  }
  void* map(int descriptor, std::size_t length, std::uint32_t offset) override {
    void* const memory =
        ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void* allocate(std::size_t length) override {
    void* const memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, std::size_t length) override { ::munmap(memory, length); }
  bool detach(void* memory, std::size_t length) override {
    void* const copy = allocate(length);
    if (copy == nullptr) return false;
    std::memcpy(copy, memory, length);
    // The kernel exchanges the pages while no thread can take a page fault in between.
    if (::mremap(copy, length, length, MREMAP_MAYMOVE | MREMAP_FIXED, memory) != MAP_FAILED) return true;
    ::munmap(copy, length);
    return false;
  }
  DeviceWait wait(int descriptor, int bell, Duration longest) override {
    std::array<pollfd, 2> watched{pollfd{descriptor, POLLIN, 0}, pollfd{bell, POLLIN, 0}};
    const Duration cut = std::clamp<Duration>(longest, Duration::zero(), std::chrono::hours{1});
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(cut);
    timespec left{};
    left.tv_sec = static_cast<time_t>(seconds.count());
    left.tv_nsec = static_cast<long>((cut - seconds).count());
    // Interrupted is the same as nothing came: the caller looks at its clock.
    if (::ppoll(watched.data(), watched.size(), &left, nullptr) <= 0) return {};
    return {(watched[0].revents & POLLIN) != 0, (watched[0].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0,
            (watched[1].revents & POLLIN) != 0};
  }
};

}  // namespace

std::shared_ptr<V4l2Calls> kernel_calls() { return std::make_shared<KernelCalls>(); }

}  // namespace nacelle::camera
