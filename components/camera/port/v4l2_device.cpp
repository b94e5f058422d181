// SPDX-License-Identifier: Apache-2.0
#include "camera/port/v4l2_device.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::camera {
namespace {

static_assert(sizeof(v4l2_buffer) == 88 || sizeof(void*) != 8, "the 64-bit ABI of linux/videodev2.h");
constexpr unsigned kMostBuffers = 32;  // VIDEO_MAX_FRAME

v4l2_buffer buffer_at(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

V4l2Device::V4l2Device(std::shared_ptr<V4l2Calls> calls, int descriptor, std::shared_ptr<Bell> bell)
    : calls_(std::move(calls)), bell_(std::move(bell)), descriptor_(descriptor) {
  NACELLE_EXPECT(descriptor >= 0, "an open descriptor");
}

V4l2Device::~V4l2Device() {
  shut();
  for (const Slot& slot : slots_) {
    if (slot.memory != nullptr) calls_->unmap(slot.memory, slot.length);
  }
}

int V4l2Device::call_raw(unsigned long request, void* argument) const {
  const LockGuard lock{mutex_};
  return locked_call(request, argument);
}

int V4l2Device::locked_call(unsigned long request, void* argument) const {
  if (descriptor_ < 0) return -ENODEV;
  int answer = 0;
  do { answer = calls_->control(descriptor_, request, argument); } while (answer == -EINTR);
  return answer;
}

int V4l2Device::descriptor() const {
  const LockGuard lock{mutex_};
  return descriptor_;
}

V4l2Device::StartFault V4l2Device::start(unsigned count) {
  NACELLE_EXPECT(slots_.empty(), "a V4l2Device has one stream");
  v4l2_requestbuffers wanted{};
  wanted.count = count;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = V4L2_MEMORY_MMAP;
  if (const int answer = call(VIDIOC_REQBUFS, wanted); answer != 0) return {"REQBUFS", answer};
  if (wanted.count == 0) return {"REQBUFS", -ENOMEM};
  slots_.resize(std::min<std::size_t>(wanted.count, kMostBuffers));
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    v4l2_buffer buffer = buffer_at(index);
    if (const int answer = call(VIDIOC_QUERYBUF, buffer); answer != 0) return {"QUERYBUF", answer};
    void* const memory = calls_->map(descriptor(), buffer.length, buffer.m.offset);
    if (memory == nullptr) return {"mmap", -ENOMEM};
    slots_[index].memory = static_cast<std::uint8_t*>(memory);
    slots_[index].length = buffer.length;
    slots_[index].index = index;
  }
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    if (const int answer = queue(index); answer != 0) return {"QBUF", answer};
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int answer = call(VIDIOC_STREAMON, type); answer != 0) return {"STREAMON", answer};
  return {};
}

void V4l2Device::shut() {
  const LockGuard lock{mutex_};
  if (descriptor_ < 0) return;
  // The answers do not matter: an unplugged device refuses both, and the close below ends everything.
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  static_cast<void>(locked_call(VIDIOC_STREAMOFF, &type));
  calls_->close(descriptor_);
  descriptor_ = -1;
}

DeviceWait V4l2Device::wait(Duration longest) const {
  return calls_->wait(queued() == 0 ? -1 : descriptor(), bell_->descriptor(), longest);
}

int V4l2Device::queue(std::uint32_t index) {
  v4l2_buffer buffer = buffer_at(index);
  bool was_starving = false;
  {
    // Under one lock with the count: wait() must not take the device for fed before it is, nor the other way round.
    const LockGuard lock{mutex_};
    const int answer = locked_call(VIDIOC_QBUF, &buffer);
    if (answer != 0) return answer;
    was_starving = queued_.fetch_add(1, std::memory_order_relaxed) == 0;
  }
  if (was_starving) bell_->ring();
  return 0;
}

int V4l2Device::dequeue_raw(unsigned long request, void* buffer, const std::uint32_t& index) {
  const LockGuard lock{mutex_};
  const int answer = locked_call(request, buffer);
  if (answer != 0) return answer;
  // A driver that names a buffer which it never gave.
  if (index >= slots_.size()) return -EINVAL;
  queued_.fetch_sub(1, std::memory_order_relaxed);
  return 0;
}

ReleaseHook V4l2Device::lend(std::uint32_t index) {
  Slot& slot = slots_[index];
  NACELLE_EXPECT(slot.keep == nullptr, "a buffer that is out cannot be filled again");
  slot.keep = shared_from_this();
  return {&V4l2Device::give_back, &slot};
}

void V4l2Device::give_back(void* context) noexcept {
  Slot& slot = *static_cast<Slot*>(context);
  // Before the buffer is queued: from then on the capturing thread may lend the slot again.
  const auto device = std::move(slot.keep);
  const int answer = device->queue(slot.index);
  if (answer != 0) {
    device->hook_failure_.store(answer, std::memory_order_relaxed);
    device->bell_->ring();
  }
}

}  // namespace nacelle::camera
