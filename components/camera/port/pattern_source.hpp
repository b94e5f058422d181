// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "camera/model/pattern_scene.hpp"
#include "camera/port/capture_port.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::camera {

/// A camera that needs no device: PatternScene at the wished rate, on the clock's monotonic time.
///
/// It draws into the memory that next() is offered. Frame n is due at start + n periods, so that delays do not add up. A
/// caller that is more than a period late loses frames, as with a real camera.
/// Threads: as CapturePort. The clock outlives this object.
class PatternSource final : public CapturePort {
 public:
  explicit PatternSource(const Clock& clock) : clock_(clock) {}

  /// `wish.device` is ignored. Errors: CameraFault::CannotDraw.
  [[nodiscard]] Result<CaptureFormat, Problem> open(const CaptureWish& wish) override;
  [[nodiscard]] Result<void, Problem> start() override;
  [[nodiscard]] Result<Frame, CaptureFault> next(MonotonicTime deadline, ByteSpan offered) override;
  void interrupt() noexcept override { bell_.ring(); }
  void close() override { scene_.reset(); }
  [[nodiscard]] std::vector<Control> controls() override { return {}; }
  [[nodiscard]] Result<void, Problem> set_control(const Control& control, std::int64_t value) override;
  [[nodiscard]] CaptureStats stats() const override { return *stats_.lock(); }

  /// The scene while it is open; null otherwise.
  [[nodiscard]] const PatternScene* scene() const { return scene_ ? &*scene_ : nullptr; }

 private:
  const Clock& clock_;
  Bell bell_;
  std::optional<PatternScene> scene_;
  Duration period_{};
  MonotonicTime started_;
  std::uint64_t next_frame_ = 0;
  Guarded<CaptureStats> stats_;
};

}  // namespace nacelle::camera
