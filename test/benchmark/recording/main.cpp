// SPDX-License-Identifier: Apache-2.0
// recording [megabytes=64] [blocks=10] [bytes=1048576] [folder=.]: a recording, in turn with a loop of write(); each ends when the disk has it.
// recording paced=1 [seconds=10] ...: messages at 0.8 times the rate of such a loop of that length, with the recorder's usual limits; what is lost of
// them.
// recording publish=1 [reader=0|1] [messages=1000]: a publisher alone, or with a recorder that is too late for each message.
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/header.hpp>
#include <string>
#include <thread>

#include "nacelle/base/time.hpp"
#include "nacelle/io/descriptor.hpp"
#include "nacelle/runtime/broker.hpp"
#include "ratios/ratio.hpp"
#include "record/component/recording.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {
namespace {

using record::Recording;
using sensor_msgs::msg::Image;

constexpr std::size_t kFewWaiting = std::size_t{4} << 20U;

/// Nanoseconds of a recording of `count` messages; `mallocs`: those of the second half of them, before the end.
double record_once(const std::string& folder, const Image& image, std::uint64_t count, double& mallocs) {
  const SystemClock clock;
  const MonotonicTime begin = clock.now();
  // Nothing is lost: as write() does, it waits for the disk. Few bytes wait for it, as those of a robot, which is slower than its disk.
  auto made = Recording::begin({.folder = folder, .most_waiting = kFewWaiting, .keep_free = 0});
  if (!made) {
    std::fprintf(stderr, "%s\n", made.error().text().c_str());
    std::exit(1);
  }
  Recording& recording = **made;
  const auto topic = recording.add_topic("/image", Image::message_type(), {QoS(10)});
  Usage half{};
  for (std::uint64_t i = 0; i < count; ++i) {
    if (i == count / 2) half = Usage::now();
    recording.await_room(2 * image.data.size());
    recording.write(topic, &image, {1 + i, 1 + i});
  }
  const std::uint64_t second_half = count - count / 2;
  mallocs = static_cast<double>((Usage::now() - half).mallocs) / static_cast<double>(second_half);
  const bool is_complete = !recording.finish() && recording.messages() == count;
  const double passed = to_seconds(clock.now() - begin) * 1e9;
  std::filesystem::remove_all(folder);
  if (!is_complete) {
    std::fprintf(stderr, "%s: the recording is not complete\n", folder.c_str());
    std::exit(1);
  }
  return passed;
}

double write_plainly(const std::string& path, const Bytes& block, std::uint64_t count) {
  const SystemClock clock;
  const MonotonicTime begin = clock.now();
  const io::Descriptor file{::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
  for (std::uint64_t i = 0; i < count; ++i) {
    if (::write(file.number(), block.data(), block.size()) != static_cast<ssize_t>(block.size())) std::exit(1);
  }
  if (::fdatasync(file.number()) != 0) std::exit(1);
  const double passed = to_seconds(clock.now() - begin) * 1e9;
  std::filesystem::remove(path);
  return passed;
}

/// Bytes per second of a loop of write() that lasts as long, in files of 256 MiB, each of which ends when the disk has it. A loop that is shorter than
/// that finds the rate of the memory in front of the disk.
double rate_of(const std::string& path, const Bytes& block, Duration length) {
  constexpr std::uint64_t kBlocks = 256;
  double bytes = 0.0, ns = 0.0;
  while (ns < to_seconds(length) * 1e9) {
    ns += write_plainly(path, block, kBlocks);
    bytes += static_cast<double>(kBlocks * block.size());
  }
  return bytes / ns * 1e9;
}

/// Messages at a part of the disk's rate.
void record_paced(const std::string& folder, const Image& image, double bytes_per_s, Duration length) {
  const SystemClock clock;
  auto made = Recording::begin({.folder = folder, .keep_free = 0});
  if (!made) {
    std::fprintf(stderr, "%s\n", made.error().text().c_str());
    std::exit(1);
  }
  Recording& recording = **made;
  const auto topic = recording.add_topic("/image", Image::message_type(), {QoS(10)});
  const Duration step = from_seconds(static_cast<double>(image.data.size()) / bytes_per_s);
  const MonotonicTime begin = clock.now();
  std::uint64_t count = 0;
  for (MonotonicTime due = begin; due < begin + length; due += step, ++count) {
    if (const Duration wait = due - clock.now(); wait > Duration::zero()) std::this_thread::sleep_for(wait);
    recording.look_at_time(clock.now());
    recording.write(topic, &image, {1 + count, 1 + count});
  }
  const auto problem = recording.finish();
  if (problem) std::fprintf(stderr, "%s\n", problem->text().c_str());
  std::filesystem::remove_all(folder);
  print_figures({{"messages", static_cast<double>(count)},
                 {"lost", static_cast<double>(recording.topics()[topic].lost)},
                 {"mb_per_s", bytes_per_s * 1e-6}});
}

/// As the recorder's streams: it notes that something waits.
struct Noted final : ReadyListener {
  void on_ready() noexcept override { queued.exchange(true); }
  std::atomic<bool> queued{false};
};

/// What a publisher does for a recorder that takes nothing, so that each message also drops the oldest one.
void publish(std::uint64_t messages, bool has_reader) {
  using std_msgs::msg::Header;
  const SystemClock clock;
  runtime::Broker broker{clock, runtime::Watching::ByCaller};
  EndpointSpec spec;
  spec.topic = "/header";
  spec.type = &Header::message_type();
  spec.node = "/publisher";
  const auto writer = broker.create_writer(spec);
  Noted noted;
  EndpointSpec reads = spec;
  reads.qos = QoS(16).best_effort();
  std::unique_ptr<Reader> reader;
  if (has_reader) reader = broker.create_reader(reads, Taking::Share, &noted);
  for (std::uint64_t i = 0; i < messages; ++i) static_cast<void>(writer->publish(*writer->borrow()));
  print_figures({{"messages", static_cast<double>(messages)}});
}

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle;
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  if (arguments.number("publish", 0) != 0) {
    publish(arguments.number("messages", 1000), arguments.number("reader", 0) != 0);
    return 0;
  }
  const std::string folder = arguments.text("folder", ".") + "/nacelle-recording-benchmark";
  const std::uint64_t size = arguments.number("bytes", 1U << 20U);
  const std::uint64_t messages = (arguments.number("megabytes", 64) << 20U) / size;
  Image image;
  image.data.resize(size);
  const Bytes block(std::size_t{1} << 20U, 0x5A);
  if (arguments.number("paced", 0) != 0) {
    constexpr double kPart = 0.8;
    const Duration length = std::chrono::seconds(arguments.number("seconds", 10));
    record_paced(folder, image, kPart * rate_of(folder, block, length), length);
    return 0;
  }
  double mallocs = 0;
  const Ratio ratio = interleave(
      arguments.number("blocks", 10), [&] { return record_once(folder, image, messages, mallocs); },
      [&] { return write_plainly(folder, block, messages * size / block.size()); });
  print_figures({{"a_ns", ratio.a_ns},
                 {"b_ns", ratio.b_ns},
                 {"speed", ratio.b_ns / ratio.a_ns},
                 {"mallocs", mallocs},
                 {"mb_per_s", static_cast<double>(messages * size) / ratio.a_ns * 1e3}});
  return 0;
}
