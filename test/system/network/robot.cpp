// SPDX-License-Identifier: Apache-2.0
// A small robot on the network: camera, scan, odometry and transforms at their rates, each with a reader in this process
// that counts and times, and the mirror beside them. Usage: network_robot --domain N --config XML [--best-effort] [--no-mirror]
//   measure SECONDS   on standard input: answers with one line of JSON about that time
// Ends with its standard input.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <nav_msgs/msg/odometry.hpp>
#include <nlohmann/json.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <thread>
#include <vector>

#include "nacelle/runtime/broker.hpp"
#include "nacelle/transport_dds/mirror.hpp"

namespace nacelle::test {
namespace {

using nlohmann::json;

// --- what is published -----------------------------------------------------------------------------------------------

void stamp(builtin_interfaces::msg::Time& time, WallTime now) {
  const std::int64_t ns = now.nanoseconds();
  time.sec = static_cast<std::int32_t>(ns / 1'000'000'000);
  time.nanosec = static_cast<std::uint32_t>(ns % 1'000'000'000);
}

void fill(sensor_msgs::msg::Image& image, WallTime now) {
  stamp(image.header.stamp, now);
  image.header.frame_id = "camera";
  image.height = 480;
  image.width = 640;
  image.encoding = "rgb8";
  image.step = 3 * image.width;
  image.data.resize(std::size_t{image.step} * image.height);
}
void fill(sensor_msgs::msg::LaserScan& scan, WallTime now) {
  stamp(scan.header.stamp, now);
  scan.header.frame_id = "laser";
  scan.ranges.resize(455);
  scan.intensities.resize(455);
}
void fill(nav_msgs::msg::Odometry& odometry, WallTime now) {
  stamp(odometry.header.stamp, now);
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "base_link";
}
void fill(tf2_msgs::msg::TFMessage& message, WallTime now) {
  message.transforms.resize(1);
  stamp(message.transforms[0].header.stamp, now);
  message.transforms[0].header.frame_id = "odom";
  message.transforms[0].child_frame_id = "base_link";
}

// --- a stream with its local reader ----------------------------------------------------------------------------------

class Stream final : ReadyListener {
 public:
  struct Plan {
    const char* topic;
    int hz;
    QoS qos;
  };
  template <typename T>
  static std::unique_ptr<Stream> make(runtime::Broker& broker, const Clock& clock, const Plan& plan) {
    std::unique_ptr<Stream> made{new Stream(broker, clock, plan, T::message_type())};
    made->fill_ = [](void* message, WallTime now) { fill(*static_cast<T*>(message), now); };
    made->publishing_ = std::thread([self = made.get()] { self->publish(); });
    made->reading_ = std::thread([self = made.get()] { self->read(); });
    return made;
  }
  ~Stream() override {
    stopping_ = true;
    on_ready();
    publishing_.join();
    reading_.join();
  }
  void begin() {
    const std::lock_guard lock(mutex_);
    published_ = 0;
    ages_us_.clear();
  }
  [[nodiscard]] json report(double seconds) {
    const std::lock_guard lock(mutex_);
    std::sort(ages_us_.begin(), ages_us_.end());
    const auto at = [&](double share) {
      return ages_us_.empty() ? 0
                              : ages_us_[static_cast<std::size_t>(share * static_cast<double>(ages_us_.size() - 1))];
    };
    return {
        {"published", published_}, {"heard", ages_us_.size()}, {"hz", static_cast<double>(ages_us_.size()) / seconds},
        {"p50_us", at(0.5)},       {"p99_us", at(0.99)},       {"remote_readers", writer_->reader_count() - 1}};
  }

 private:
  Stream(runtime::Broker& broker, const Clock& clock, const Plan& plan, const msgs::MessageType& type)
      : clock_(clock),
        hz_(plan.hz),
        writer_(broker.create_writer({plan.topic, &type, plan.qos, "/robot"})),
        reader_(broker.create_reader({plan.topic, &type, plan.qos, "/local"}, Taking::Share, this)) {}

  void on_ready() noexcept override {
    const std::lock_guard lock(mutex_);
    ready_ = true;
    woken_.notify_one();
  }
  // By absolute times: a late message does not make the next ones late.
  void publish() {
    using std::chrono::steady_clock;
    const auto period = std::chrono::nanoseconds(1'000'000'000 / hz_);
    for (auto due = steady_clock::now(); !stopping_; due += period) {
      std::this_thread::sleep_until(due);
      Block* const block = writer_->borrow();
      fill_(block->message, clock_.wall_now());
      writer_->publish(*block);
      const std::lock_guard lock(mutex_);
      ++published_;
    }
  }
  void read() {
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        woken_.wait(lock, [this] { return std::exchange(ready_, false); });
      }
      if (stopping_) return;
      while (Block* const block = reader_->take()) {
        const auto age = std::chrono::duration_cast<std::chrono::microseconds>(clock_.now() - block->info.source_time);
        drop_reference(*block);
        const std::lock_guard lock(mutex_);
        ages_us_.push_back(age.count());
      }
    }
  }

  const Clock& clock_;
  const int hz_;
  void (*fill_)(void*, WallTime) = nullptr;
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;
  std::condition_variable woken_;
  bool ready_ = false;
  std::uint64_t published_ = 0;
  std::vector<std::int64_t> ages_us_;
  const std::unique_ptr<Writer> writer_;
  const std::unique_ptr<Reader> reader_;
  std::thread publishing_, reading_;
};

// --- the robot -------------------------------------------------------------------------------------------------------

double cpu_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) / 1e6;
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}
long resident_kib() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return resident * (::sysconf(_SC_PAGESIZE) / 1024);
}
/// How often the mirror's threads have gone to sleep, which is how often they were woken.
long wake_ups_of_network() {
  long count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string line;
    std::ifstream name(task.path() / "comm"), status(task.path() / "status");
    if (!std::getline(name, line) || (line != "network" && line != "network large")) continue;
    while (std::getline(status, line)) {
      if (line.starts_with("voluntary_ctxt_switches:")) count += std::stol(line.substr(line.find(':') + 1));
    }
  }
  return count;
}
json figures_of(const MirrorStats& of) {
  return {{"encoded", of.encoded},     {"bytes_encoded", of.bytes_encoded},
          {"overtaken", of.overtaken}, {"refused", of.refused},
          {"taps", of.taps},           {"writers", of.writers},
          {"stand_ins", of.stand_ins}, {"problems", of.problems}};
}

class Robot {
 public:
  Robot(std::uint32_t domain, const std::string& config, bool best_effort, bool with_mirror) {
    MirrorOptions options;
    options.domain_id = domain;
    options.config = config;
    if (with_mirror) {
      auto made = DdsMirror::start(broker_, clock_, options);
      if (!made) {
        std::fprintf(stderr, "%s\n", made.error().text().c_str());
        std::exit(1);
      }
      mirror_ = std::move(*made);
    }
    const auto qos = [&](std::size_t depth) { return best_effort ? QoS(depth).best_effort() : QoS(depth); };
    add<sensor_msgs::msg::Image>("image", {"/image", 30, qos(5)});
    add<sensor_msgs::msg::LaserScan>("scan", {"/scan", 10, qos(5)});
    add<nav_msgs::msg::Odometry>("odom", {"/odom", 50, qos(10)});
    add<tf2_msgs::msg::TFMessage>("tf", {"/tf", 100, qos(100)});
  }
  [[nodiscard]] json measure(double seconds) {
    const MirrorStats before = mirror_ ? mirror_->stats() : MirrorStats{};
    const double cpu = cpu_seconds();
    const long wake_ups = wake_ups_of_network();
    for (auto& [name, stream] : streams_) stream->begin();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    json out;
    for (auto& [name, stream] : streams_) out["streams"][name] = stream->report(seconds);
    const MirrorStats after = mirror_ ? mirror_->stats() : MirrorStats{};
    out["network_wake_ups"] = wake_ups_of_network() - wake_ups;
    out["cpu_percent"] = 100 * (cpu_seconds() - cpu) / seconds;
    out["rss_kib"] = resident_kib();
    out["mirror"] = figures_of(after);
    out["during"] = {{"encoded", after.encoded - before.encoded},
                     {"overtaken", after.overtaken - before.overtaken},
                     {"refused", after.refused - before.refused}};
    return out;
  }

 private:
  template <typename T>
  void add(const char* name, const Stream::Plan& plan) {
    streams_.emplace_back(name, Stream::make<T>(broker_, clock_, plan));
  }

  const SystemClock clock_;
  runtime::Broker broker_{clock_, runtime::Watching::ByThread};
  std::unique_ptr<DdsMirror> mirror_;
  std::vector<std::pair<std::string, std::unique_ptr<Stream>>> streams_;
};

}  // namespace
}  // namespace nacelle::test

int main(int argc, char** argv) {
  std::uint32_t domain = 0;
  std::string config;
  bool with_mirror = true, best_effort = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--no-mirror") {
      with_mirror = false;
    } else if (word == "--best-effort") {
      best_effort = true;
    } else if (word == "--domain" && i + 1 < argc) {
      domain = static_cast<std::uint32_t>(std::stoul(argv[++i]));
    } else if (word == "--config" && i + 1 < argc) {
      config = argv[++i];
    } else {
      std::fprintf(stderr, "what is %s?\n", argv[i]);
      return 2;
    }
  }
  nacelle::test::Robot robot{domain, config, best_effort, with_mirror};
  std::cout << "ready" << std::endl;
  std::string verb;
  double seconds = 0;
  while (std::cin >> verb >> seconds) std::cout << robot.measure(seconds).dump() << std::endl;
  return 0;
}
