// SPDX-License-Identifier: Apache-2.0
#include "camera/port/v4l2_device.hpp"

#include <fcntl.h>
#include <linux/dma-buf.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::camera {
namespace {

static_assert(sizeof(v4l2_buffer) == 88 || sizeof(void*) != 8, "the 64-bit ABI of linux/videodev2.h");
constexpr unsigned kMostBuffers = 32;  // VIDEO_MAX_FRAME

v4l2_buffer buffer_at(std::uint32_t index, std::uint32_t kind) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = kind;
  buffer.index = index;
  return buffer;
}

std::uint32_t kind_of(FrameMemory memory) {
  switch (memory) {
    case FrameMemory::Mapped: return V4L2_MEMORY_MMAP;
    case FrameMemory::Own: return V4L2_MEMORY_USERPTR;
    case FrameMemory::Imported: return V4L2_MEMORY_DMABUF;
  }
  return V4L2_MEMORY_MMAP;
}

}  // namespace

V4l2Device::V4l2Device(std::shared_ptr<V4l2Calls> calls, int descriptor, std::shared_ptr<Bell> bell)
    : calls_(std::move(calls)), bell_(std::move(bell)), descriptor_(descriptor), kind_(V4L2_MEMORY_MMAP) {
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

V4l2Device::StartFault V4l2Device::start(unsigned count, const CaptureWish& wish) {
  NACELLE_EXPECT(slots_.empty(), "a V4l2Device has one stream");
  kind_ = kind_of(wish.memory);
  v4l2_requestbuffers wanted{};
  wanted.count = wish.memory == FrameMemory::Imported ? static_cast<unsigned>(wish.imports.size()) : count;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = kind_;
  if (const int answer = call(VIDIOC_REQBUFS, wanted); answer != 0) return {"REQBUFS", answer};
  if (wanted.count == 0) return {"REQBUFS", -ENOMEM};
  if (wish.memory == FrameMemory::Imported && wanted.count > wish.imports.size()) return {"REQBUFS", -ENOBUFS};
  slots_.resize(std::min<std::size_t>(wanted.count, kMostBuffers));
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    slots_[index].index = index;
    if (const StartFault fault = provide(slots_[index], wish); fault.step != nullptr) return fault;
  }
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    if (const int answer = queue(index); answer != 0) return {"QBUF", answer};
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int answer = call(VIDIOC_STREAMON, type); answer != 0) return {"STREAMON", answer};
  return {};
}

// Gives a buffer its memory.
V4l2Device::StartFault V4l2Device::provide(Slot& slot, const CaptureWish& wish) {
  v4l2_buffer buffer = buffer_at(slot.index, kind_);
  if (const int answer = call(VIDIOC_QUERYBUF, buffer); answer != 0) return {"QUERYBUF", answer};
  void* memory = nullptr;
  switch (wish.memory) {
    case FrameMemory::Mapped: memory = calls_->map(descriptor(), buffer.length, buffer.m.offset); break;
    case FrameMemory::Own: memory = calls_->allocate(buffer.length); break;
    case FrameMemory::Imported:
      slot.dma_buf = wish.imports[slot.index];
      memory = calls_->map(slot.dma_buf, buffer.length, 0);
      break;
  }
  if (memory == nullptr) return {"mmap", wish.memory == FrameMemory::Imported ? -ENOBUFS : -ENOMEM};
  slot.memory = static_cast<std::uint8_t*>(memory);
  slot.length = buffer.length;
  if (wish.memory != FrameMemory::Mapped || !wish.export_frames) return {};
  v4l2_exportbuffer exported{};
  exported.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  exported.index = slot.index;
  exported.flags = O_RDONLY | O_CLOEXEC;
  if (const int answer = call(VIDIOC_EXPBUF, exported); answer != 0) return {"EXPBUF", answer};
  slot.dma_buf = exported.fd;
  return {};
}

void V4l2Device::shut() {
  const LockGuard lock{mutex_};
  if (descriptor_ < 0) return;
  // The answers do not matter: an unplugged device refuses all of it, and the close below ends everything.
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  static_cast<void>(locked_call(VIDIOC_STREAMOFF, &type));
  if (kind_ == V4L2_MEMORY_MMAP) {
    for (Slot& slot : slots_) {
      if (slot.dma_buf >= 0) calls_->close(slot.dma_buf);
      slot.dma_buf = -1;
      // One that there is no memory for stays mapped.
      if (slot.memory != nullptr && out_.load(std::memory_order_acquire) != 0) calls_->detach(slot.memory, slot.length);
    }
  }
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = kind_;
  if (!slots_.empty()) static_cast<void>(locked_call(VIDIOC_REQBUFS, &none));
  calls_->close(descriptor_);
  descriptor_ = -1;
}

DeviceWait V4l2Device::wait(Duration longest) const {
  return calls_->wait(queued() == 0 ? -1 : descriptor(), bell_->descriptor(), longest);
}

int V4l2Device::queue(std::uint32_t index) {
  v4l2_buffer buffer = buffer_at(index, kind_);
  buffer.length = static_cast<std::uint32_t>(slots_[index].length);
  if (kind_ == V4L2_MEMORY_USERPTR) buffer.m.userptr = reinterpret_cast<unsigned long>(slots_[index].memory);
  if (kind_ == V4L2_MEMORY_DMABUF) buffer.m.fd = slots_[index].dma_buf;
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

// Another device's memory may not be coherent with this processor's caches.
void V4l2Device::reading(int dma_buf, std::uint64_t begin_or_end) const {
  dma_buf_sync sync{DMA_BUF_SYNC_READ | begin_or_end};
  static_cast<void>(calls_->control(dma_buf, DMA_BUF_IOCTL_SYNC, &sync));
}

ReleaseHook V4l2Device::lend(std::uint32_t index) {
  Slot& slot = slots_[index];
  NACELLE_EXPECT(slot.keep == nullptr, "a buffer that is out cannot be filled again");
  slot.keep = shared_from_this();
  out_.fetch_add(1, std::memory_order_relaxed);
  if (kind_ == V4L2_MEMORY_DMABUF) reading(slot.dma_buf, DMA_BUF_SYNC_START);
  return {&V4l2Device::give_back, &slot};
}

void V4l2Device::give_back(void* context) noexcept {
  Slot& slot = *static_cast<Slot*>(context);
  // Before the buffer is queued: from then on the capturing thread may lend the slot again.
  const auto device = std::move(slot.keep);
  device->out_.fetch_sub(1, std::memory_order_release);
  if (device->kind_ == V4L2_MEMORY_DMABUF) device->reading(slot.dma_buf, DMA_BUF_SYNC_END);
  const int answer = device->queue(slot.index);
  if (answer != 0) {
    device->hook_failure_.store(answer, std::memory_order_relaxed);
    device->bell_->ring();
  }
}

}  // namespace nacelle::camera
