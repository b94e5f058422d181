// SPDX-License-Identifier: Apache-2.0
// The plugin of the benchmark `teleop`: joy_node with a gamepad whose stick moves by a schedule. Events have the time of the schedule, as a
// kernel's have the time of the interrupt: how late the thread wakes up for them counts.
#include <linux/input.h>

#include <algorithm>
#include <cmath>

#include "joy/component/joy_component.hpp"
#include "joy/port/scripted_pad.hpp"
#include "nacelle/io/descriptor.hpp"
#include "nacelle/node/component.hpp"
#include "stick/schedule.hpp"

namespace nacelle::bench {
namespace {

class ScheduledPad final : public joy::PadPort {
 public:
  ScheduledPad(const Schedule& schedule, const Clock& clock) : schedule_(schedule), clock_(clock) {
    info_.name = "benchmark";
    info_.buttons.set(BTN_A);
    info_.pressed.set(BTN_A);
    info_.axes[ABS_X] = info_.axes[ABS_Y] = joy::PadAxis{0, -32767, 32767};
  }

  Result<joy::PadInfo, io::StreamFault> inspect() override { return info_; }
  Result<ByteView, io::StreamFault> read_until(MonotonicTime deadline) override {
    const MonotonicTime due = next_ < schedule_.moves ? schedule_.at(next_) : deadline + 1s;
    // The bell alone: nothing else can be read.
    while (clock_.now() < std::min(deadline, due)) {
      if (io::wait_readable(bell_.descriptor(), bell_, clock_, std::min(deadline, due)) != io::Wake::TimedOut)
        return ByteView{};
    }
    if (clock_.now() < due) return ByteView{};
    bytes_ = joy::ScriptedPad::event(due, EV_ABS, ABS_Y,
                                     -static_cast<std::int32_t>(std::lround(Schedule::share(next_) * 32767)));
    const Bytes end = joy::ScriptedPad::event(due, EV_SYN, SYN_REPORT, 0);
    bytes_.insert(bytes_.end(), end.begin(), end.end());
    ++next_;
    return ByteView{bytes_};
  }
  Result<void, io::StreamFault> write(ByteView) override { return err(io::StreamFault::WriteFailed); }
  void interrupt() noexcept override { bell_.ring(); }
  Result<void, io::StreamFault> reopen() override { return {}; }
  int descriptor() const noexcept override { return -1; }

 private:
  const Schedule schedule_;
  const Clock& clock_;
  joy::PadInfo info_;
  std::uint64_t next_ = 0;
  Bytes bytes_;
  Bell bell_;
};

Result<std::unique_ptr<joy::PadPort>, Problem> open_scheduled(const joy::JoyOptions&, const Clock& clock) {
  return std::unique_ptr<joy::PadPort>{
      std::make_unique<ScheduledPad>(Schedule::of_environment().value_or(Schedule{}), clock)};
}

}  // namespace

class ScheduledJoy final : public joy::JoyComponent {
 public:
  explicit ScheduledJoy(const NodeOptions& options) : JoyComponent(options, open_scheduled) {}
};

}  // namespace nacelle::bench

NACELLE_REGISTER_COMPONENT(nacelle::bench::ScheduledJoy)
