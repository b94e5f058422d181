// SPDX-License-Identifier: Apache-2.0
// crossing [bytes=44] [blocks=40]
// An image from one participant to another over the loopback interface and back to the sender's notice: by two graphs with
// their mirrors (a), and by dds_write() and dds_take() of plain Cyclone (b), in turn in one process.
#include <dds/dds.h>

#include <cstdio>
#include <cstdlib>
#include <sensor_msgs/msg/image.hpp>
#include <thread>

#include "nacelle/runtime/broker.hpp"
#include "nacelle/transport_dds/mirror.hpp"
#include "ratios/ratio.hpp"
#include "ros_types.h"
#include "support/arguments.hpp"
#include "support/own_network.hpp"
#include "support/rig.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {
namespace {

using sensor_msgs::msg::Image;
using Sample = sensor_msgs_msg_dds__Image_;

constexpr std::size_t kRounds = 100;  // per block
constexpr std::string_view kConfig =
    R"(<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces><MaxMessageSize>65500B</MaxMessageSize>)"
    R"(<FragmentSize>65000B</FragmentSize></General><Discovery><ExternalDomainId>7</ExternalDomainId></Discovery>)";

int must(int made) {
  if (made < 0) std::fprintf(stderr, "%s\n", dds_strretcode(made)), std::exit(1);
  return made;
}

/// Median nanoseconds from sending to the reader's having taken it; each is sent when the one before has been taken.
template <typename Send, typename Take>
double block(const Clock& clock, Event& arrived, Send send, Take take) {
  std::vector<std::int64_t> times;
  for (std::size_t i = 0; i < kRounds; ++i) {
    const MonotonicTime sent = clock.now();
    send();
    arrived.wait();
    arrived.clear();
    while (!take()) std::this_thread::yield();
    times.push_back((clock.now() - sent).count());
  }
  return static_cast<double>(median(times));
}

class Mirrored {
 public:
  explicit Mirrored(std::size_t bytes) : bytes_(bytes) {
    for (std::size_t i = 0; i < 2; ++i) {
      MirrorOptions options;
      options.domain_id = static_cast<std::uint32_t>(100 + i);
      options.config = kConfig;
      auto made = DdsMirror::start(brokers_[i], clock_, options);
      if (!made) std::fprintf(stderr, "%s\n", made.error().text().c_str()), std::exit(1);
      mirrors_[i] = std::move(*made);
    }
    writer_ = brokers_[0].create_writer({"/mirrored", &Image::message_type(), QoS(10), "/talker"});
    reader_ =
        brokers_[1].create_reader({"/mirrored", &Image::message_type(), QoS(10), "/listener"}, Taking::Share, &ready_);
    while (writer_->reader_count() == 0 || reader_->writer_count() == 0) std::this_thread::yield();
  }
  double operator()() {
    return block(
        clock_, ready_.arrived,
        [this] {
          Block* const message = writer_->borrow();
          static_cast<Image*>(message->message)->data.resize(bytes_);
          writer_->publish(*message);
        },
        [this] {
          Block* const message = reader_->take();
          if (message != nullptr) drop_reference(*message);
          return message != nullptr;
        });
  }
  [[nodiscard]] MirrorStats sent() const { return mirrors_[0]->stats(); }

 private:
  struct Ready final : ReadyListener {
    void on_ready() noexcept override { arrived.set(); }
    Event arrived;
  };
  const std::size_t bytes_;
  const SystemClock clock_;
  Ready ready_;
  runtime::Broker brokers_[2]{runtime::Broker{clock_, runtime::Watching::ByThread},
                              runtime::Broker{clock_, runtime::Watching::ByThread}};
  std::unique_ptr<DdsMirror> mirrors_[2];
  std::unique_ptr<Writer> writer_;
  std::unique_ptr<Reader> reader_;
};

class Bare {
 public:
  explicit Bare(std::size_t bytes) : data_(bytes) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    dds_listener_t* const listener = dds_create_listener(&arrived_);
    dds_lset_data_available(listener, [](dds_entity_t, void* arrived) { static_cast<Event*>(arrived)->set(); });
    for (std::uint32_t i = 0; i < 2; ++i) {
      must(dds_create_domain(200 + i, std::string(kConfig).c_str()));
      const int participant = must(dds_create_participant(200 + i, nullptr, nullptr));
      const int topic =
          must(dds_create_topic(participant, &sensor_msgs_msg_dds__Image__desc, "rt/bare", nullptr, nullptr));
      (i == 0 ? writer_ : reader_) = must(i == 0 ? dds_create_writer(participant, topic, qos, nullptr)
                                                 : dds_create_reader(participant, topic, qos, listener));
    }
    dds_delete_listener(listener);
    dds_delete_qos(qos);
    dds_publication_matched_status_t writers{};
    dds_subscription_matched_status_t readers{};
    while (writers.current_count + readers.current_count < 2) {
      std::this_thread::yield();
      dds_get_publication_matched_status(writer_, &writers);
      dds_get_subscription_matched_status(reader_, &readers);
    }
  }
  double operator()() {
    return block(
        clock_, arrived_,
        [this] {
          Sample sample{};
          sample.header.frame_id = sample.encoding = const_cast<char*>("");
          sample.data._length = sample.data._maximum = static_cast<std::uint32_t>(data_.size());
          sample.data._buffer = data_.data();
          must(dds_write(writer_, &sample));
        },
        [this] {
          void* sample = nullptr;
          dds_sample_info_t info{};
          if (must(dds_take(reader_, &sample, &info, 1, 1)) == 0) return false;
          dds_return_loan(reader_, &sample, 1);
          return true;
        });
  }

 private:
  std::vector<std::uint8_t> data_;
  const SystemClock clock_;
  Event arrived_;
  int writer_ = 0, reader_ = 0;
};

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle::bench;
  static_cast<void>(nacelle::test::enter_own_network());
  const Arguments arguments(count, words);
  const std::size_t bytes = arguments.number("bytes", 44);
  Mirrored mirrored(bytes);
  Bare bare(bytes);
  const Ratio ratio = interleave(arguments.number("blocks", 40), std::ref(mirrored), std::ref(bare));
  const nacelle::MirrorStats sent = mirrored.sent();
  const double messages = static_cast<double>((arguments.number("blocks", 40) + 1) * kRounds);
  print_figures({{"a_ns", ratio.a_ns},
                 {"b_ns", ratio.b_ns},
                 {"ratio", ratio.value()},
                 {"encoded_per_message", static_cast<double>(sent.encoded) / messages}});
  return 0;
}
