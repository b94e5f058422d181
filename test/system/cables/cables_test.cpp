// SPDX-License-Identifier: Apache-2.0
// Every driver on a serial line, against its device's emulator on a pty: its cable is pulled and returns, again and again, in real time.
#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <regex>

#include "cable.hpp"
#include "devices_on_lines.hpp"
#include "diff_drive/component/diff_drive_component.hpp"
#include "gps/component/gps_component.hpp"
#include "imu/component/imu_component.hpp"
#include "lidar/component/lidar_component.hpp"
#include "nacelle/base/log.hpp"
#include "simulation/component/run_device.hpp"
#include "simulation/protocol/hiwonder_device.hpp"
#include "simulation/protocol/odrive_device.hpp"
#include "simulation/protocol/roboclaw_device.hpp"
#include "simulation/protocol/vesc_device.hpp"
#include "support/recording_host.hpp"
#include "unit/components/diff_drive/firmware/simulated_board.hpp"

namespace nacelle {
namespace {

using test::Cable;
using test::RecordingContext;
using Overrides = std::map<std::string, ParameterValue>;

/// It bounds a broken build only.
constexpr Duration kPatience = 60s;
/// A loss is reported within this time (no device here has a period of more than a third of it), and data is there again within the other.
constexpr Duration kLossLimit = 500ms, kReturnLimit = 2s;
/// What the heap may grow by in all cycles together: in 200 of them about 120 bytes of each.
constexpr std::int64_t kHeapSlack = 24'576;
constexpr std::array kTopics{"/scan", "/imu/data_raw",   "/imu/data",     "/imu/mag",       "/imu/temperature", "/fix",
                             "/vel",  "/time_reference", "/joint_states", "/battery/state", "/diagnostics"};

struct Protocol {
  const char* name;
  const char* topic;
  const char* port;  ///< The parameter of the line.
  std::function<std::unique_ptr<LifecycleNode>(const NodeOptions& options)> make;
  Cable::MakeDevice device;
  Overrides overrides{};
  Duration silence = kLossLimit;  ///< Until a device without power is reported.
};
void PrintTo(const Protocol& protocol, std::ostream* out) { *out << protocol.name; }

template <typename Component>
std::unique_ptr<LifecycleNode> made(const NodeOptions& options) {
  return std::make_unique<Component>(options);
}

Protocol lidar(const char* model) {
  return {model,
          "/scan",
          "port_name",
          made<lidar::LidarComponent>,
          [model] { return simulation::make_device(model, 1); },
          {{"model", std::string{model}}}};
}

template <typename Device>
Protocol imu(const char* model) {
  return {model,
          "/imu/data_raw",
          "port",
          made<imu::ImuComponent>,
          [] { return std::make_unique<Device>(); },
          {{"model", std::string{model}}, {"calibration_samples", std::int64_t{20}}}};
}

template <typename Device>
Protocol base(const char* hardware, unsigned baud, Overrides overrides = {}) {
  overrides.insert({{"hardware", std::string{hardware}}, {"update_rate", 50.0}});
  return {hardware,
          "/joint_states",
          "serial_port",
          made<diff_drive::DiffDriveComponent>,
          [baud]() -> std::unique_ptr<simulation::SerialDevice> {
            if constexpr (std::is_base_of_v<simulation::SerialDevice, Device>) {
              static_cast<void>(baud);  // its own
              return std::make_unique<Device>();
            } else if constexpr (requires { typename Device::Settings; }) {
              return std::make_unique<test::BoardOnALine>(std::make_unique<Device>(typename Device::Settings{}), baud);
            } else {
              return std::make_unique<test::BoardOnALine>(std::make_unique<Device>(), baud);
            }
          },
          std::move(overrides)};
}

/// Reports nothing but its battery, about once a second (docs/hardware.md).
Protocol hiwonder() {
  Protocol protocol = base<simulation::HiwonderDevice>("hiwonder", 1000000);
  protocol.silence = 3700ms;
  return protocol;
}

std::vector<Protocol> all_protocols() {
  using diff_drive::SimulatedBoard;
  const Overrides counts{{"counts_per_turn", 1440.0}};
  return {
      lidar("ld06"),
      lidar("rplidar_a1"),
      lidar("rplidar_c1"),
      lidar("ydlidar_x2"),
      lidar("ydlidar_x4"),
      imu<test::Wt901OnALine>("wt901"),
      imu<test::RvcOnALine>("bno08x_rvc"),
      imu<test::Bno055OnALine>("bno055_uart"),
      {"gps",
       "/fix",
       "port",
       made<gps::GpsComponent>,
       [] { return std::make_unique<test::GpsOnALine>(); },
       {{"baud", std::int64_t{115200}}}},
      base<test::UgvOnALine>("waveshare", 115200),
      base<simulation::RoboclawDevice>("roboclaw", 38400, counts),
      base<simulation::VescDevice>("vesc", 115200, {{"counts_per_turn", 90.0}, {"right_channel", std::int64_t{42}}}),
      base<simulation::OdriveDevice>("odrive", 115200),
      hiwonder(),
      base<SimulatedBoard>("framed", 115200, {{"counts_per_turn", SimulatedBoard::kCounts}}),
      base<SimulatedBoard>("text", 115200, {{"counts_per_turn", SimulatedBoard::kCounts}}),
  };
}

/// How often the driver says, when it is deactivated, that its line broke or its board was lost.
class CountedLosses final : public LogListener {
 public:
  CountedLosses() { add_log_listener(*this); }
  CountedLosses(const CountedLosses&) = delete;
  CountedLosses& operator=(const CountedLosses&) = delete;
  ~CountedLosses() override { remove_log_listener(*this); }
  void on_line(LogLevel, std::string_view, std::string_view text, const LogPlace&) noexcept override {
    std::cmatch found;
    if (!std::regex_search(text.data(), text.data() + text.size(), found, said_)) return;
    const std::lock_guard lock{mutex_};
    count_ = std::stoi(found[2]);
  }
  [[nodiscard]] int count() const {
    const std::lock_guard lock{mutex_};
    return count_;
  }

 private:
  const std::regex said_{"the (line broke|board was lost) (\\d+) times"};
  mutable std::mutex mutex_;
  int count_ = -1;
};

int cycles() {
  if (const char* const told = std::getenv("NACELLE_CABLE_CYCLES"); told != nullptr)
    return std::max(2, std::atoi(told));
  return 10;
}

struct Held {
  std::ptrdiff_t files{}, threads{};
  std::int64_t heap{};
};
Held held_by_this_process() {
  const auto count = [](const char* folder) {
    return std::distance(std::filesystem::directory_iterator{folder}, std::filesystem::directory_iterator{});
  };
  const auto heap = ::mallinfo2();
  return {count("/proc/self/fd"), count("/proc/self/task"), static_cast<std::int64_t>(heap.uordblks + heap.hblkhd)};
}

/// How late this machine wakes a thread: where other programs have its processors, the limits of time move by that.
class Lateness {
 public:
  Lateness() : thread_{[this] { run(); }} {}
  Lateness(const Lateness&) = delete;
  Lateness& operator=(const Lateness&) = delete;
  ~Lateness() {
    stops_ = true;
    bell_.ring();
    thread_.join();
  }
  /// For what takes this many threads, one after the other.
  [[nodiscard]] Duration of_threads(int count) const { return count * Duration{worst_ns_.load()}; }

 private:
  void run() {
    while (!stops_) {
      const MonotonicTime due = clock_.now() + 5ms;
      static_cast<void>(io::wait_readable(-1, bell_, clock_, due));
      worst_ns_ = std::max(worst_ns_.load(), (clock_.now() - due).count());
    }
  }
  SystemClock clock_;
  Bell bell_;
  std::atomic<bool> stops_{false};
  std::atomic<std::int64_t> worst_ns_{0};
  std::thread thread_;
};

/// Another device of the same robot, whose stream must not notice anything: a WT901 at 100 Hz.
class Bystander {
 public:
  Bystander() : cable_(path(), [this] { return std::make_unique<test::Wt901OnALine>(&sent_); }) {
    for (const char* topic : {"/imu/data", "/imu/mag", "/imu/temperature"}) context_.leave_unread(topic);
    NodeOptions options{context_};
    options.parameter_overrides(Overrides{{"port", path()}, {"calibrate_gyro", false}});
    imu_ = std::make_unique<imu::ImuComponent>(options);
    const auto configured = imu_->trigger(Transition::Configure);
    EXPECT_TRUE(configured.success) << configured.reason;
    EXPECT_TRUE(imu_->trigger(Transition::Activate).success);
    EXPECT_TRUE(context_.wait_for(kTopic, 10, kPatience));
    sent_before_ = sent_;
    context_.forget(kTopic);
  }
  /// Counts, and frees, what it has published.
  void forget() { published_ += context_.forget(kTopic); }
  /// Returns when it has published so many more: a pause that is no sleep.
  [[nodiscard]] bool wait_for(std::size_t more) {
    forget();
    return context_.wait_for(kTopic, more, kPatience);
  }
  /// Of the samples that its device has sent. The device itself is as fast as this machine lets it be.
  [[nodiscard]] double published_share() {
    const std::uint64_t sent = sent_ - sent_before_;
    EXPECT_TRUE(wait_for(1));
    forget();
    return static_cast<double>(published_) / static_cast<double>(sent);
  }
  [[nodiscard]] std::size_t open_faults() const { return context_.open_faults().size(); }

 private:
  static constexpr const char* kTopic = "/imu/data_raw";
  static std::string path() { return ::testing::TempDir() + "nacelle_bystander_" + std::to_string(::getpid()); }
  SystemClock clock_;
  RecordingContext context_{clock_};
  std::atomic<std::uint64_t> sent_{0};
  Cable cable_;
  std::unique_ptr<imu::ImuComponent> imu_;
  std::uint64_t sent_before_ = 0, published_ = 0;
};

class Cables : public ::testing::TestWithParam<Protocol> {
 protected:
  void SetUp() override {
    overrides_ = GetParam().overrides;
    overrides_.insert_or_assign(GetParam().port, path_);
    NodeOptions options{context_};
    options.parameter_overrides(overrides_);
    driver_ = GetParam().make(options);
    const auto configured = driver_->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    const auto activated = driver_->trigger(Transition::Activate);
    ASSERT_TRUE(activated.success) << activated.reason;
    ASSERT_TRUE(context_.wait_for(GetParam().topic, 3, kPatience));  // a receiver's period is known after two
    ASSERT_TRUE(context_.wait_for_open_faults(0, kPatience));
    closed_before_ = context_.closed_faults();
  }
  [[nodiscard]] std::size_t losses_that_ended() const { return context_.closed_faults() - closed_before_; }
  void forget() {
    for (const char* topic : kTopics) context_.forget(topic);
    bystander_.forget();
  }
  /// What the process holds while the device is away. The other device's messages come all the time: the least counts.
  void measure() {
    for (int attempt = 0; attempt < 10; ++attempt) {
      forget();
      const Held now = held_by_this_process();
      if (attempt == 0 || now.heap < held_.heap) held_ = now;
    }
  }
  /// Pulls what `pull` pulls, gives it back `away` messages of the bystander after the loss was reported, and holds both times.
  void lose_and_return(const std::function<void()>& pull, const std::function<void()>& give, std::size_t away) {
    const MonotonicTime pulled = clock_.now();
    pull();
    ASSERT_TRUE(context_.wait_for_open_faults(1, kPatience)) << "the loss is not reported";
    longest_loss_ = std::max(longest_loss_, clock_.now() - pulled);
    EXPECT_EQ(context_.open_faults().front().code, kDeviceLost);
    ASSERT_TRUE(bystander_.wait_for(away));
    measure();
    const MonotonicTime back = clock_.now();
    give();
    ASSERT_TRUE(context_.wait_for(GetParam().topic, 1, kPatience)) << "no data";
    longest_return_ = std::max(longest_return_, clock_.now() - back);
    ASSERT_TRUE(context_.wait_for_open_faults(0, kPatience)) << context_.open_faults().front().text;
  }

  void expect_times(Duration loss_limit) const {
    // The emulator, the reader, the waiting test; on the way back also the questions and answers of a start.
    EXPECT_LE(longest_loss_, loss_limit + lateness_.of_threads(3));
    EXPECT_LE(longest_return_, kReturnLimit + lateness_.of_threads(12));
  }

  SystemClock clock_;
  const Lateness lateness_;
  RecordingContext context_{clock_};
  const std::string path_ = ::testing::TempDir() + "nacelle_cable_" + std::to_string(::getpid());
  CountedLosses losses_;
  Bystander bystander_;
  Cable cable_{path_, GetParam().device};
  Overrides overrides_;
  std::unique_ptr<LifecycleNode> driver_;
  Held held_;
  std::size_t closed_before_ = 0;
  Duration longest_loss_{}, longest_return_{};
};

TEST_P(Cables, a_pulled_cable_is_reported_and_counted_once_and_leaves_nothing_behind) {
  const int count = cycles();
  Held first;
  for (int cycle = 1; cycle <= count; ++cycle) {
    SCOPED_TRACE(::testing::Message() << "cycle " << cycle);
    // The second one stays away until the driver tries once a second only.
    ASSERT_NO_FATAL_FAILURE(
        lose_and_return([this] { cable_.unplug(); }, [this] { cable_.plug(); }, cycle == 2 ? 250 : 0));
    if (cycle == 1) first = held_;
  }
  EXPECT_EQ(held_.files, first.files);
  EXPECT_EQ(held_.threads, first.threads);
  EXPECT_LE(held_.heap - first.heap, kHeapSlack);
  expect_times(kLossLimit);
  const double share = bystander_.published_share();
  EXPECT_NEAR(share, 1.0, 0.01);
  EXPECT_EQ(bystander_.open_faults(), 0U);
  EXPECT_EQ(losses_that_ended(), static_cast<std::size_t>(count));
  EXPECT_TRUE(context_.faults().empty());
  ASSERT_TRUE(driver_->trigger(Transition::Deactivate).success);
  EXPECT_EQ(losses_.count(), count);
  std::printf(
      "%s: %d cycles; reported within %.3f s, back within %.3f s (threads %.3f s late); heap %+lld bytes; others %.2f "
      "%%\n",
      GetParam().name, count, to_seconds(longest_loss_), to_seconds(longest_return_),
      to_seconds(lateness_.of_threads(1)), static_cast<long long>(held_.heap - first.heap), 100.0 * share);
}

TEST_P(Cables, a_device_without_power_behind_a_line_that_stays_is_reported_and_set_up_again) {
  for (int cycle = 1; cycle <= 3; ++cycle) {
    ASSERT_NO_FATAL_FAILURE(
        lose_and_return([this] { cable_.power_off(); }, [this] { cable_.power_on(); }, cycle == 2 ? 250 : 0));
  }
  expect_times(GetParam().silence);
  EXPECT_EQ(losses_that_ended(), 3U);
  EXPECT_TRUE(context_.faults().empty());
  std::printf("%s: reported within %.3f s, back within %.3f s (threads %.3f s late)\n", GetParam().name,
              to_seconds(longest_loss_), to_seconds(longest_return_), to_seconds(lateness_.of_threads(1)));
}

INSTANTIATE_TEST_SUITE_P(Serial, Cables, ::testing::ValuesIn(all_protocols()),
                         [](const auto& test) { return std::string{test.param.name}; });

}  // namespace
}  // namespace nacelle
