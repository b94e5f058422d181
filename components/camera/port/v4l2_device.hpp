// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "camera/port/capture_port.hpp"
#include "camera/port/v4l2_calls.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::camera {

/// An open V4L2 device and the buffers of its one stream; alive until the last frame is given back.
///
/// A frame's hook may come from any thread, and after the stream has ended or the cable was pulled. So the hook's
/// context is a slot of this object, the slot keeps the object alive while its frame is out, and the lock makes sure
/// that no buffer is queued on a descriptor that was closed meanwhile (its number may belong to another file by then).
/// Memory stays readable after the close, until the last frame is given back. A frame that is out then becomes memory of this process
/// (V4l2Calls::detach): as long as a buffer is mapped, the device's file stays open, no other stream can start, and the device
/// returns under another number.
/// The hook's code is this library's: it must stay loaded while frames are out.
/// Threads: call() and hooks from any; the rest from the capturing thread.
class V4l2Device final : public std::enable_shared_from_this<V4l2Device> {
 public:
  /// Takes ownership of the descriptor. Rings the bell when a buffer returns to a device that had none.
  V4l2Device(std::shared_ptr<V4l2Calls> calls, int descriptor, std::shared_ptr<Bell> bell);
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;
  ~V4l2Device();

  /// An ioctl, repeated when a signal interrupts it: 0 or -errno; -ENODEV once the device was shut.
  template <typename T>
  [[nodiscard]] int call(unsigned long request, T& argument) const {
    return call_raw(request, &argument);
  }

  /// The step of start() that failed, and why.
  struct StartFault {
    const char* step = nullptr;  ///< Null when all went well.
    int os_code = 0;
  };
  /// Requests `count` buffers of the kind that the wish says, queues those that it gets, and starts the stream. Once per object.
  [[nodiscard]] StartFault start(unsigned count, const CaptureWish& wish);
  /// Ends the stream and closes the descriptor. Frames that are out stay readable.
  void shut();

  /// Waits for the device; for the bell alone while every buffer is out, since a device without buffers answers
  /// "error".
  [[nodiscard]] DeviceWait wait(Duration longest) const;
  /// The kernel's number of the kind of memory, for a v4l2_buffer.
  [[nodiscard]] std::uint32_t kind() const { return kind_; }
  /// Dequeues a filled buffer: 0 or -errno. `buffer` is a v4l2_buffer; its index is valid after 0.
  template <typename T>
  [[nodiscard]] int dequeue(unsigned long request, T& buffer) {
    return dequeue_raw(request, &buffer, buffer.index);
  }
  /// Gives a dequeued buffer straight back to the driver: 0 or -errno.
  [[nodiscard]] int queue(std::uint32_t index);
  /// Keeps a dequeued buffer out of the stream until the hook is called.
  [[nodiscard]] ReleaseHook lend(std::uint32_t index);
  [[nodiscard]] ByteSpan memory(std::uint32_t index) const { return {slots_[index].memory, slots_[index].length}; }
  /// The buffer's dma-buf; -1 without one.
  [[nodiscard]] int dma_buf(std::uint32_t index) const { return slots_[index].dma_buf; }
  [[nodiscard]] std::size_t buffer_count() const { return slots_.size(); }
  /// Buffers that the driver can fill now.
  [[nodiscard]] unsigned queued() const { return queued_.load(std::memory_order_relaxed); }
  /// -errno of a hook that could not give its buffer back; 0 if all could.
  [[nodiscard]] int hook_failure() const { return hook_failure_.load(std::memory_order_relaxed); }

 private:
  struct Slot {
    std::uint8_t* memory = nullptr;
    std::size_t length = 0;
    std::uint32_t index = 0;
    int dma_buf = -1;                  ///< Ours if exported, the caller's if imported.
    std::shared_ptr<V4l2Device> keep;  ///< While the frame is out.
  };
  static void give_back(void* context) noexcept;
  int call_raw(unsigned long request, void* argument) const;
  int dequeue_raw(unsigned long request, void* buffer, const std::uint32_t& index);
  int locked_call(unsigned long request, void* argument) const NACELLE_REQUIRES(mutex_);
  void reading(int dma_buf, std::uint64_t begin_or_end) const;
  StartFault provide(Slot& slot, const CaptureWish& wish);
  [[nodiscard]] int descriptor() const;

  const std::shared_ptr<V4l2Calls> calls_;
  const std::shared_ptr<Bell> bell_;
  mutable Mutex mutex_;  ///< Guards descriptor_ against closing while another thread uses it.
  int descriptor_ NACELLE_GUARDED_BY(mutex_);
  std::vector<Slot> slots_;
  std::uint32_t kind_;
  std::atomic<unsigned> out_{0};  ///< Frames that are out.
  std::atomic<unsigned> queued_{0};
  std::atomic<int> hook_failure_{0};
};

}  // namespace nacelle::camera
