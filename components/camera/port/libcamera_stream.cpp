// SPDX-License-Identifier: Apache-2.0
#include "camera/port/libcamera_stream.hpp"

#include <libcamera/control_ids.h>
#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

#include "camera/port/libcamera_controls.hpp"
#include "nacelle/base/expect.hpp"

namespace nacelle::camera {
namespace {

namespace controls = ::libcamera::controls;

std::uint32_t bytes_of(const ::libcamera::FrameMetadata& frame) {
  std::uint32_t bytes = 0;
  for (const auto& plane : frame.planes()) bytes += plane.bytesused;
  return bytes;
}

}  // namespace

LibcameraStream::LibcameraStream(FoundCamera found, std::shared_ptr<Bell> bell)
    : bell_(std::move(bell)), found_(std::move(found)) {
  const LockGuard lock{mutex_};
  found_.camera->requestCompleted.connect(this, &LibcameraStream::on_completed);
  found_.camera->disconnected.connect(this, &LibcameraStream::on_disconnected);
}

LibcameraStream::~LibcameraStream() {
  shut();
  for (const Slot& slot : slots_) {
    if (slot.map != nullptr) ::munmap(slot.map, slot.map_length);
  }
}

// The planes of a frame as one piece of memory.
LibcameraStream::StartFault LibcameraStream::map_buffer(const ::libcamera::FrameBuffer& buffer, std::size_t frame_bytes,
                                                        Slot& slot) {
  const auto& planes = buffer.planes();
  if (planes.empty()) return {"buffer without planes", -EINVAL};
  const std::size_t begin = planes[0].offset;
  std::size_t end = begin;
  for (const auto& plane : planes) {
    if (plane.fd.get() != planes[0].fd.get() || plane.offset != end) return {"planes that lie apart", -EINVAL};
    end += plane.length;
  }
  if (end - begin < frame_bytes) return {"buffer smaller than a frame", -EINVAL};
  void* const map = ::mmap(nullptr, end, PROT_READ | PROT_WRITE, MAP_SHARED, planes[0].fd.get(), 0);
  if (map == MAP_FAILED) return {"mmap", -errno};
  slot.map = map;
  slot.map_length = end;
  slot.bytes = {static_cast<std::uint8_t*>(map) + begin, end - begin};
  slot.dma_buf = planes[0].fd.get();
  return {};
}

LibcameraStream::StartFault LibcameraStream::start(::libcamera::CameraConfiguration& configuration,
                                                   std::size_t frame_bytes) {
  NACELLE_EXPECT(slots_.empty(), "a LibcameraStream starts once");
  const LockGuard lock{mutex_};
  auto& camera = *found_.camera;
  if (const int answer = camera.configure(&configuration); answer != 0) return {"configure", answer};
  auto* const stream = configuration.at(0).stream();
  buffers_ = std::make_unique<::libcamera::FrameBufferAllocator>(found_.camera);
  if (const int answer = buffers_->allocate(stream); answer < 0) return {"allocate buffers", answer};
  const auto& buffers = buffers_->buffers(stream);
  slots_.resize(buffers.size());
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    slots_[index].index = index;
    if (const auto fault = map_buffer(*buffers[index], frame_bytes, slots_[index]); fault.step != nullptr) return fault;
    auto request = camera.createRequest(index);
    if (request == nullptr) return {"create request", -ENOMEM};
    if (const int answer = request->addBuffer(stream, buffers[index].get()); answer != 0) return {"add buffer", answer};
    requests_.push_back(std::move(request));
  }
  ::libcamera::ControlList first{camera.controls()};
  for (const auto& [id, value] : wished_) first.set(id, value);
  wished_.clear();
  if (const int answer = camera.start(&first); answer != 0) return {"start", answer};
  running_ = true;
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    if (const int answer = queue_locked(index); answer != 0) return {"queue request", answer};
  }
  return {};
}

void LibcameraStream::shut() {
  const LockGuard lock{mutex_};
  if (found_.camera == nullptr) return;
  // Requests that are with the camera come back as cancelled meanwhile; on_completed() takes no lock of ours but the queue's.
  if (running_) found_.camera->stop();
  running_ = false;
  found_.camera->requestCompleted.disconnect(this);
  found_.camera->disconnected.disconnect(this);
  requests_.clear();
  for (Slot& slot : slots_) slot.dma_buf = -1;
  buffers_.reset();
  found_.camera->release();
  found_.camera.reset();  // before the manager, which must outlive it
  found_.manager.reset();
}

int LibcameraStream::set(unsigned id, const ::libcamera::ControlValue& value) {
  const LockGuard lock{mutex_};
  return set_locked(id, value);
}

int LibcameraStream::set_number(unsigned id, std::int64_t value) {
  const LockGuard lock{mutex_};
  if (found_.camera == nullptr) return -ENODEV;
  const auto converted = control_value(found_.camera->controls(), id, value);
  return converted ? set_locked(id, *converted) : -EINVAL;
}

int LibcameraStream::set_locked(unsigned id, const ::libcamera::ControlValue& value) {
  if (found_.camera == nullptr) return -ENODEV;
  const auto earlier =
      std::find_if(wished_.begin(), wished_.end(), [id](const auto& wish) { return wish.first == id; });
  if (earlier == wished_.end()) {
    wished_.emplace_back(id, value);
  } else {
    earlier->second = value;
  }
  return 0;
}

void LibcameraStream::on_completed(::libcamera::Request* request) {
  if (request->status() == ::libcamera::Request::RequestCancelled) return;
  const auto& frame = request->buffers().begin()->second->metadata();
  Completed done;
  done.index = static_cast<std::uint32_t>(request->cookie());
  done.bytes = bytes_of(frame);
  if (done.bytes != 0) {  // otherwise libcamera has not even initialised them
    done.sequence = frame.sequence;
    done.damaged = frame.status != ::libcamera::FrameMetadata::FrameSuccess;
  }
  // When the exposure of the first row began; some pipelines have the time of the buffer only.
  done.stamp_ns =
      request->metadata().get(controls::SensorTimestamp).value_or(static_cast<std::int64_t>(frame.timestamp));
  completed_.lock()->push_back(done);
  queued_.fetch_sub(1, std::memory_order_relaxed);
  bell_->ring();
}

void LibcameraStream::on_disconnected() {
  gone_.store(true, std::memory_order_release);
  bell_->ring();
}

std::optional<LibcameraStream::Completed> LibcameraStream::completed() {
  auto all = completed_.lock();
  if (all->empty()) return std::nullopt;
  const Completed oldest = all->front();
  all->pop_front();
  return oldest;
}

int LibcameraStream::queue_locked(std::uint32_t index) {
  if (!running_) return -ENODEV;
  auto& request = *requests_[index];
  if (request.status() != ::libcamera::Request::RequestPending) request.reuse(::libcamera::Request::ReuseBuffers);
  for (const auto& [id, value] : wished_) request.controls().set(id, value);
  wished_.clear();
  queued_.fetch_add(1, std::memory_order_relaxed);
  const int answer = found_.camera->queueRequest(&request);
  if (answer != 0) queued_.fetch_sub(1, std::memory_order_relaxed);
  return answer;
}

int LibcameraStream::queue(std::uint32_t index) {
  const LockGuard lock{mutex_};
  return queue_locked(index);
}

// The camera's memory may not be coherent with this processor's caches.
void LibcameraStream::reading(int dma_buf, std::uint64_t begin_or_end) const {
  dma_buf_sync sync{DMA_BUF_SYNC_READ | begin_or_end};
  while (::ioctl(dma_buf, DMA_BUF_IOCTL_SYNC, &sync) != 0 && (errno == EINTR || errno == EAGAIN)) {}
}

ReleaseHook LibcameraStream::lend(std::uint32_t index) {
  Slot& slot = slots_[index];
  NACELLE_EXPECT(slot.keep == nullptr, "a buffer that is out cannot be filled again");
  slot.keep = shared_from_this();
  reading(slot.dma_buf, DMA_BUF_SYNC_START);
  return {&LibcameraStream::give_back, &slot};
}

void LibcameraStream::give_back(void* context) noexcept {
  Slot& slot = *static_cast<Slot*>(context);
  // Before the request is queued: from then on the capturing thread may lend the slot again.
  const auto stream = std::move(slot.keep);
  int answer = 0;
  {
    const LockGuard lock{stream->mutex_};
    if (!stream->running_) return;
    stream->reading(slot.dma_buf, DMA_BUF_SYNC_END);
    answer = stream->queue_locked(slot.index);
  }
  if (answer != 0) stream->hook_failure_.store(answer, std::memory_order_relaxed);
  stream->bell_->ring();  // it may have waited for a buffer
}

}  // namespace nacelle::camera
