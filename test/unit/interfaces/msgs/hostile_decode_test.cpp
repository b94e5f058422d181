// SPDX-License-Identifier: Apache-2.0
#include "counting_allocator.hpp"
#include "msgs_test_support.hpp"

#include <my_robot_msgs/msg/shape.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <random>
#include <sensor_msgs/msg/image.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

namespace nacelle {
namespace {

constexpr std::size_t kBytesPerByte = 64;
constexpr std::size_t kBytesAtLeast = 4096;

/// Decodes from a heap block of exactly that size, so that an address sanitizer sees the first byte read too many, and
/// asserts what every decoding owes. Answers whether it succeeded.
bool decode_safely(const msgs::MessageType& type, ByteView bytes, const std::string& what) {
  const std::unique_ptr<std::uint8_t[]> exact{new std::uint8_t[bytes.size()]};
  std::copy(bytes.begin(), bytes.end(), exact.get());
  msgs::AnyMessage message{type};

  const auto before = test::allocated();
  const auto decoded = type.decode({exact.get(), bytes.size()}, message.get());
  const auto taken = test::allocated().bytes - before.bytes;

  EXPECT_LE(taken, kBytesPerByte * bytes.size() + kBytesAtLeast) << type.name << ", " << what;
  if (!decoded) return false;
  // What was accepted is a message like any other: it can be written and read again, and is the same then.
  const Bytes again = message.encoded();
  msgs::AnyMessage second{type};
  EXPECT_TRUE(type.decode(again, second.get())) << type.name << ", " << what;
  EXPECT_EQ(to_hex(second.encoded()), to_hex(again)) << type.name << ", " << what;
  return true;
}

std::vector<const msgs::MessageType*> every_type() {
  std::vector<const msgs::MessageType*> types;
  for (const auto& package : test::type_library().packages()) {
    for (const auto function : test::type_library().package(package).value()->messages) types.push_back(&function());
  }
  return types;
}

TEST(HostileDecode, of_a_golden_message_cut_short_anywhere_fails) {
  for (const auto& vector : test::golden_vectors()) {
    const auto& type = test::message_type(vector.type);
    for (std::size_t length = 0; length < vector.bytes.size(); ++length) {
      EXPECT_FALSE(decode_safely(type, ByteView{vector.bytes}.first(length), "cut to " + std::to_string(length)));
    }
  }
}

TEST(HostileDecode, of_a_golden_message_with_changed_bytes_is_harmless) {
  constexpr unsigned kSeed = 20261121;
  std::mt19937 random{kSeed};
  for (const auto& vector : test::golden_vectors()) {
    const auto& type = test::message_type(vector.type);
    for (int round = 0; round < 40; ++round) {
      Bytes bytes = vector.bytes;
      const int changes = 1 + static_cast<int>(random() % 4);
      for (int i = 0; i < changes; ++i) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
      decode_safely(type, bytes, "seed " + std::to_string(kSeed) + " round " + std::to_string(round));
    }
  }
}

TEST(HostileDecode, of_a_huge_number_anywhere_is_harmless) {
  for (const auto& vector : test::golden_vectors()) {
    const auto& type = test::message_type(vector.type);
    for (std::size_t at = msgs::kEncapsulationSize; at + 4 <= vector.bytes.size(); at += 4) {
      for (const std::uint32_t number : {0xFFFFFFFFU, 0x7FFFFFFFU, 0x40000000U, 0x01000000U, 0x00010000U}) {
        Bytes bytes = vector.bytes;
        std::memcpy(bytes.data() + at, &number, sizeof number);
        decode_safely(type, bytes, "number at " + std::to_string(at));
      }
    }
  }
}

TEST(HostileDecode, of_noise_is_harmless_for_every_type) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random{kSeed};
  const auto types = every_type();
  ASSERT_GT(types.size(), 600U);
  for (const auto* type : types) {
    for (const std::size_t length : {0U, 1U, 3U, 4U, 5U, 8U, 64U, 300U, 2000U}) {
      // Small numbers make believable counts, so that decoding gets further than the first sequence.
      for (const unsigned most : {2U, 8U, 256U}) {
        Bytes bytes(length);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() % 3 == 0 ? random() % most : 0);
        for (std::size_t i = 0; i < std::min<std::size_t>(length, 4); ++i) bytes[i] = i == 1 ? random() % 2 : 0;
        decode_safely(*type, bytes, "seed " + std::to_string(kSeed) + ", " + std::to_string(length) + " bytes");
      }
    }
  }
}

TEST(HostileDecode, of_zeroes_succeeds_for_every_type_once_they_are_enough) {
  for (const auto* type : every_type()) {
    bool succeeded = false;
    const Bytes zeroes(8192, 0);
    std::size_t length = msgs::kEncapsulationSize;
    while (!succeeded && length < zeroes.size())
      succeeded = decode_safely(*type, ByteView{zeroes}.first(++length), "zeroes");
    EXPECT_GE(length - msgs::kEncapsulationSize, type->least_encoded_size) << type->name;
    EXPECT_TRUE(succeeded) << type->name;
  }
}

TEST(HostileDecode, does_not_pay_for_long_defaults_of_many_elements) {
  // A Label is 8 bytes on the wire at least, and its defaults take hundreds on the heap.
  my_robot_msgs::msg::Shape shape;
  shape.labels.resize(1000);
  for (auto& label : shape.labels) {
    label.text.clear();
    label.weights.clear();
  }

  EXPECT_TRUE(decode_safely(my_robot_msgs::msg::Shape::message_type(), msgs::to_cdr(shape), "1000 empty labels"));
}

TEST(HostileDecode, refuses_a_count_before_it_takes_memory) {
  // An Image whose data announces four billion bytes and has one.
  sensor_msgs::msg::Image image;
  image.data = {1};
  Bytes bytes = msgs::to_cdr(image);
  std::fill(bytes.end() - 5, bytes.end() - 1, std::uint8_t{0xFF});
  sensor_msgs::msg::Image out;

  const auto before = test::allocated();
  const auto decoded = msgs::from_cdr(bytes, out);

  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error(), msgs::DecodeFault::ImpossibleCount);
  EXPECT_EQ(test::allocated().calls, before.calls);
}

TEST(Decode, into_a_used_message_takes_no_memory) {
  for (const auto& vector : test::golden_vectors()) {
    const auto& type = test::message_type(vector.type);
    msgs::AnyMessage message{type};
    ASSERT_TRUE(type.decode(vector.bytes, message.get()));

    const auto before = test::allocated();
    ASSERT_TRUE(type.decode(vector.bytes, message.get()));
    EXPECT_EQ(test::allocated().calls, before.calls) << vector.type << " " << vector.sample;
  }
}

TEST(Encode, takes_no_memory) {
  for (const auto& vector : test::golden_vectors()) {
    const auto& type = test::message_type(vector.type);
    msgs::AnyMessage message{type};
    ASSERT_TRUE(type.decode(vector.bytes, message.get()));
    Bytes bytes(vector.bytes.size());

    const auto before = test::allocated();
    EXPECT_EQ(type.encoded_size(message.get()), bytes.size());
    type.encode(message.get(), bytes.data());
    EXPECT_EQ(test::allocated().calls, before.calls) << vector.type << " " << vector.sample;
  }
}

}  // namespace
}  // namespace nacelle
