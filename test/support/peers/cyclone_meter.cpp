// SPDX-License-Identifier: Apache-2.0
// A laptop on plain Cyclone DDS: reads the streams of network_robot, counts them and looks at how old they are.
// Usage: cyclone_meter --domain N [--best-effort] [TOPIC ...], of image, scan, odom and tf; none: all.
//   measure SECONDS   on standard input: answers with one line of JSON about that time
#include <dds/dds.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "ros_types.h"

namespace {

using Time = builtin_interfaces_msg_dds__Time_;

struct Kind {
  const char* topic;
  const dds_topic_descriptor_t* type;
  int depth;
  Time (*stamp)(const void* sample);
};

template <typename T>
Time stamp_of(const void* sample) {
  return static_cast<const T*>(sample)->header.stamp;
}
Time stamp_of_tf(const void* sample) {
  const auto& message = *static_cast<const tf2_msgs_msg_dds__TFMessage_*>(sample);
  return message.transforms._length == 0 ? Time{} : message.transforms._buffer[0].header.stamp;
}

const std::map<std::string, Kind> kKinds{
    {"image", {"rt/image", &sensor_msgs_msg_dds__Image__desc, 5, stamp_of<sensor_msgs_msg_dds__Image_>}},
    {"scan", {"rt/scan", &sensor_msgs_msg_dds__LaserScan__desc, 5, stamp_of<sensor_msgs_msg_dds__LaserScan_>}},
    {"odom", {"rt/odom", &nav_msgs_msg_dds__Odometry__desc, 10, stamp_of<nav_msgs_msg_dds__Odometry_>}},
    {"tf", {"rt/tf", &tf2_msgs_msg_dds__TFMessage__desc, 100, stamp_of_tf}},
};

dds_entity_t must(dds_entity_t made, const char* what) {
  if (made >= 0) return made;
  std::fprintf(stderr, "%s: %s\n", what, dds_strretcode(made));
  std::exit(1);
}

class Meter {
 public:
  Meter(dds_entity_t participant, const Kind& kind, bool best_effort) : kind_(kind) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, kind.depth);
    dds_listener_t* const told = dds_create_listener(this);
    dds_lset_data_available(told, [](dds_entity_t from, void* self) { static_cast<Meter*>(self)->take(from); });
    const dds_entity_t topic = must(dds_create_topic(participant, kind.type, kind.topic, nullptr, nullptr), "topic");
    must(dds_create_reader(participant, topic, qos, told), "reader");
    dds_delete_listener(told);
    dds_delete_qos(qos);
  }
  void begin() {
    const std::lock_guard lock(mutex_);
    ages_us_.clear();
  }
  [[nodiscard]] std::string report(double seconds) {
    const std::lock_guard lock(mutex_);
    std::sort(ages_us_.begin(), ages_us_.end());
    const auto at = [&](double share) {
      return ages_us_.empty() ? 0
                              : ages_us_[static_cast<std::size_t>(share * static_cast<double>(ages_us_.size() - 1))];
    };
    char text[160];
    std::snprintf(text, sizeof(text), R"({"heard": %zu, "hz": %.2f, "p50_us": %lld, "p99_us": %lld})", ages_us_.size(),
                  static_cast<double>(ages_us_.size()) / seconds, at(0.5), at(0.99));
    return text;
  }

 private:
  // On Cyclone's thread.
  void take(dds_entity_t from) {
    for (;;) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      if (dds_take(from, &sample, &info, 1, 1) <= 0) return;
      if (info.valid_data) {
        const Time stamp = kind_.stamp(sample);
        const long long now =
            std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
                .count();
        const std::lock_guard lock(mutex_);
        ages_us_.push_back(now - (stamp.sec * 1'000'000LL + stamp.nanosec / 1000));
      }
      dds_return_loan(from, &sample, 1);
    }
  }

  const Kind kind_;
  std::mutex mutex_;
  std::vector<long long> ages_us_;
};

}  // namespace

int main(int argc, char** argv) {
  dds_domainid_t domain = 0;
  bool best_effort = false;
  std::vector<std::string> topics;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--best-effort") == 0) {
      best_effort = true;
    } else if (std::strcmp(argv[i], "--domain") == 0 && i + 1 < argc) {
      domain = static_cast<dds_domainid_t>(std::atoi(argv[++i]));
    } else if (kKinds.contains(argv[i])) {
      topics.emplace_back(argv[i]);
    } else {
      std::fprintf(stderr, "what is %s?\n", argv[i]);
      return 2;
    }
  }
  if (topics.empty()) {
    for (const auto& [name, kind] : kKinds) topics.push_back(name);
  }
  const dds_entity_t participant = must(dds_create_participant(domain, nullptr, nullptr), "participant");
  std::map<std::string, std::unique_ptr<Meter>> meters;
  for (const auto& name : topics) meters[name] = std::make_unique<Meter>(participant, kKinds.at(name), best_effort);
  std::cout << "ready" << std::endl;
  std::string verb;
  double seconds = 0;
  while (std::cin >> verb >> seconds) {
    for (auto& [name, meter] : meters) meter->begin();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    std::string line;
    for (auto& [name, meter] : meters) {
      line += line.empty() ? "{" : ", ";
      line += '"';
      line += name + "\": " + meter->report(seconds);
    }
    std::cout << line << "}" << std::endl;
  }
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return 0;
}
