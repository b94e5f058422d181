// SPDX-License-Identifier: Apache-2.0
// The port against the kernel: a gamepad made with uinput. Needs /dev/uinput and the module evdev, as in the virtual machine of ./dev vm.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "joy/component/joy_component.hpp"
#include "joy/port/evdev_pad.hpp"
#include "pads.hpp"
#include "support/recording_host.hpp"

namespace nacelle::joy {
namespace {

namespace fs = std::filesystem;
using sensor_msgs::msg::Joy;

/// A gamepad that is plugged in as long as the object lives.
class UinputPad {
 public:
  explicit UinputPad(const std::string& name) : device_(::open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC)) {
    const PadInfo pad = xbox_pad();
    EXPECT_EQ(::ioctl(number(), UI_SET_EVBIT, EV_KEY), 0);
    EXPECT_EQ(::ioctl(number(), UI_SET_EVBIT, EV_ABS), 0);
    for (std::size_t code = 0; code < pad.buttons.size(); ++code) {
      if (!pad.buttons[code]) continue;
      EXPECT_EQ(::ioctl(number(), UI_SET_KEYBIT, static_cast<int>(code)), 0);
    }
    for (std::size_t code = 0; code < pad.axes.size(); ++code) {
      if (!pad.axes[code]) continue;
      uinput_abs_setup axis{};
      axis.code = static_cast<std::uint16_t>(code);
      axis.absinfo.minimum = pad.axes[code]->minimum;
      axis.absinfo.maximum = pad.axes[code]->maximum;
      EXPECT_EQ(::ioctl(number(), UI_ABS_SETUP, &axis), 0);
    }
    uinput_setup setup{};
    setup.id.bustype = BUS_USB;
    std::strncpy(setup.name, name.c_str(), sizeof setup.name - 1);
    EXPECT_EQ(::ioctl(number(), UI_DEV_SETUP, &setup), 0);
    EXPECT_EQ(::ioctl(number(), UI_DEV_CREATE), 0);
    make_node();
  }
  ~UinputPad() {
    ::ioctl(number(), UI_DEV_DESTROY);
    if (made_node_) fs::remove(path_);
  }

  void send(int type, int code, int value) {
    input_event event{};
    event.type = static_cast<std::uint16_t>(type);
    event.code = static_cast<std::uint16_t>(code);
    event.value = value;
    EXPECT_EQ(::write(number(), &event, sizeof event), static_cast<ssize_t>(sizeof event));
  }
  void report() { send(EV_SYN, SYN_REPORT, 0); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] int number() const { return device_.number(); }
  /// Where there is no udev, the node is the test's to make.
  void make_node() {
    std::array<char, 64> name{};
    ASSERT_GE(::ioctl(number(), UI_GET_SYSNAME(name.size()), name.data()), 0);
    for (const auto& entry : fs::directory_iterator{fs::path{"/sys/devices/virtual/input"} / name.data()}) {
      const std::string event = entry.path().filename();
      if (!event.starts_with("event")) continue;
      path_ = "/dev/input/" + event;
      if (fs::exists(path_)) return;
      unsigned high = 0, low = 0;
      char colon = 0;
      std::ifstream{entry.path() / "dev"} >> high >> colon >> low;
      fs::create_directories("/dev/input");
      made_node_ = ::mknod(path_.c_str(), S_IFCHR | 0600, makedev(high, low)) == 0;
    }
  }

  io::Descriptor device_;
  std::string path_;
  bool made_node_ = false;
};

class RealPad : public ::testing::Test {
 protected:
  void SetUp() override {
    if (::access("/dev/uinput", W_OK) != 0) GTEST_SKIP() << "/dev/uinput is not there, or may not be written";
  }
  /// How much longer than on this machine a test may wait: the virtual machine says it.
  static Duration patience() {
    const char* const slowness = std::getenv("NACELLE_TEST_SLOWNESS");
    return 10s * (slowness != nullptr ? std::atoi(slowness) : 1);
  }
  const SystemClock clock_{};
};

TEST_F(RealPad, is_found_by_number_name_and_path) {
  UinputPad one{"nacelle pad one"}, two{"nacelle pad two"};
  for (const PadWish& wish : {PadWish{.name = "nacelle pad two"}, PadWish{.path = two.path()}}) {
    auto found = find_pad(wish);
    ASSERT_TRUE(found) << found.error().problem.what;
    EXPECT_EQ(found->info.name, "nacelle pad two");
    EXPECT_EQ(found->info.path, two.path());
    EXPECT_EQ(found->info.buttons, xbox_pad().buttons);
    EXPECT_EQ(found->info.axes[ABS_X]->minimum, -32768);
    EXPECT_EQ(found->info.axes[ABS_RZ]->maximum, 255);
    EXPECT_FALSE(found->info.axes[ABS_TILT_X]);
  }
  EXPECT_TRUE(find_pad({.index = 1}));
  const auto none = find_pad({.name = "nacelle pad three"});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().problem.way_out.find("'nacelle pad one', 'nacelle pad two'"), std::string::npos)
      << none.error().problem.way_out;
}

TEST_F(RealPad, hands_over_events_with_monotonic_times) {
  UinputPad device{"nacelle pad"};
  auto pad = EvdevPad::open({.path = device.path()}, clock_);
  ASSERT_TRUE(pad) << pad.error().what;
  const MonotonicTime before = clock_.now();
  device.send(EV_KEY, BTN_A, 1);
  device.send(EV_ABS, ABS_Y, -32768);
  device.report();
  InputEventDecoder decoder;
  std::vector<InputEvent> events;
  while (events.size() < 3) {
    const auto bytes = pad.value()->read_until(clock_.now() + patience());
    ASSERT_TRUE(bytes);
    ASSERT_FALSE(bytes->empty());
    ByteView left = *bytes;
    while (const auto event = decoder.next(left)) events.push_back(*event);
  }
  EXPECT_EQ(events[0].code, BTN_A);
  EXPECT_EQ(events[1].value, -32768);
  EXPECT_GE(events[0].at + 1us, before);
  EXPECT_LE(events[0].at, clock_.now());
  const auto info = pad.value()->inspect();
  ASSERT_TRUE(info);
  EXPECT_TRUE(info->pressed[BTN_A]);
  EXPECT_EQ(info->axes[ABS_Y]->value, -32768);
}

TEST_F(RealPad, tells_of_dropped_events_and_knows_the_state_after_them) {
  UinputPad device{"nacelle pad"};
  auto pad = EvdevPad::open({.path = device.path()}, clock_);
  ASSERT_TRUE(pad);
  for (int i = 1; i <= 2000; ++i) {
    device.send(EV_ABS, ABS_X, i);
    device.report();
  }
  bool dropped = false;
  InputEventDecoder decoder;
  for (;;) {
    const auto bytes = pad.value()->read_until(clock_.now() + 50ms);
    ASSERT_TRUE(bytes);
    if (bytes->empty()) break;
    ByteView left = *bytes;
    while (const auto event = decoder.next(left)) dropped |= event->is_syn(input_layout::kSynDropped);
  }
  EXPECT_TRUE(dropped);
  EXPECT_EQ(pad.value()->inspect()->axes[ABS_X]->value, 2000);
}

TEST_F(RealPad, is_found_again_by_its_path_under_the_same_descriptor) {
  auto device = std::make_unique<UinputPad>("nacelle pad");
  const std::string path = device->path();
  auto opened = EvdevPad::open({.path = path}, clock_);
  ASSERT_TRUE(opened) << opened.error().what;
  PadPort& pad = *opened.value();
  const int before = pad.descriptor();
  device.reset();
  EXPECT_EQ(pad.read_until(clock_.now() + patience()).error(), io::StreamFault::HungUp);
  EXPECT_EQ(pad.reopen().error(), io::StreamFault::NotFound);

  // The kernel gives the number anew although the old device is still open, unlike that of a serial line.
  device = std::make_unique<UinputPad>("nacelle pad");
  EXPECT_EQ(device->path(), path);
  ASSERT_TRUE(pad.reopen());
  EXPECT_EQ(pad.descriptor(), before);
  device->send(EV_KEY, BTN_B, 1);
  device->report();
  const auto bytes = pad.read_until(clock_.now() + patience());
  ASSERT_TRUE(bytes);
  EXPECT_FALSE(bytes->empty());
}

bool is_at_rest(const Joy& joy) {
  return std::all_of(joy.axes.begin(), joy.axes.end(), [](float axis) { return axis == 0.0F; }) &&
         std::all_of(joy.buttons.begin(), joy.buttons.end(), [](int button) { return button == 0; });
}

TEST_F(RealPad, stops_when_it_is_unplugged_and_comes_back) {
  const char* const told = std::getenv("NACELLE_VM_CYCLES");
  const int cycles = told != nullptr ? std::atoi(told) : 10;
  test::RecordingContext context{clock_};
  NodeOptions options{context};
  options.parameter_overrides({{"device_name", std::string{"nacelle pad"}}, {"autorepeat_rate", 0.0}});
  auto device = std::make_unique<UinputPad>("nacelle pad");
  JoyComponent joy{options};
  ASSERT_TRUE(joy.trigger(Transition::Configure).success);
  ASSERT_TRUE(joy.trigger(Transition::Activate).success);
  const auto entries = [](const char* folder) {
    return std::distance(fs::directory_iterator{folder}, fs::directory_iterator{});
  };
  const auto files = entries("/proc/self/fd"), threads = entries("/proc/self/task");
  for (int cycle = 0; cycle < cycles; ++cycle) {
    const std::size_t before = context.published<Joy>("/joy").size();
    device->send(EV_ABS, ABS_Y, -32768);
    device->send(EV_KEY, BTN_A, 1);
    device->report();
    ASSERT_TRUE(context.wait_for("/joy", before + 1, patience())) << "cycle " << cycle;
    EXPECT_EQ(context.published<Joy>("/joy").back().buttons[kXboxA], 1);
    device.reset();
    context.wait_for_open_faults(1);
    // The kernel lets the button go first, but not the stick, which may be read as well; the last word, once, is that all is at rest.
    const auto joys = context.published<Joy>("/joy");
    EXPECT_LE(joys.size(), before + 3) << "cycle " << cycle;
    EXPECT_TRUE(is_at_rest(joys.back())) << "cycle " << cycle;
    EXPECT_EQ(std::count_if(joys.begin() + static_cast<std::ptrdiff_t>(before), joys.end(), is_at_rest), 1)
        << "cycle " << cycle;
    device = std::make_unique<UinputPad>("nacelle pad");
    context.wait_for_open_faults(0);
    EXPECT_EQ(context.published<Joy>("/joy").size(), joys.size()) << "silence while it was away, cycle " << cycle;
  }
  EXPECT_EQ(context.closed_faults(), static_cast<std::size_t>(cycles));
  EXPECT_EQ(entries("/proc/self/fd"), files);
  EXPECT_EQ(entries("/proc/self/task"), threads);
  ASSERT_TRUE(joy.trigger(Transition::Deactivate).success);
  ASSERT_TRUE(joy.trigger(Transition::Cleanup).success);
}

}  // namespace
}  // namespace nacelle::joy
