// SPDX-License-Identifier: Apache-2.0
// Loads, runs and unloads a component many times beside one that stays, and says what that cost and what of it stayed. With
// --network PEERS the container is on a network meanwhile, and that many other participants see each endpoint come and go.
#include <dlfcn.h>
#include <fmt/format.h>
#include <sched.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <geometry_msgs/msg/point.hpp>
#include <memory>
#include <optional>
#include <semaphore>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <thread>
#include <vector>

#include "lateness.hpp"
#include "nacelle/base/histogram.hpp"
#include "nacelle/runtime/container.hpp"
#include "process_counts.hpp"
#ifdef NACELLE_SOAK_NETWORK
#include "network.hpp"
#endif

namespace nacelle::soak {
namespace {

// Beside this program's folder. No path is compiled in: a compiler cache that another clone has filled serves this one. Read before
// main(): in a network of its own, and in a chroot, this link names the path outside the chroot.
const std::string kComponentFolder = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "../lib/nacelle";

using geometry_msgs::msg::Point;
using std_msgs::msg::String;

#ifdef NACELLE_SANITIZED
constexpr bool kSanitized = true;  // what is freed stays mapped, and everything takes its time
#else
constexpr bool kSanitized = false;
#endif
constexpr std::size_t kSettled = 100;  // cycles after which nothing may grow any more
constexpr std::size_t kMayGrow = 1'000'000;
static_assert(kMayGrow < 1'024'000, "what rclcpp loses in 100 cycles, we may not lose in all of them");
constexpr int kHeapNoise = 16'384;  // what threads keep in their caches of malloc, and calls under way
// On the network, for each participant of this process: what Cyclone's free lists have kept of the longest queues so far (50 to
// 120 KB alone, up to 500 KB with a peer, also in 10,000 cycles). 200 loads whose announcements stayed would leave 3.3 MB.
constexpr int kHeapNoiseOfParticipant = 524'288;

struct Options {
  std::size_t cycles = 10'000;
  bool counts_only = false;
  std::string json_file;
  std::optional<std::size_t> peers;  // on the network, with so many others; none: off it
};

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "soak-load: %s\n", why.c_str());
  std::exit(1);
}

std::size_t number(const std::string& word, const std::string& text, std::size_t least) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || *end != '\0' || value < least)
    fail(fmt::format("{} {}: give a number from {} on", word, text, least));
  return value;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == argc) fail(word + " needs a value");
      return argv[++i];
    };
    if (word == "--counts-only") {
      options.counts_only = true;
    } else if (word == "--json") {
      options.json_file = value();
    } else if (word == "--cycles") {
      options.cycles = number(word, value(), kSettled + 1);
    } else if (word == "--network") {
      options.peers = number(word, value(), 0);
    } else {
      fail("unknown option " + word +
           "; there are --cycles N, --network PEERS, --counts-only (of the times, only the limit of 1 s is held), "
           "--json FILE");
    }
  }
  return options;
}

/// A reader that stays, of a component's topic. `wait()` for the next message, or `drain()` what came.
template <typename T>
class PermanentReader final : ReadyListener {
 public:
  PermanentReader(runtime::Container& container, const std::string& topic, const QoS& qos)
      : topic_(topic),
        reader_(container.transport().create_reader({topic, &T::message_type(), qos, "/soak"}, Taking::Share, this)) {}
  ~PermanentReader() override { reader_.reset(); }

  template <typename F>
  void drain(const F& look) {
    while (Block* const block = reader_->take()) {
      look(*static_cast<const T*>(block->message));
      drop_reference(*block);
    }
  }
  void wait() {
    if (!arrived_.try_acquire_for(20s)) fail("no message on " + topic_ + " within 20 s");
    std::size_t n = 0;
    drain([&](const T&) { ++n; });
    if (n != 1) fail(fmt::format("{} messages on {}, not 1", n, topic_));
  }
  [[nodiscard]] ReaderCounters counters() const { return reader_->counters(); }

 private:
  void on_ready() noexcept override { arrived_.release(); }
  const std::string topic_;
  std::counting_semaphore<> arrived_{0};
  std::unique_ptr<Reader> reader_;
};

struct LateCounts {
  DurationHistogram late, own;  // own: without what the thread waited for a CPU
  std::uint64_t ticks = 0, above_1ms = 0, own_above_1ms = 0;
  void add(const Lateness& l) {
    const Duration mine = std::max(Duration{}, l.late - l.waited_for_cpu);
    late.record(l.late);
    own.record(mine);
    ++ticks;
    if (l.late > 1ms) ++above_1ms;
    if (mine > 1ms) ++own_above_1ms;
  }
};

/// A bare thread with a 1 kHz timer, at the same time on the same machine: what any timer suffers here without us.
class BareTimer {
 public:
  BareTimer() : thread_([this] { run(); }) {}
  ~BareTimer() { stop(); }
  const LateCounts& stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    return counts_;
  }

 private:
  void run() {
    const SystemClock clock;
    LatenessMeter meter;
    MonotonicTime due = clock.now() + 1ms;
    meter.restart(clock.now(), 1ms);
    while (!stopping_) {
      const timespec t{due.nanoseconds() / 1'000'000'000, due.nanoseconds() % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
      const MonotonicTime now = clock.now();
      counts_.add(meter.tick(now));
      due += 1ms * ((now - due) / Duration{1ms} + 1);
    }
  }
  LateCounts counts_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

struct Metric {
  std::string what;
  double value;
  std::string unit, goal, baseline;
  bool ok;
};

class Soak {
 public:
  explicit Soak(const Options& options) : options_(options) {}

  /// Returns the exit code.
  int run() {
    dlopen_cost();
    runtime::LoadRequest neighbour;
    neighbour.plugin = "nacelle::soak::Neighbour";
    const auto stays = must(container_.load(neighbour)).id;
    step(stays, Transition::Configure);
    word_ = container_.transport().create_writer({"/word", &String::message_type(), QoS(10), "/soak"});
    join_network();
    // Its ticks are drained after each cycle: none begin while others are waited for, which takes seconds on a busy machine.
    step(stays, Transition::Activate);
    bare_ = std::make_unique<BareTimer>();
    for (std::size_t i = 1; i <= options_.cycles; ++i) {
      cycle();
      if (i == kSettled) before_ = count_process();
    }
    after_ = count_process();
    note_lateness();
    lost_ticks_ = lateness_.counters().overwritten;
    leave_network();
    const LateCounts& bare = bare_->stop();
    static_cast<void>(must(container_.unload(stays)));
    report(bare);
    return std::ranges::all_of(metrics_, &Metric::ok) ? 0 : 1;
  }

 private:
  template <typename T>
  static T must(Result<T, Problem> result) {
    if (!result) fail(result.error().text());
    return std::move(result).value();
  }
  void step(std::uint64_t id, Transition transition) {
    const auto outcome = container_.trigger(id, transition);
    if (!outcome.success) fail(std::string(to_text(transition)) + ": " + outcome.reason);
  }
  static Lateness lateness_of(const Point& p) {
    return {Duration{static_cast<std::int64_t>(p.x)}, Duration{static_cast<std::int64_t>(p.y)}};
  }

  void note_lateness() {
    lateness_.drain([&](const Point& p) { late_.add(lateness_of(p)); });
  }

  // What the system's own part of a load and an unload is.
  void dlopen_cost() {
    const std::string file = kComponentFolder + "/nacelle_soak_cycled.so";
    for (int i = 0; i < 100; ++i) {
      const auto begin = clock_.now();
      void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
      const auto middle = clock_.now();
      if (handle == nullptr) fail(dlerror());
      dlclose(handle);
      dlopen_.record(middle - begin);
      dlclose_.record(clock_.now() - middle);
    }
  }

  void cycle() {
    runtime::LoadRequest request;
    request.plugin = "nacelle::soak::Cycled";
    request.parameters = {{"greeting", std::string("good day")}};
    const auto begin = clock_.now();
    const auto id = must(container_.load(request)).id;
    load_.record(clock_.now() - begin);
    step(id, Transition::Configure);
    step(id, Transition::Activate);
    await_network(true);
    Block* const word = word_->borrow();
    static_cast<String*>(word->message)->data = "to and fro";
    word_->publish(*word);
    echo_.wait();
    latched_.wait();
    step(id, Transition::Deactivate);
    step(id, Transition::Cleanup);
    const auto end = clock_.now();
    const auto outcome = must(container_.unload(id));
    unload_.record(clock_.now() - end);
    if (!outcome.image_closed) {
      ++kept_;
      // Messages that still wait for the neighbour: they are on their way.
      while (!container_.kept_images().empty()) std::this_thread::yield();
    }
    await_network(false);
    unseen_.record(clock_.now() - end);
    note_lateness();
  }

#ifdef NACELLE_SOAK_NETWORK
  void join_network() {
    if (!options_.peers) return;
    network_ = std::make_unique<SoakNetwork>(container_, clock_, *options_.peers);
    await_network(false);
  }
  void await_network(bool is_loaded) {
    if (!network_) return;
    network_->await(is_loaded ? SoakNetwork::With::Both : SoakNetwork::With::Neighbour);
    note_lateness();
  }
  void leave_network() {
    if (!network_) return;
    shown_ = network_->endpoints(SoakNetwork::With::Both) - network_->endpoints(SoakNetwork::With::Neighbour);
    network_.reset();
  }
  std::unique_ptr<SoakNetwork> network_;
#else
  void join_network() const {
    if (options_.peers) fail("--network: this program was built without Cyclone DDS; install cyclonedds-dev");
  }
  void await_network(bool) const {}
  void leave_network() const {}
#endif

  enum class Kind { Figure, Time, Plain };  // held: always, on a quiet machine, without a sanitizer
  void add(std::string what, double value, std::string unit, std::string goal, std::string baseline, bool ok,
           Kind kind = Kind::Figure) {
    const bool held = !(kSanitized && kind != Kind::Figure) && !(options_.counts_only && kind == Kind::Time);
    if (options_.peers) what = fmt::format("on the network, {} others: {}", *options_.peers, what);
    metrics_.push_back({std::move(what), value, std::move(unit), std::move(goal), std::move(baseline), ok || !held});
  }

  void report(const LateCounts& bare) {
    const auto us = [](Duration d) { return to_seconds(d) * 1e6; };
    const auto grown = static_cast<double>(after_.resident_bytes) - static_cast<double>(before_.resident_bytes);
    const auto span = static_cast<double>(options_.cycles - kSettled);
    add("load, median", us(load_.quantile(0.5)), "us", "<= 1000",
        fmt::format("dlopen {:.0f}; rclcpp 3000 to 4000", us(dlopen_.quantile(0.5))), load_.quantile(0.5) <= 1ms,
        Kind::Time);
    add("load, p99", us(load_.quantile(0.99)), "us", "", "", true);
    add("unload, median", us(unload_.quantile(0.5)), "us", "<= 1000",
        fmt::format("dlclose {:.0f}; rclcpp 100000 to 200000", us(dlclose_.quantile(0.5))),
        unload_.quantile(0.5) <= 1ms, Kind::Time);
    add("unload, p99", us(unload_.quantile(0.99)), "us", "", "", true);
    // Each peer of this process fills receive buffers of its own.
    const double may_grow = static_cast<double>(kMayGrow) * (1 + static_cast<double>(options_.peers.value_or(0)));
    if (options_.peers) {
      add("endpoints of each load", static_cast<double>(shown_), "", "", "", true);
      add("unload until their end is seen, max", us(unseen_.max()), "us", "<= 1000000", "", unseen_.max() <= 1s,
          Kind::Plain);
    }
    add(fmt::format("resident memory, cycle {} to {}", kSettled, options_.cycles), grown, "B",
        fmt::format("<= {}", may_grow), "", grown <= may_grow, Kind::Plain);
    const auto heap = static_cast<double>(after_.heap_bytes) - static_cast<double>(before_.heap_bytes);
    const double participants = options_.peers ? 1 + static_cast<double>(*options_.peers) : 0;
    const double noise = kHeapNoise + participants * kHeapNoiseOfParticipant;
    add("memory in use on the heap, of all cycles", heap, "B", fmt::format("<= {}", noise), "", heap <= noise,
        Kind::Plain);
    add("of it per cycle", heap / span, "B", "0 as cycles grow", "rclcpp 10240 (resident)", true);
    count("mappings", before_.mappings, after_.mappings, Kind::Plain);
    add("mapped files that differ", static_cast<double>(before_.files == after_.files ? 0 : 1), "", "0", "0",
        before_.files == after_.files);
    count("descriptors", before_.descriptors, after_.descriptors);
    count("threads", before_.threads, after_.threads);
    add("unloads whose image was kept for a while", static_cast<double>(kept_), "", "", "", true);
    add("ticks of the neighbour's 1 kHz timer", static_cast<double>(late_.ticks), "", "none unseen", "",
        lost_ticks_ == 0);
    // A virtual machine stops either CPU for a millisecond now and then: a bare thread with real-time priority on it sees 1 to 5 of
    // 10,000 ticks late. Without that priority, other programs delay it, too. Only a clearly larger number is an error.
    add("ticks late by more than 1 ms", static_cast<double>(late_.above_1ms), "", "",
        fmt::format("{} of {} of a bare thread", bare.above_1ms, bare.ticks), true);
    const auto allowed = 2 * bare.own_above_1ms + 3 * (1 + late_.ticks / 10'000);
    add("of them with a CPU at hand", static_cast<double>(late_.own_above_1ms), "", fmt::format("<= {}", allowed),
        std::to_string(bare.own_above_1ms), late_.own_above_1ms <= allowed, Kind::Time);
    for (const double q : {0.5, 0.99, 0.999})
      add(fmt::format("lateness with a CPU at hand, p{:g}", q * 100), us(late_.own.quantile(q)), "us", "",
          fmt::format("{:.0f}", us(bare.own.quantile(q))), true);
    add("lateness with a CPU at hand, max", us(late_.own.max()), "us", "", fmt::format("{:.0f}", us(bare.own.max())),
        true);
    print();
  }
  void count(const std::string& what, std::size_t before, std::size_t after, Kind kind = Kind::Figure) {
    add(what, static_cast<double>(after), "", fmt::format("{}, as after cycle {}", before, kSettled), "",
        before == after, kind);
  }

  void print() const {
    std::string json = "[";
    std::printf(
        "%zu cycles of load, configure, activate, deactivate, cleanup, unload; %s\n", options_.cycles,
        real_time_ ? "real-time priority" : "no real-time priority (CAP_SYS_NICE): beside whatever else runs here");
    for (const auto& m : metrics_) {
      std::printf("  %-66s %12.1f %-3s %-28s %-40s %s\n", m.what.c_str(), m.value, m.unit.c_str(), m.goal.c_str(),
                  m.baseline.c_str(), m.ok ? "" : "MISSED");
      fmt::format_to(std::back_inserter(json),
                     R"({}{{"id":"M20","what":"{}","value":{:.3f},"unit":"{}","goal":"{}","baseline":"{}","ok":{}}})",
                     json.size() > 1 ? "," : "", m.what, m.value, m.unit, m.goal, m.baseline, m.ok);
    }
    json += "]";
    std::printf("%s\n", json.c_str());
    if (before_.files != after_.files) {
      for (const auto& [file, n] : after_.files) {
        const auto was = before_.files.find(file);
        const std::size_t then = was == before_.files.end() ? 0 : was->second;
        if (then != n) std::printf("  %s: %zu mappings, %zu before\n", file.c_str(), n, then);
      }
    }
    if (options_.json_file.empty()) return;
    std::ofstream file(options_.json_file);
    file << json << '\n';
    if (!file.flush()) fail(options_.json_file + " cannot be written");
  }

  // Inherited by every thread: other programs of the machine do not count then.
  static bool take_priority() {
    const sched_param priority{.sched_priority = 10};
    return ::sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  }

  const Options options_;
  const bool real_time_ = take_priority();
  SystemClock clock_;
  // On the network each node has the endpoints that ROS 2's tools expect, as with the program.
  runtime::Container container_{
      {.name = "soak",
       .component_path = {kComponentFolder},
       .node_interfaces = options_.peers ? runtime::NodeInterfaces::All : runtime::NodeInterfaces::None},
      clock_};
  PermanentReader<String> echo_{container_, "/echo", QoS(10)};
  PermanentReader<String> latched_{container_, "/latched", QoS(1).transient_local()};
  PermanentReader<Point> lateness_{container_, "/lateness",
                                   QoS(10'000)};  // ten seconds of ticks: a busy machine may pause the cycles
  std::uint64_t lost_ticks_ = 0;                  // by this reader, while cycles ran
  std::unique_ptr<Writer> word_;
  std::unique_ptr<BareTimer> bare_;
  DurationHistogram load_, unload_, unseen_, dlopen_, dlclose_;
  LateCounts late_;
  ProcessCounts before_, after_;
  std::size_t kept_ = 0, shown_ = 0;
  std::vector<Metric> metrics_;
};

}  // namespace
}  // namespace nacelle::soak

int main(int argc, char** argv) {
  const auto options = nacelle::soak::parse(argc, argv);
#ifdef NACELLE_SOAK_NETWORK
  if (options.peers) nacelle::soak::SoakNetwork::enter();
#endif
  return std::make_unique<nacelle::soak::Soak>(options)->run();
}
