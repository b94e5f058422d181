// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/cdr_apart.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>

#include "nacelle/msgs/message_type.hpp"

namespace {

using namespace nacelle;
using namespace nacelle::msgs;
using sensor_msgs::msg::Image;

Image image_of(std::size_t bytes) {
  Image image;
  image.header.frame_id = "camera";
  image.height = 3;
  image.encoding = "mono8";
  image.data.resize(bytes);
  std::iota(image.data.begin(), image.data.end(), std::uint8_t{1});
  return image;
}

struct Apart {
  explicit Apart(const Image& image) : small(encoded_size_apart(Image::message_type(), &image, parts)) {
    encode_apart(Image::message_type(), &image, small.data());
  }
  PartList parts;
  Bytes small;
};

/// Counts how often memory is given back.
ReleaseHook counting(int& count) {
  return {[](void* context) noexcept { ++*static_cast<int*>(context); }, &count};
}

Result<void, DecodeFault> read(const Apart& apart, std::span<LentPart> lent, Image& into) {
  return decode_apart(Image::message_type(), apart.small, lent, &into);
}

TEST(CdrApart, a_short_sequence_stays_among_the_other_bytes) {
  const Image image = image_of(kLeastPartBytes - 1);

  const Apart apart{image};

  EXPECT_EQ(apart.parts.count, 0U);
  EXPECT_EQ(apart.small, to_cdr(image)) << "without parts it is plain CDR";
}

TEST(CdrApart, a_long_sequence_is_listed_and_only_its_count_is_written) {
  const Image image = image_of(kLeastPartBytes);

  const Apart apart{image};

  ASSERT_EQ(apart.parts.count, 1U);
  EXPECT_EQ(apart.parts.parts[0].numbers, image.data.data());
  EXPECT_EQ(apart.parts.parts[0].bytes, image.data.size());
  EXPECT_EQ(apart.small.size() + image.data.size(), encoded_size(Image::message_type(), &image));
}

TEST(CdrApart, what_is_lent_is_read_where_it_lies_until_the_message_gives_it_back) {
  Image image = image_of(10'000);
  const Apart apart{image};
  int given_back = 0;
  LentPart lent{image.data.data(), image.data.size(), counting(given_back)};
  {
    Image read_image;
    ASSERT_TRUE(read(apart, {&lent, 1}, read_image));

    EXPECT_EQ(read_image.data.data(), image.data.data());
    EXPECT_EQ(to_cdr(read_image), to_cdr(image));
    EXPECT_EQ(lent.hook.release, nullptr) << "the message has it now";
    Image::message_type().recycle(&read_image);
    EXPECT_EQ(given_back, 1);
    EXPECT_TRUE(read_image.data.empty());
  }
  EXPECT_EQ(given_back, 1);
}

TEST(CdrApart, without_a_hook_the_numbers_are_copied) {
  Image image = image_of(10'000);
  const Apart apart{image};
  LentPart lent{image.data.data(), image.data.size(), {}};
  Image read_image;

  ASSERT_TRUE(read(apart, {&lent, 1}, read_image));

  EXPECT_NE(read_image.data.data(), image.data.data());
  EXPECT_FALSE(read_image.data.is_foreign());
  EXPECT_EQ(read_image, image);
}

TEST(CdrApart, memory_that_an_earlier_message_was_lent_is_not_written_to) {
  Image first = image_of(10'000);
  const Image before = first;
  int given_back = 0;
  LentPart lent{first.data.data(), first.data.size(), counting(given_back)};
  Image reader;
  ASSERT_TRUE(read(Apart{first}, {&lent, 1}, reader));
  Image second = image_of(9'000);
  second.data[0] = 99;
  LentPart copied{second.data.data(), second.data.size(), {}};

  ASSERT_TRUE(read(Apart{second}, {&copied, 1}, reader));

  EXPECT_EQ(first, before);
  EXPECT_EQ(given_back, 1);
  EXPECT_EQ(reader, second);
}

TEST(CdrApart, parts_that_do_not_fit_the_message_are_faults_and_stay_the_callers) {
  Image image = image_of(10'000);
  const Apart apart{image};
  int given_back = 0;
  Image into;
  LentPart one_short{image.data.data(), image.data.size() - 1, counting(given_back)};
  LentPart too_many[] = {{image.data.data(), image.data.size(), {}}, {image.data.data(), 5'000, counting(given_back)}};
  Bytes plain = to_cdr(image);

  EXPECT_EQ(read(apart, {&one_short, 1}, into).error(), DecodeFault::ImpossibleCount);
  EXPECT_NE(one_short.hook.release, nullptr);
  EXPECT_EQ(read(apart, too_many, into).error(), DecodeFault::TrailingBytes);
  EXPECT_NE(too_many[1].hook.release, nullptr);
  EXPECT_FALSE(read(apart, {}, into)) << "a part that is missing";
  Bytes foreign = apart.small;
  foreign[1] = 0;  // big-endian: a host of its own does not share memory
  EXPECT_EQ(decode_apart(Image::message_type(), foreign, {&one_short, 1}, &into).error(), DecodeFault::UnknownEncoding);
  EXPECT_EQ(given_back, 0);
}

TEST(CdrApart, every_cut_of_the_small_bytes_is_a_fault) {
  Image image = image_of(5'000);
  const Apart apart{image};
  for (std::size_t length = 0; length < apart.small.size(); ++length) {
    LentPart lent{image.data.data(), image.data.size(), {}};
    Image into;
    EXPECT_FALSE(decode_apart(Image::message_type(), ByteView{apart.small}.first(length), {&lent, 1}, &into)) << length;
  }
}

}  // namespace
