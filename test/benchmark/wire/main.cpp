// SPDX-License-Identifier: Apache-2.0
// wire mirror=0|1 [bytes=0] [messages=1000]
//
// Publishes to a reader in this process, with and without the network's mirror, which has no remote reader.
#include <nacelle_bench_msgs/msg/stamped9_float32.hpp>
#include <sensor_msgs/msg/image.hpp>

#include "nacelle/runtime/broker.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"
#include "wire/lonely_mirror.hpp"

namespace nacelle::bench {
namespace {

template <typename T>
void fill(T& message, std::uint64_t bytes) {
  if constexpr (requires { message.step; }) message.data.resize(bytes);
}

template <typename T>
int run(const Arguments& arguments) {
  const std::uint64_t messages = arguments.number("messages", 1000), bytes = arguments.number("bytes", 0);
  const SystemClock clock;
  runtime::Broker broker{clock, runtime::Watching::ByThread};
  const auto writer = broker.create_writer({"/stream", &T::message_type(), QoS(10), "/talker"});
  const auto reader =
      broker.create_reader({"/stream", &T::message_type(), QoS(10), "/listener"}, Taking::Share, nullptr);
  std::unique_ptr<DdsMirror> mirror;
  if (arguments.number("mirror", 0) != 0) mirror = start_lonely_mirror(broker, clock);
  const Usage before = Usage::now();
  std::uint64_t delivered = 0;
  for (std::uint64_t i = 0; i < messages; ++i) {
    Block* const block = writer->borrow();
    fill(*static_cast<T*>(block->message), bytes);
    writer->publish(*block);
    while (Block* const got = reader->take()) drop_reference(*got), ++delivered;
  }
  const Usage used = Usage::now() - before;
  const MirrorStats stats = mirror ? mirror->stats() : MirrorStats{};
  print_figures({{"delivered", static_cast<double>(delivered)},
                 {"mallocs", static_cast<double>(used.mallocs)},
                 {"ns", static_cast<double>(used.at.nanoseconds())},
                 {"encoded", static_cast<double>(stats.encoded)},
                 {"taps", static_cast<double>(stats.taps)}});
  return 0;
}

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle;
  const bench::Arguments arguments(count, words);
  return arguments.number("bytes", 0) == 0 ? bench::run<nacelle_bench_msgs::msg::Stamped9Float32>(arguments)
                                           : bench::run<sensor_msgs::msg::Image>(arguments);
}
