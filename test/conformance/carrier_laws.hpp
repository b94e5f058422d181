// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "carrier_ends.hpp"

namespace nacelle::test {

/// What every carrier promises (carrier.hpp). A fixture answers `Carrier& carrier()`, or skips in SetUp().
template <typename Fixture>
class CarrierLaws : public Fixture {
 protected:
  CarriedStream text_stream(const std::string& name = "/chatter", std::size_t depth = 16) {
    return {name, &std_msgs::msg::String::message_type(), depth};
  }
  CarriedStream image_stream(const std::string& name = "/image", std::size_t depth = 4) {
    return {name, &sensor_msgs::msg::Image::message_type(), depth};
  }
};
TYPED_TEST_SUITE_P(CarrierLaws);

TYPED_TEST_P(CarrierLaws, a_stream_is_connected_once_both_ends_are_there_in_either_order) {
  Carrier& carrier = this->carrier();
  KeepingSink sink(std_msgs::msg::String::message_type());

  const auto writer = carrier.create_writer(this->text_stream("/first"));
  ASSERT_NE(writer, nullptr);
  EXPECT_FALSE(writer->is_connected());
  const auto reader = carrier.create_reader(this->text_stream("/first"), sink);
  const auto second_reader = carrier.create_reader(this->text_stream("/second"), sink);
  const auto second_writer = carrier.create_writer(this->text_stream("/second"));

  EXPECT_TRUE(writer->is_connected());
  EXPECT_TRUE(second_writer->is_connected());
}

TYPED_TEST_P(CarrierLaws, every_message_arrives_once_in_order_as_it_was_stamped) {
  constexpr std::size_t kMessages = 1000, kDepth = 16;
  KeepingSink sink(std_msgs::msg::String::message_type());
  const auto writer = this->carrier().create_writer(this->text_stream());
  const auto reader = this->carrier().create_reader(this->text_stream("/chatter", kDepth), sink);
  Sender<std_msgs::msg::String> sender(*writer);

  for (std::size_t i = 1; i <= kMessages; ++i) {
    ASSERT_EQ(sender.send(text_of(i)), CarrierWriter::Sent::Yes);
    if (i % kDepth == 0) static_cast<void>(sink.wait_for(i));
  }

  const auto arrived = sink.wait_for(kMessages);
  ASSERT_EQ(arrived.size(), kMessages);
  for (std::size_t i = 1; i <= kMessages; ++i) {
    EXPECT_EQ(message_in<std_msgs::msg::String>(arrived[i - 1]).data, text_of(i).data);
    EXPECT_EQ(arrived[i - 1].info.sequence, i);
    EXPECT_EQ(arrived[i - 1].info.writer_id, 7U);
    EXPECT_EQ(arrived[i - 1].info.source_time.nanoseconds(), 1000 + static_cast<std::int64_t>(i));
    EXPECT_EQ(arrived[i - 1].block->expires.nanoseconds(), 9000 + static_cast<std::int64_t>(i));
  }
}

TYPED_TEST_P(CarrierLaws, a_large_message_arrives_as_it_was_written) {
  KeepingSink sink(sensor_msgs::msg::Image::message_type());
  const auto writer = this->carrier().create_writer(this->image_stream());
  const auto reader = this->carrier().create_reader(this->image_stream(), sink);
  Sender<sensor_msgs::msg::Image> sender(*writer);
  std::size_t sent = 0;

  for (const std::size_t bytes : {0U, 1U, 4095U, 4096U, 4097U, 100'000U, 1'000'000U}) {
    const auto image = image_of(bytes, 3);
    ASSERT_EQ(sender.send(image), CarrierWriter::Sent::Yes);
    const auto arrived = sink.wait_for(++sent);
    EXPECT_EQ(message_in<sensor_msgs::msg::Image>(arrived.back()), image) << bytes;
  }
}

TYPED_TEST_P(CarrierLaws, drain_has_delivered_what_was_sent_before_it) {
  KeepingSink sink(std_msgs::msg::String::message_type());
  const auto writer = this->carrier().create_writer(this->text_stream());
  const auto reader = this->carrier().create_reader(this->text_stream(), sink);
  Sender<std_msgs::msg::String> sender(*writer);

  for (std::size_t round = 1; round <= 200; ++round) {
    for (std::size_t i = 0; i < 8; ++i) ASSERT_EQ(sender.send(text_of(i)), CarrierWriter::Sent::Yes);
    reader->drain();
    ASSERT_EQ(sink.count(), round * 8);
  }
}

TYPED_TEST_P(CarrierLaws, a_reader_that_is_gone_calls_its_sink_no_more) {
  KeepingSink sink(std_msgs::msg::String::message_type());
  const auto writer = this->carrier().create_writer(this->text_stream());
  auto reader = this->carrier().create_reader(this->text_stream(), sink);
  Sender<std_msgs::msg::String> sender(*writer);
  for (std::size_t i = 0; i < 8; ++i) ASSERT_EQ(sender.send(text_of(i)), CarrierWriter::Sent::Yes);

  reader.reset();
  const std::size_t before = sink.count();
  for (std::size_t i = 0; i < 100; ++i) static_cast<void>(sender.send(text_of(i)));

  EXPECT_EQ(sink.count(), before);
}

TYPED_TEST_P(CarrierLaws, messages_outlive_the_reader_the_writer_and_the_next_messages) {
  KeepingSink sink(sensor_msgs::msg::Image::message_type());
  auto writer = this->carrier().create_writer(this->image_stream());
  auto reader = this->carrier().create_reader(this->image_stream(), sink);
  auto sender = std::make_unique<Sender<sensor_msgs::msg::Image>>(*writer);
  ASSERT_EQ(sender->send(image_of(50'000, 1)), CarrierWriter::Sent::Yes);
  ASSERT_EQ(sender->send(image_of(50'000, 2)), CarrierWriter::Sent::Yes);
  const auto arrived = sink.wait_for(2);

  sender.reset();
  writer.reset();
  reader.reset();
  const auto other_writer = this->carrier().create_writer(this->image_stream("/other"));
  KeepingSink other_sink(sensor_msgs::msg::Image::message_type());
  const auto other_reader = this->carrier().create_reader(this->image_stream("/other"), other_sink);
  Sender<sensor_msgs::msg::Image> other(*other_writer);
  for (std::uint8_t i = 0; i < 4; ++i) ASSERT_EQ(other.send(image_of(50'000, 9)), CarrierWriter::Sent::Yes);
  static_cast<void>(other_sink.wait_for(4));

  EXPECT_EQ(message_in<sensor_msgs::msg::Image>(arrived[0]), image_of(50'000, 1));
  EXPECT_EQ(message_in<sensor_msgs::msg::Image>(arrived[1]), image_of(50'000, 2));
}

TYPED_TEST_P(CarrierLaws, streams_whose_long_names_begin_or_end_alike_stay_apart) {
  const std::string shared(150, 'a');
  KeepingSink first(std_msgs::msg::String::message_type()), second(std_msgs::msg::String::message_type());
  const auto writer = this->carrier().create_writer(this->text_stream("/x" + shared));
  const auto reader = this->carrier().create_reader(this->text_stream("/x" + shared), first);
  const auto same_end = this->carrier().create_reader(this->text_stream("/y" + shared), second);
  const auto same_begin = this->carrier().create_reader(this->text_stream("/x" + shared + "a"), second);
  Sender<std_msgs::msg::String> sender(*writer);

  ASSERT_EQ(sender.send(text_of(1)), CarrierWriter::Sent::Yes);
  static_cast<void>(first.wait_for(1));
  same_end->drain();
  same_begin->drain();

  EXPECT_EQ(second.count(), 0U);
}

TYPED_TEST_P(CarrierLaws, a_stream_of_another_type_is_another_stream) {
  KeepingSink sink(sensor_msgs::msg::Image::message_type());
  const auto writer = this->carrier().create_writer(this->text_stream("/one"));
  const auto reader = this->carrier().create_reader(this->image_stream("/one"), sink);

  EXPECT_FALSE(writer->is_connected());
}

TYPED_TEST_P(CarrierLaws, a_sink_without_an_envelope_loses_that_message_only) {
  KeepingSink sink(std_msgs::msg::String::message_type());
  const auto writer = this->carrier().create_writer(this->text_stream());
  const auto reader = this->carrier().create_reader(this->text_stream(), sink);
  Sender<std_msgs::msg::String> sender(*writer);

  sink.set_refuses(true);
  ASSERT_EQ(sender.send(text_of(1)), CarrierWriter::Sent::Yes);
  reader->drain();
  sink.set_refuses(false);
  ASSERT_EQ(sender.send(text_of(2)), CarrierWriter::Sent::Yes);

  EXPECT_EQ(message_in<std_msgs::msg::String>(sink.wait_for(1).front()).data, text_of(2).data);
}

TYPED_TEST_P(CarrierLaws, two_readers_of_one_writer_both_get_everything) {
  KeepingSink one(sensor_msgs::msg::Image::message_type()), two(sensor_msgs::msg::Image::message_type());
  const auto writer = this->carrier().create_writer(this->image_stream());
  const auto first = this->carrier().create_reader(this->image_stream(), one);
  const auto second = this->carrier().create_reader(this->image_stream(), two);
  Sender<sensor_msgs::msg::Image> sender(*writer);

  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_EQ(sender.send(image_of(20'000, i)), CarrierWriter::Sent::Yes);

  for (KeepingSink* sink : {&one, &two}) {
    const auto arrived = sink->wait_for(3);
    for (std::uint8_t i = 0; i < 3; ++i)
      EXPECT_EQ(message_in<sensor_msgs::msg::Image>(arrived[i]), image_of(20'000, i));
  }
}

REGISTER_TYPED_TEST_SUITE_P(CarrierLaws, a_stream_is_connected_once_both_ends_are_there_in_either_order,
                            every_message_arrives_once_in_order_as_it_was_stamped,
                            a_large_message_arrives_as_it_was_written, drain_has_delivered_what_was_sent_before_it,
                            a_reader_that_is_gone_calls_its_sink_no_more,
                            messages_outlive_the_reader_the_writer_and_the_next_messages,
                            streams_whose_long_names_begin_or_end_alike_stay_apart,
                            a_stream_of_another_type_is_another_stream,
                            a_sink_without_an_envelope_loses_that_message_only,
                            two_readers_of_one_writer_both_get_everything);

}  // namespace nacelle::test
