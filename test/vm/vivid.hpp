// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "in_machine.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::test {

/// The kernel's virtual camera, with its own controls for pictures and faults: /dev/video0 captures, /dev/video1 is an output.
/// Source: kernel, Documentation/admin-guide/media/vivid.rst; numbers of controls as `v4l2-ctl -L` prints them.
class Vivid {
 public:
  enum Control : std::uint32_t {
    TestPattern = 0x00f0f000,      ///< 0: colour bars
    OsdText = 0x00f0f001,          ///< 0: all, 2: none
    TimestampSource = 0x00f0f018,  ///< 0: end of frame, 1: start of exposure
    WrapSequence = 0x00f0f026,
    DroppedPercent = 0x00f0f040,
    // One press each.
    Disconnect = 0x00f0f041,  ///< Until every program has closed the device.
    DamagedBuffer = 0x00f0f042,
    RefuseBuffers = 0x00f0f043,   ///< The next REQBUFS fails,
    RefuseQueueing = 0x00f0f044,  ///< the next QBUF,
    RefuseStream = 0x00f0f045,    ///< the next STREAMON.
    FatalError = 0x00f0f046
  };
  inline static const std::string kCamera = "/dev/video0", kOutput = "/dev/video1";

  static void set(Control control, std::int32_t value) {
    const io::Descriptor device{::open(kCamera.c_str(), O_RDWR | O_CLOEXEC)};
    v4l2_control setting{};
    setting.id = control;
    setting.value = value;
    EXPECT_EQ(::ioctl(device.number(), VIDIOC_S_CTRL, &setting), 0) << std::hex << control << ", errno " << errno;
  }
  static void press(Control button) { set(button, 1); }
  /// A still picture, no faults.
  static void calm() {
    set(OsdText, 2);
    set(TestPattern, 0);
    set(TimestampSource, 1);
    set(WrapSequence, 0);
    set(DroppedPercent, 0);
  }
  /// The driver lets its devices go, as for a pulled cable, and takes them again.
  static void unbind() { write_file("/sys/bus/platform/drivers/vivid/unbind", "vivid.0"); }
  static void bind() { write_file("/sys/bus/platform/drivers/vivid/bind", "vivid.0"); }
};

/// Buffers of a V4L2 output for pictures in YUYV, exported as dma-bufs.
class ExportedBuffers {
 public:
  ExportedBuffers(const std::string& device, std::uint32_t width, std::uint32_t height, std::uint32_t count)
      : device_(::open(device.c_str(), O_RDWR | O_CLOEXEC)) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    ask(VIDIOC_G_FMT, format);
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_YUYV;
    format.fmt.pix.bytesperline = 0;
    ask(VIDIOC_S_FMT, format);
    v4l2_requestbuffers wanted{};
    wanted.count = count;
    wanted.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    wanted.memory = V4L2_MEMORY_MMAP;
    ask(VIDIOC_REQBUFS, wanted);
    for (std::uint32_t index = 0; index < wanted.count; ++index) {
      v4l2_buffer buffer{};
      buffer.index = index;
      buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
      buffer.memory = V4L2_MEMORY_MMAP;
      ask(VIDIOC_QUERYBUF, buffer);
      v4l2_exportbuffer exported{};
      exported.index = index;
      exported.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
      exported.flags = O_RDWR | O_CLOEXEC;
      ask(VIDIOC_EXPBUF, exported);
      // An output's buffers are mapped for writing only.
      void* const memory =
          ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, device_.number(), buffer.m.offset);
      EXPECT_NE(memory, MAP_FAILED);
      buffers_.push_back({io::Descriptor{exported.fd}, memory, buffer.length});
    }
  }
  ~ExportedBuffers() {
    for (const auto& buffer : buffers_) ::munmap(buffer.memory, buffer.length);
  }
  ExportedBuffers(const ExportedBuffers&) = delete;
  ExportedBuffers& operator=(const ExportedBuffers&) = delete;

  [[nodiscard]] std::vector<int> dma_bufs() const {
    std::vector<int> numbers;
    for (const auto& buffer : buffers_) numbers.push_back(buffer.dma_buf.number());
    return numbers;
  }
  /// Whether the device itself sees these bytes in that buffer.
  [[nodiscard]] bool holds(int dma_buf, ByteView bytes) const {
    for (const auto& buffer : buffers_) {
      if (buffer.dma_buf.number() == dma_buf) return std::memcmp(buffer.memory, bytes.data(), bytes.size()) == 0;
    }
    return false;
  }

 private:
  struct Buffer {
    io::Descriptor dma_buf;
    void* memory;
    std::size_t length;
  };
  template <typename T>
  void ask(unsigned long request, T& argument) const {
    EXPECT_EQ(::ioctl(device_.number(), request, &argument), 0)
        << std::hex << request << ", errno " << std::dec << errno;
  }
  const io::Descriptor device_;
  std::vector<Buffer> buffers_;
};

}  // namespace nacelle::test
