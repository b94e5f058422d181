// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "camera/port/v4l2_calls.hpp"
#include "nacelle/io/descriptor.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::camera {

/// A V4L2 camera made of memory: behaves as the kernel's videobuf2 documents it, and has the faults that a test wants.
///
/// Waiting for a frame that does not come lets the clock run instead; after hold_time() only as far as pass() allows.
/// Threads: V4l2Calls and all functions but hold_time() from any; the public members while no other thread calls.
class ScriptedCamera final : public V4l2Calls {
 public:
  struct Buffer {
    std::vector<std::uint8_t> memory;
    std::uint8_t* user = nullptr;  ///< Where a frame goes instead, if the driver gave memory of its own.
    bool queued = false, mapped = false;
    v4l2_buffer filled{};
  };

  explicit ScriptedCamera(test::ManualClock& clock) : clock_(clock) {}

  // What the device is like.
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes{{640, 480}, {320, 240}};
  std::uint32_t padding = 0;        ///< Extra bytes a line.
  std::uint32_t most_buffers = 32;  ///< REQBUFS grants no more.
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  bool has_rate = true, takes_user_memory = true;
  v4l2_fract frame_time{1, 30};  ///< In seconds; the device has no other.
  int open_answer = 0;           ///< -errno that open() answers.
  std::vector<v4l2_queryctrl> controls;
  std::map<std::uint32_t, std::int32_t> control_values;

  /// The next call of that request answers -errno instead of doing anything; several calls line up.
  void fail_next(unsigned long request, int answer) {
    const std::lock_guard lock{mutex_};
    faults_[request].push_back(answer);
  }
  void unplug() {
    const std::lock_guard lock{mutex_};
    unplugged_ = true;
    stir_.ring();
  }
  void plug() {
    const std::lock_guard lock{mutex_};
    unplugged_ = false;
  }

  /// A control's value, while the driver's thread may set it.
  std::int32_t control_value(std::uint32_t id) {
    const std::lock_guard lock{mutex_};
    return control_values[id];
  }
  /// Stops the clock while the driver waits for a frame; the driver then waits for the test. Call it before streaming.
  void hold_time() { held_at_ = clock_.now(); }
  /// Lets that much time pass. Returns when the driver has taken every frame, has used up the time and waits again, or when it
  /// has closed the device.
  void pass(Duration time) {
    std::unique_lock lock{mutex_};
    held_at_ = clock_.now() + time;
    stir_.ring();
    driver_changed_.wait(
        lock, [this] { return open_descriptors.empty() || (is_still_ && done_.empty() && clock_.now() >= *held_at_); });
  }

  /// The sensor delivers: the oldest queued buffer is filled. False if there is none, or no stream: the frame is lost.
  bool deliver(std::uint32_t sequence, std::uint8_t fill, std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC,
               long bytes = -1, Duration age = 0ms) {
    const std::lock_guard lock{mutex_};
    if (!streaming_ || waiting_.empty()) return false;
    const std::uint32_t index = waiting_.front();
    waiting_.pop_front();
    Buffer& buffer = buffers[index];
    std::memset(buffer.user != nullptr ? buffer.user : buffer.memory.data(), fill, buffer.memory.size());
    buffer.filled = v4l2_buffer{};
    buffer.filled.index = index;
    buffer.filled.flags = flags;
    buffer.filled.sequence = sequence;
    buffer.filled.bytesused =
        bytes < 0 ? static_cast<std::uint32_t>(buffer.memory.size()) : static_cast<std::uint32_t>(bytes);
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(clock_.now().since_origin - age).count();
    buffer.filled.timestamp = {us / 1'000'000, us % 1'000'000};
    done_.push_back(index);
    stir_.ring();
    return true;
  }

  std::deque<Buffer> buffers;
  std::map<unsigned long, int> calls;  ///< How often each request came.
  std::set<int> open_descriptors;
  int used_after_close = 0;
  std::string opened;

  int open(const char* device) override {
    const std::lock_guard lock{mutex_};
    if (open_answer != 0) return open_answer;
    if (unplugged_) return -ENOENT;
    opened = device;
    open_descriptors.insert(++last_descriptor_);
    for (auto& buffer : buffers) retired_.push_back(std::move(buffer));
    buffers.clear();
    return last_descriptor_;
  }
  void close(int descriptor) override {
    const std::lock_guard lock{mutex_};
    open_descriptors.erase(descriptor);
    streaming_ = false;
    driver_changed_.notify_all();
  }
  int control(int descriptor, unsigned long request, void* argument) override {
    const std::lock_guard lock{mutex_};
    ++calls[request];
    if (open_descriptors.count(descriptor) == 0) {
      ++used_after_close;
      return -EBADF;
    }
    if (auto& line = faults_[request]; !line.empty()) {
      const int answer = line.front();
      line.pop_front();
      return answer;
    }
    if (unplugged_) return -ENODEV;
    return answer(request, argument);
  }
  void* map(int, std::size_t length, std::uint32_t offset) override {
    const std::lock_guard lock{mutex_};
    Buffer& buffer = buffers.at(offset / 4096);
    if (length != buffer.memory.size()) return nullptr;
    buffer.mapped = true;
    ++mapped;
    return buffer.memory.data();
  }
  void* allocate(std::size_t length) override {
    const std::lock_guard lock{mutex_};
    ++mapped;
    return retired_.emplace_back(Buffer{std::vector<std::uint8_t>(length)}).memory.data();
  }
  void unmap(void*, std::size_t) override {
    const std::lock_guard lock{mutex_};
    --mapped;
  }
  bool detach(void*, std::size_t) override {
    const std::lock_guard lock{mutex_};
    ++detached;
    return true;
  }
  DeviceWait wait(int descriptor, int bell, Duration longest) override {
    std::unique_lock lock{mutex_};
    ++waits;
    DeviceWait answer = look(descriptor, bell);
    if (answer.ready || answer.in_error || answer.woken) return answer;
    const Duration left = held_at_ ? std::max(*held_at_ - clock_.now(), Duration::zero()) : longest;
    if (left > Duration::zero() || longest == Duration::zero()) {
      clock_.advance(std::min(longest, left));
      return answer;
    }
    is_still_ = true;
    driver_changed_.notify_all();
    lock.unlock();
    std::array<pollfd, 2> watched{pollfd{bell, POLLIN, 0}, pollfd{stir_.descriptor(), POLLIN, 0}};
    ::poll(watched.data(), watched.size(), -1);
    lock.lock();
    is_still_ = false;
    static_cast<void>(stir_.silence());
    return look(descriptor, bell);
  }
  int mapped = 0, detached = 0, waits = 0;

 private:
  static constexpr std::uint32_t kBytesPerPixel = 2;

  DeviceWait look(int descriptor, int bell) const {
    pollfd watched{bell, POLLIN, 0};
    DeviceWait answer;
    answer.woken = ::poll(&watched, 1, 0) > 0;
    if (descriptor >= 0) {
      answer.ready = !done_.empty() && !unplugged_;
      answer.in_error = unplugged_ || !streaming_ || (waiting_.empty() && done_.empty());
    }
    return answer;
  }
  int answer(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& to = *static_cast<v4l2_capability*>(argument);
        std::memcpy(to.card, "HD Webcam (Front)", 18);
        to.capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        to.device_caps = capabilities;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto& to = *static_cast<v4l2_fmtdesc*>(argument);
        if (to.index >= formats.size()) return -EINVAL;
        to.pixelformat = formats[to.index];
        return 0;
      }
      case VIDIOC_ENUM_FRAMESIZES: {
        auto& to = *static_cast<v4l2_frmsizeenum*>(argument);
        if (to.index >= sizes.size()) return -EINVAL;
        to.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        to.discrete = {sizes[to.index].first, sizes[to.index].second};
        return 0;
      }
      case VIDIOC_S_FMT: {
        auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        auto nearest = sizes.front();
        for (const auto& size : sizes) {
          if (size.first == pix.width && size.second == pix.height) nearest = size;
        }
        pix.width = nearest.first;
        pix.height = nearest.second;
        const bool jpeg = pix.pixelformat == V4L2_PIX_FMT_MJPEG;
        pix.bytesperline = jpeg ? 0 : pix.width * kBytesPerPixel + padding;
        pix.sizeimage = jpeg ? pix.width * pix.height : pix.bytesperline * pix.height;
        frame_bytes_ = pix.sizeimage;
        return 0;
      }
      case VIDIOC_G_PARM:
      case VIDIOC_S_PARM: {
        auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
        if (!has_rate) return -ENOTTY;
        capture.capability = V4L2_CAP_TIMEPERFRAME;
        capture.timeperframe = frame_time;
        return 0;
      }
      case VIDIOC_REQBUFS: {
        auto& to = *static_cast<v4l2_requestbuffers*>(argument);
        if (to.memory == V4L2_MEMORY_USERPTR && !takes_user_memory) return -EINVAL;
        to.count = std::min(to.count, most_buffers);
        for (auto& buffer : buffers) retired_.push_back(std::move(buffer));
        buffers.clear();
        for (std::uint32_t i = 0; i < to.count; ++i) buffers.push_back({std::vector<std::uint8_t>(frame_bytes_)});
        waiting_.clear();
        done_.clear();
        return 0;
      }
      case VIDIOC_QUERYBUF: {
        auto& to = *static_cast<v4l2_buffer*>(argument);
        to.length = static_cast<std::uint32_t>(buffers.at(to.index).memory.size());
        to.m.offset = to.index * 4096;
        return 0;
      }
      case VIDIOC_QBUF: {
        const std::uint32_t index = static_cast<v4l2_buffer*>(argument)->index;
        if (buffers.at(index).queued) return -EINVAL;
        const auto& given = *static_cast<v4l2_buffer*>(argument);
        if (given.memory == V4L2_MEMORY_USERPTR) {
          if (given.length < buffers[index].memory.size()) return -EINVAL;
          buffers[index].user = std::bit_cast<std::uint8_t*>(given.m.userptr);
        }
        buffers[index].queued = true;
        waiting_.push_back(index);
        return 0;
      }
      case VIDIOC_DQBUF: {
        if (!streaming_) return -EINVAL;
        if (done_.empty()) return -EAGAIN;
        const std::uint32_t index = done_.front();
        done_.pop_front();
        buffers[index].queued = false;
        *static_cast<v4l2_buffer*>(argument) = buffers[index].filled;
        return 0;
      }
      case VIDIOC_STREAMON: streaming_ = true; return 0;
      case VIDIOC_STREAMOFF: streaming_ = false; return 0;
      case VIDIOC_QUERYCTRL: {
        auto& to = *static_cast<v4l2_queryctrl*>(argument);
        for (const auto& control : controls) {
          if (control.id > (to.id & ~V4L2_CTRL_FLAG_NEXT_CTRL)) {
            to = control;
            return 0;
          }
        }
        return -EINVAL;
      }
      case VIDIOC_G_CTRL: {
        auto& to = *static_cast<v4l2_control*>(argument);
        to.value = control_values[to.id];
        return 0;
      }
      case VIDIOC_S_CTRL: {
        const auto& from = *static_cast<v4l2_control*>(argument);
        control_values[from.id] = from.value;
        return 0;
      }
      default: return -ENOTTY;
    }
  }

  test::ManualClock& clock_;
  std::mutex mutex_;
  std::condition_variable driver_changed_;
  std::optional<MonotonicTime> held_at_;  ///< The clock stops here; without a value it never does.
  Bell stir_;                             ///< Ends the wait of a driver whose time is held.
  bool is_still_ = false;                 ///< The driver waits and has used up its time.
  std::map<unsigned long, std::deque<int>> faults_;
  std::deque<std::uint32_t> waiting_, done_;
  std::deque<Buffer> retired_;  ///< Memory of earlier streams: mapped frames stay readable.
  std::size_t frame_bytes_ = 0;
  int last_descriptor_ = 100;
  bool streaming_ = false, unplugged_ = false;
};

}  // namespace nacelle::camera
