// SPDX-License-Identifier: Apache-2.0
// A program that uses ROS 2's topics and services with another DDS: the parts that are the same for each DDS.
#pragma once

#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace nacelle::test::peers {

// The types as C++ sees them; each DDS has its own code for their bytes.
struct Text {
  static constexpr const char* kName = "std_msgs::msg::dds_::String_";
  std::string data;
};
struct Image {
  static constexpr const char* kName = "sensor_msgs::msg::dds_::Image_";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id;
  std::uint32_t height = 0, width = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;
};
struct Twist {
  static constexpr const char* kName = "geometry_msgs::msg::dds_::Twist_";
  std::array<double, 6> linear_angular{};
};
struct Odometry {
  static constexpr const char* kName = "nav_msgs::msg::dds_::Odometry_";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id, child_frame_id;
  std::array<double, 43> pose{};   // position, quaternion, covariance
  std::array<double, 42> twist{};  // linear, angular, covariance
};
struct AddRequest {
  static constexpr const char* kName = "example_interfaces::srv::dds_::AddTwoInts_Request_";
  std::uint64_t client = 0;
  std::int64_t number = 0, a = 0, b = 0;
};
struct AddResponse {
  static constexpr const char* kName = "example_interfaces::srv::dds_::AddTwoInts_Response_";
  std::uint64_t client = 0;
  std::int64_t number = 0, sum = 0;
};

struct Qos {
  bool best_effort = false, transient_local = false, keep_all = false;
  int depth = 10;
};

/// Wakes the one main thread for what a DDS's threads notice.
class Bell {
 public:
  void ring() {
    const std::lock_guard lock(mutex_);
    ++rings_;
    condition_.notify_all();
  }
  /// Asks again after each ring; false once `end` has passed.
  bool until(const std::function<bool()>& holds, std::chrono::steady_clock::time_point end) {
    for (;;) {
      std::unique_lock lock(mutex_);
      const std::uint64_t seen = rings_;
      lock.unlock();
      if (holds()) return true;
      lock.lock();
      if (!condition_.wait_until(lock, end, [&] { return rings_ != seen; })) return false;
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable condition_;
  std::uint64_t rings_ = 0;
};

inline std::uint32_t checksum(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t sum = 2166136261U;  // FNV-1a
  for (const std::uint8_t byte : bytes) sum = (sum ^ byte) * 16777619U;
  return sum;
}
inline void tell(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}
inline void tell_message(const Text& message) { tell("text " + message.data); }
inline void tell_message(const Image& message) {
  tell("image " + std::to_string(message.data.size()) + " " + std::to_string(checksum(message.data)) + " " +
       message.encoding + " " + message.frame_id);
}
inline void tell_message(const Twist& message) { tell("twist " + std::to_string(message.linear_angular[0])); }
inline void tell_message(const Odometry& message) {
  tell("odometry " + std::to_string(message.twist[0]) + " " + message.frame_id + " " + message.child_frame_id);
}

/// usage: PEER VERB --domain N --topic NAME [options]
///   pub    writes --count messages once --readers are matched and a line has come, and stays; --every MS between them
///   echo   reports each message
///   serve  answers --topic's requests (add_two_ints)
///   call   asks once for --a plus --b when a line has come
/// All stay until their standard input ends. The line is for the other side to say that it has found them: what is
/// written before that is lost, unless it is kept. echo and serve answer it with "met" once they have found the other
/// side, too.
struct Options {
  std::string verb, topic = "rt/chatter", type = "string", text = "hello";
  unsigned domain = 0;
  int count = 1, readers = 1, every_ms = 0;
  int ahead_ms = 0;           ///< How far the clock of source stamps is ahead; Cyclone's only.
  double speed = 0;           ///< Of a twist, in m/s.
  bool as_delivered = false;  ///< Interfaces and transports as the DDS has them by itself.
  bool at_home = false;       ///< The same, as ROS 2's range LOCALHOST has it; for Cyclone, CYCLONEDDS_URI sets it.
  std::size_t bytes = 64;
  std::int64_t a = 0, b = 0;
  std::optional<unsigned> garbage;  ///< Seed: bytes that are no message, under the type's name.
  Qos qos;
};

inline Options read_options(int argc, char** argv) {
  Options out;
  std::map<std::string, std::function<void(const char*)>> with_value{
      {"--topic", [&](const char* v) { out.topic = v; }},
      {"--type", [&](const char* v) { out.type = v; }},
      {"--text", [&](const char* v) { out.text = v; }},
      {"--domain", [&](const char* v) { out.domain = static_cast<unsigned>(std::atoi(v)); }},
      {"--count", [&](const char* v) { out.count = std::atoi(v); }},
      {"--readers", [&](const char* v) { out.readers = std::atoi(v); }},
      {"--every", [&](const char* v) { out.every_ms = std::atoi(v); }},
      {"--ahead", [&](const char* v) { out.ahead_ms = std::atoi(v); }},
      {"--speed", [&](const char* v) { out.speed = std::atof(v); }},
      {"--bytes", [&](const char* v) { out.bytes = std::strtoull(v, nullptr, 10); }},
      {"--depth", [&](const char* v) { out.qos.depth = std::atoi(v); }},
      {"--a", [&](const char* v) { out.a = std::strtoll(v, nullptr, 10); }},
      {"--b", [&](const char* v) { out.b = std::strtoll(v, nullptr, 10); }},
      {"--garbage", [&](const char* v) { out.garbage = static_cast<unsigned>(std::atoi(v)); }},
  };
  std::map<std::string, bool*> flags{{"--best-effort", &out.qos.best_effort},
                                     {"--as-delivered", &out.as_delivered},
                                     {"--at-home", &out.at_home},
                                     {"--transient-local", &out.qos.transient_local},
                                     {"--keep-all", &out.qos.keep_all}};
  if (argc > 1) out.verb = argv[1];
  for (int i = 2; i < argc; ++i) {
    if (const auto flag = flags.find(argv[i]); flag != flags.end()) {
      *flag->second = true;
    } else if (const auto value = with_value.find(argv[i]); value != with_value.end() && i + 1 < argc) {
      value->second(argv[++i]);
    } else {
      std::fprintf(stderr, "what is %s?\n", argv[i]);
      std::exit(2);
    }
  }
  return out;
}

inline Text make_message(const Options& options, int i, const Text& /*kind*/) {
  return {options.text + " " + std::to_string(i)};
}
inline Image make_message(const Options& options, int i, const Image& /*kind*/) {
  Image image{i, 5, "camera", 1, static_cast<std::uint32_t>(options.bytes), "mono8", 0, 0, {}};
  image.data.resize(options.bytes);
  for (std::size_t at = 0; at < image.data.size(); ++at) image.data[at] = static_cast<std::uint8_t>(at * 7 + i);
  return image;
}
inline Twist make_message(const Options& options, int /*i*/, const Twist& /*kind*/) { return {{options.speed}}; }
inline Odometry make_message(const Options& options, int i, const Odometry& /*kind*/) {
  return {i, 0, "odom", "base_footprint", {}, {options.speed}};
}

/// What a DDS has to offer: `Dds::Writer<T>` with matched() and write(), `Dds::Reader<T>` with matched() and take().
template <typename Dds>
class Peer {
 public:
  explicit Peer(Options options) : options_(std::move(options)), dds_(options_, bell_) {}

  int run() {
    std::thread watching([this] {
      std::array<char, 64> ignored{};
      while (::read(STDIN_FILENO, ignored.data(), ignored.size()) > 0) {
        told_to_go_ = true;
        bell_.ring();
      }
      ended_ = true;
      bell_.ring();
    });
    const bool did = work();
    if (!did) std::_Exit(1);  // the watching thread may never return
    static_cast<void>(bell_.until([this] { return ended_.load(); }, std::chrono::steady_clock::time_point::max()));
    watching.join();
    return 0;
  }

 private:
  bool work() {
    if constexpr (requires { typename Dds::GarbageWriter; }) {
      if (options_.garbage) return publish_garbage<typename Dds::GarbageWriter>();
    }
    if (options_.verb == "pub" || options_.verb == "echo") {
      if (options_.type == "image") return publish_or_echo<Image>();
      if (options_.type == "twist") return publish_or_echo<Twist>();
      if (options_.type == "odometry") return publish_or_echo<Odometry>();
      return publish_or_echo<Text>();
    }
    if (options_.verb == "serve") return serve();
    if (options_.verb == "call") return call();
    std::fprintf(stderr, "pub, echo, serve or call?\n");
    return false;
  }
  bool wait(const std::function<bool()>& holds) {
    const bool did =
        bell_.until([&] { return ended_ || holds(); }, std::chrono::steady_clock::now() + std::chrono::seconds(60));
    return did && !ended_;
  }

  template <typename T>
  bool publish_or_echo() {
    return options_.verb == "pub" ? publish<T>() : echo<T>();
  }
  template <typename T>
  bool publish() {
    typename Dds::template Writer<T> writer(dds_, options_.topic, options_.qos);
    tell("ready");
    if (!wait([&] { return told_to_go_ && writer.matched() >= options_.readers; })) return false;
    for (int i = 0; i < options_.count && !ended_; ++i) {
      writer.write(make_message(options_, i, T{}));
      if (options_.every_ms == 0) continue;
      const auto next = std::chrono::steady_clock::now() + std::chrono::milliseconds{options_.every_ms};
      static_cast<void>(bell_.until([this] { return ended_.load(); }, next));
    }
    tell("wrote " + std::to_string(options_.count));
    return stay();
  }
  template <typename GarbageWriter>
  bool publish_garbage() {
    GarbageWriter writer(dds_, options_.topic, options_.type == "image" ? Image::kName : Text::kName, options_.qos);
    tell("ready");
    if (!wait([&] { return told_to_go_ && writer.matched() >= options_.readers; })) return false;
    std::mt19937 random{*options_.garbage};
    for (int i = 0; i < options_.count; ++i) writer.write(random);
    tell("wrote " + std::to_string(options_.count));
    return stay();
  }
  void tell_met(bool have_met) {
    if (!told_to_go_ || !have_met || told_met_) return;
    told_met_ = true;
    tell("met");
  }
  template <typename T>
  bool echo() {
    typename Dds::template Reader<T> reader(dds_, options_.topic, options_.qos);
    tell("ready");
    for (int i = 0; i < options_.count; ++i) {
      std::optional<T> message;
      const auto comes = [&] {
        tell_met(reader.matched() > 0);
        return (message = reader.take()).has_value();
      };
      if (!wait(comes)) return false;
      tell_message(*message);
    }
    return stay();
  }
  bool serve() {
    typename Dds::template Reader<AddRequest> requests(dds_, "rq/" + options_.topic + "Request", options_.qos);
    typename Dds::template Writer<AddResponse> replies(dds_, "rr/" + options_.topic + "Reply", options_.qos);
    tell("ready");
    for (int i = 0; i < options_.count; ++i) {
      std::optional<AddRequest> request;
      const auto comes = [&] {
        tell_met(requests.matched() > 0 && replies.matched() > 0);
        return replies.matched() > 0 && (request = requests.take()).has_value();
      };
      if (!wait(comes)) return false;
      replies.write({request->client, request->number, request->a + request->b});
      tell("served " + std::to_string(request->a) + " " + std::to_string(request->b));
    }
    return stay();
  }
  bool call() {
    typename Dds::template Writer<AddRequest> requests(dds_, "rq/" + options_.topic + "Request", options_.qos);
    typename Dds::template Reader<AddResponse> replies(dds_, "rr/" + options_.topic + "Reply", options_.qos);
    tell("ready");
    if (!wait([&] { return told_to_go_ && requests.matched() > 0 && replies.matched() > 0; })) return false;
    const std::uint64_t client = requests.handle();
    std::optional<AddResponse> reply;
    // Every client of the service gets every reply.
    const auto is_ours = [&] {
      while ((reply = replies.take()).has_value()) {
        if (reply->client == client && reply->number == 1) return true;
      }
      return false;
    };
    // On a busy machine the first request of Fast DDS to Cyclone may be lost (seen twice in CI). Most likely Cyclone reports the match
    // before its reader takes messages, and then counts the request as history. So the request is repeated.
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    do {
      requests.write({client, 1, options_.a, options_.b});
      static_cast<void>(
          bell_.until([&] { return ended_ || is_ours(); }, std::chrono::steady_clock::now() + std::chrono::seconds(1)));
    } while (!reply && !ended_ && std::chrono::steady_clock::now() < end);
    if (!reply || ended_) return false;
    tell("sum " + std::to_string(reply->sum));
    return stay();
  }
  /// As long as the endpoints are wanted.
  bool stay() {
    static_cast<void>(bell_.until([this] { return ended_.load(); }, std::chrono::steady_clock::time_point::max()));
    return true;
  }

  const Options options_;
  Bell bell_;
  std::atomic<bool> ended_{false}, told_to_go_{false};
  bool told_met_ = false;
  Dds dds_;
};

}  // namespace nacelle::test::peers
