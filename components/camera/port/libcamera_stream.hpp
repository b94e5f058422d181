// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libcamera/camera.h>
#include <libcamera/framebuffer_allocator.h>
#include <libcamera/request.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "camera/port/libcamera_search.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::camera {

/// A started camera and its buffers; alive until the last frame is given back.
///
/// Each request has one buffer, a dma-buf that is mapped here once. A frame's hook queues its request again, from any thread; after
/// shut() the memory stays mapped until the hook was called. The hook's code is this library's: it must stay loaded while frames are
/// out.
/// Threads: lend() and completed() from the capturing thread; set(), set_number(), shut() and hooks from any. libcamera's own thread reports
/// requests.
class LibcameraStream final : public std::enable_shared_from_this<LibcameraStream> {
 public:
  /// Takes over an acquired camera, and releases it. Rings the bell when a request is complete, and when the camera is gone.
  LibcameraStream(FoundCamera found, std::shared_ptr<Bell> bell);
  LibcameraStream(const LibcameraStream&) = delete;
  LibcameraStream& operator=(const LibcameraStream&) = delete;
  ~LibcameraStream();

  struct StartFault {
    const char* step = nullptr;  ///< Null when all went well.
    int os_code = 0;
  };
  /// Configures, allocates and maps the buffers, and queues a request for each. Once per object. `frame_bytes` is the most that a
  /// frame may need of a buffer whose planes lie one behind the other.
  [[nodiscard]] StartFault start(::libcamera::CameraConfiguration& configuration, std::size_t frame_bytes);
  /// Ends the stream and lets the camera go. Frames that are out stay readable.
  void shut();
  /// Adds a control to the next request.
  [[nodiscard]] int set(unsigned id, const ::libcamera::ControlValue& value);
  /// The same of one that list_controls() listed: 0 or -errno.
  [[nodiscard]] int set_number(unsigned id, std::int64_t value);

  /// What a request brought. Pipelines without a device leave bytes at 0, and then sequence and damage unknown: 0 and false.
  struct Completed {
    std::uint32_t index = 0;
    std::uint32_t bytes = 0;  ///< Of all planes.
    std::uint32_t sequence = 0;
    bool damaged = false;
    std::int64_t stamp_ns = 0;
  };
  /// The oldest request that is complete.
  [[nodiscard]] std::optional<Completed> completed();
  /// Queues the request of a frame that is not lent: 0 or -errno.
  [[nodiscard]] int queue(std::uint32_t index);
  /// Keeps a completed frame's memory until the hook is called.
  [[nodiscard]] ReleaseHook lend(std::uint32_t index);
  [[nodiscard]] ByteSpan memory(std::uint32_t index) const { return slots_[index].bytes; }
  [[nodiscard]] int dma_buf(std::uint32_t index) const { return slots_[index].dma_buf; }
  /// Requests that are with the camera.
  [[nodiscard]] unsigned queued() const { return queued_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool gone() const { return gone_.load(std::memory_order_acquire); }
  /// -errno of a hook that could not queue its request; 0 if all could.
  [[nodiscard]] int hook_failure() const { return hook_failure_.load(std::memory_order_relaxed); }

 private:
  struct Slot {
    void* map = nullptr;
    std::size_t map_length = 0;
    ByteSpan bytes;
    int dma_buf = -1;  ///< Open until shut().
    std::uint32_t index = 0;
    std::shared_ptr<LibcameraStream> keep;  ///< While the frame is out.
  };
  static void give_back(void* context) noexcept;
  [[nodiscard]] static StartFault map_buffer(const ::libcamera::FrameBuffer& buffer, std::size_t frame_bytes,
                                             Slot& slot);
  void on_completed(::libcamera::Request* request);
  void on_disconnected();
  void reading(int dma_buf, std::uint64_t begin_or_end) const;
  int set_locked(unsigned id, const ::libcamera::ControlValue& value) NACELLE_REQUIRES(mutex_);
  int queue_locked(std::uint32_t index) NACELLE_REQUIRES(mutex_);

  const std::shared_ptr<Bell> bell_;
  Mutex mutex_;  ///< Guards the camera against ending while another thread uses it.
  FoundCamera found_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<::libcamera::FrameBufferAllocator> buffers_ NACELLE_GUARDED_BY(mutex_);
  std::vector<std::unique_ptr<::libcamera::Request>> requests_ NACELLE_GUARDED_BY(mutex_);
  std::vector<std::pair<unsigned, ::libcamera::ControlValue>> wished_ NACELLE_GUARDED_BY(mutex_);
  bool running_ NACELLE_GUARDED_BY(mutex_) = false;
  std::vector<Slot> slots_;
  Guarded<std::deque<Completed>> completed_;
  std::atomic<unsigned> queued_{0};
  std::atomic<bool> gone_{false};
  std::atomic<int> hook_failure_{0};
};

}  // namespace nacelle::camera
