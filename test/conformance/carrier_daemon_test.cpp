// SPDX-License-Identifier: Apache-2.0
// What happens to a process when iceoryx's daemon is not there, ends, comes back, or stops answering; and streams between
// processes. Each process is a child of its own, since iceoryx can be started once in a process only.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <std_msgs/msg/string.hpp>
#include <thread>

#include "carrier_ends.hpp"
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#include "support/child_process.hpp"
#include "support/linked_brokers.hpp"
#include "support/places.hpp"
#include "support/roudi.hpp"

namespace nacelle::test {
namespace {

using sensor_msgs::msg::Image;
using transport_iceoryx::IceoryxCarrier;
using Sent = CarrierWriter::Sent;

const CarriedStream kImages{"/image", &Image::message_type(), 4};

bool has_thread(const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "comm");
    std::string comm;
    if (std::getline(file, comm) && comm == name) return true;
  }
  return false;
}

class IceoryxDaemon : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string why_not;
    roudi_ = RouDi::start(small_pools(), why_not);
    if (!roudi_) GTEST_SKIP() << "SKIPPED, NOTHING WAS TESTED: " << why_not;
  }
  static std::unique_ptr<IceoryxCarrier> started() {
    auto carrier = IceoryxCarrier::start();
    EXPECT_TRUE(carrier) << carrier.error().text();
    return carrier ? std::move(carrier).value() : nullptr;
  }
  static void wait_for_loss(const Carrier& carrier) {
    while (carrier.is_alive()) std::this_thread::yield();
  }
  std::unique_ptr<RouDi> roudi_;
};

TEST_F(IceoryxDaemon, without_one_starting_is_a_problem_with_a_way_out_and_works_when_there_is_one) {
  roudi_->kill();
  EXPECT_EQ(0, run_in_child([this] {
              auto none = IceoryxCarrier::start();
              ASSERT_FALSE(none);
              EXPECT_NE(none.error().text().find("iox-roudi"), std::string::npos) << none.error().text();

              roudi_->start_again();

              EXPECT_TRUE(started()) << "nothing was begun that must be restarted";
            }));
}

TEST_F(IceoryxDaemon, whose_process_ends_is_lost_for_good_and_messages_stay_readable) {
  EXPECT_EQ(0, run_in_child([this] {
              const auto carrier = started();
              KeepingSink sink(Image::message_type());
              const auto writer = carrier->create_writer(kImages);
              const auto reader = carrier->create_reader(kImages, sink);
              Sender<Image> sender(*writer);
              ASSERT_EQ(sender.send(image_of(30'000, 1)), Sent::Yes);
              const auto arrived = sink.wait_for(1);

              roudi_->kill();
              wait_for_loss(*carrier);

              EXPECT_EQ(sender.send(image_of(30'000, 2)), Sent::Dead);
              EXPECT_FALSE(writer->is_connected());
              EXPECT_EQ(message_in<Image>(arrived[0]), image_of(30'000, 1));
              EXPECT_EQ(carrier->create_writer({"/new", &Image::message_type(), 4}), nullptr);
              EXPECT_EQ(carrier->create_reader({"/new", &Image::message_type(), 4}, sink), nullptr);
              EXPECT_FALSE(IceoryxCarrier::start());

              roudi_->start_again();

              EXPECT_FALSE(carrier->is_alive()) << "another daemon knows nothing of this process";
              EXPECT_EQ(sender.send(image_of(30'000, 2)), Sent::Dead);
              EXPECT_FALSE(IceoryxCarrier::start());
              EXPECT_EQ(0, ::access("/tmp/roudi", F_OK));
            }));
}

TEST_F(IceoryxDaemon, that_is_lost_leaves_streams_to_the_socket_and_no_message_is_missing) {
  EXPECT_EQ(0, run_in_child([this] {
              const auto carrier = started();
              const SystemClock clock;
              LinkedBrokers both{clock, carrier.get()};
              const EndpointSpec spec{"/chat", &std_msgs::msg::String::message_type(), QoS(10), "/node"};
              auto reader = both.create_reader(spec, Taking::Share, nullptr);
              auto writer = both.create_writer(spec);
              std::uint64_t sequence = 0;
              const auto pass_one = [&] {
                writer->publish(*writer->borrow());
                Block* const arrived = reader->take();
                ASSERT_NE(arrived, nullptr);
                EXPECT_EQ(arrived->info.sequence, ++sequence);
                drop_reference(*arrived);
              };
              for (int i = 0; i < 5; ++i) pass_one();
              EXPECT_EQ(both.writers_link().stats().carried, 4U);
              const std::uint64_t by_socket = both.writers_link().stats().sent;
              roudi_->kill();
              wait_for_loss(*carrier);
              for (int i = 0; i < 5; ++i) pass_one();
              EXPECT_EQ(both.writers_link().stats().carried, 4U);
              EXPECT_EQ(both.writers_link().stats().sent, by_socket + 5);
            }));
}

TEST_F(IceoryxDaemon, whose_loss_is_reported_once) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(0, run_in_child([this] {
              const auto carrier = started();
              KeepingSink sink(Image::message_type());
              const auto writer = carrier->create_writer(kImages);
              const auto reader = carrier->create_reader(kImages, sink);
              roudi_->kill();
              wait_for_loss(*carrier);
              // The thread that would go on greeting the daemon, and complain each time, is ended.
              while (has_thread("KeepAlive")) std::this_thread::yield();
              for (int i = 0; i < 10; ++i)
                EXPECT_EQ(carrier->create_writer({"/new", &Image::message_type(), 4}), nullptr);
            }));
  const std::string said = ::testing::internal::GetCapturedStderr();
  std::size_t times = 0;
  for (std::size_t at = 0; (at = said.find("daemon is lost", at)) != std::string::npos; ++at) ++times;
  EXPECT_EQ(times, 1U) << said;
  EXPECT_EQ(said.find("/new"), std::string::npos) << said;
  EXPECT_EQ(said.find("unix_domain_socket"), said.rfind("unix_domain_socket"))
      << "but for iceoryx's farewell: " << said;
}

TEST_F(IceoryxDaemon, that_lives_and_does_not_answer_is_a_problem_after_the_patience) {
  roudi_->stop_answering();
  EXPECT_EQ(0, run_in_child([] {
              const auto none = IceoryxCarrier::start(std::chrono::milliseconds(200));
              ASSERT_FALSE(none);
              EXPECT_NE(none.error().text().find("not answered within 200 ms"), std::string::npos)
                  << none.error().text();
              EXPECT_FALSE(IceoryxCarrier::start()) << "and stays one";
            }));
}

TEST_F(IceoryxDaemon, that_stops_answering_makes_no_stream_and_is_lost) {
  EXPECT_EQ(0, run_in_child([this] {
              auto begun = IceoryxCarrier::start(std::chrono::milliseconds(300));
              ASSERT_TRUE(begun) << begun.error().text();
              const auto carrier = std::move(begun).value();
              roudi_->stop_answering();

              EXPECT_EQ(carrier->create_writer(kImages), nullptr);
              EXPECT_FALSE(carrier->is_alive());
              std::_Exit(::testing::Test::HasFailure() ? 1 : 0);  // iceoryx's own farewell would wait for the answer
            }));
}

TEST_F(IceoryxDaemon, carries_images_between_two_processes_and_none_is_lost_when_one_is_killed) {
  constexpr std::size_t kImagesSent = 200;
  int to_writer[2], to_reader[2];
  ASSERT_EQ(0, ::pipe(to_writer));
  ASSERT_EQ(0, ::pipe(to_reader));
  const auto reader_process = [&] {
    const auto carrier = started();
    KeepingSink sink(Image::message_type());
    const auto reader = carrier->create_reader(kImages, sink);
    for (std::size_t i = 0; i < kImagesSent; ++i) {
      const char go = 'g';
      ASSERT_EQ(1, ::write(to_writer[1], &go, 1));  // one at a time
      const auto arrived = sink.wait_for(1);
      ASSERT_EQ(message_in<Image>(arrived[0]), image_of(60'000 + i, static_cast<std::uint8_t>(i)));
      ASSERT_EQ(arrived[0].info.sequence, i + 1);
      sink.let_go();
    }
    EXPECT_EQ(carrier->reading().bytes_copied, 0U);
  };
  const auto writer_process = [&] {
    const auto carrier = started();
    const auto writer = carrier->create_writer(kImages);
    Sender<Image> sender(*writer);
    char go = 0;
    for (std::size_t i = 0; i < kImagesSent; ++i) {
      ASSERT_EQ(1, ::read(to_writer[0], &go, 1));
      ASSERT_TRUE(writer->is_connected());
      ASSERT_EQ(sender.send(image_of(60'000 + i, static_cast<std::uint8_t>(i))), Sent::Yes);
    }
    ::kill(::getpid(), SIGKILL);  // the reader gets the last one all the same
  };
  EXPECT_EQ(0, run_in_child([&] {
              // A child of the child: both have the pipes and neither had a thread.
              const pid_t writer = ::fork();
              if (writer == 0) {
                writer_process();
                std::_Exit(1);
              }
              reader_process();
              EXPECT_EQ(writer, ::waitpid(writer, nullptr, 0));
            }));
}

// The daemon as docs/between_processes.md configures it, for "one 640 x 480 rgb8 image".
TEST(IceoryxDaemonsPage, shows_pools_that_hold_an_image_of_the_camera) {
  std::ifstream file{test::source("docs/between_processes.md")};
  const std::string page{std::istreambuf_iterator<char>{file}, {}};
  constexpr std::string_view kFence = "\n```toml\n";
  const std::size_t begin = page.find(kFence) + kFence.size();
  std::string why_not;
  const auto roudi = RouDi::start_configured(page.substr(begin, page.find("```", begin) - begin), why_not);
  if (!roudi) {
    EXPECT_EQ(RouDi::start(small_pools(), why_not), nullptr) << "it starts with other pools than the page's";
    GTEST_SKIP() << "SKIPPED, NOTHING WAS TESTED: " << why_not;
  }

  EXPECT_EQ(0, run_in_child([] {
              const auto carrier = IceoryxCarrier::start();
              ASSERT_TRUE(carrier) << carrier.error().text();
              const auto writer = carrier.value()->create_writer(kImages);
              KeepingSink sink(Image::message_type());
              const auto reader = carrier.value()->create_reader(kImages, sink);
              const Image image = image_of(921'600, 1);
              ASSERT_EQ(Sender<Image>(*writer).send(image), Sent::Yes);
              EXPECT_EQ(message_in<Image>(sink.wait_for(1)[0]), image);
            }));
}

}  // namespace
}  // namespace nacelle::test
