// SPDX-License-Identifier: Apache-2.0
#include "transport_local/wire/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

namespace nacelle::transport_local {
namespace {

Bytes conversation() {
  Bytes out;
  append_hello(out, "iceoryx");
  append_endpoint(out, {7, true, true, QoS(KeepAll{}).max_samples(3).deadline(100ms).transient_local(), "/chat",
                        "std_msgs/msg/String", "RIHS01_ab", "/writer"});
  append_endpoint(out, {8, false, false, QoS(5).best_effort(), "/chat", "std_msgs/msg/String", "RIHS01_ab", "", 500ms,
                        "cmd_vel_timeout", Announced::WithItsPublisher, QoS(KeepAll{}).transient_local()});
  std::uint8_t* const cdr = append_data(out, {7, 42, 1'000, 2'000, {}}, {8, 9}, 3);
  std::copy_n("abc", 3, cdr);
  append_id_and_count(out, LinkFrameKind::Taken, 8, 1);
  append_lost(out, {8, 1, 2, 3, 4});
  append_id_and_byte(out, LinkFrameKind::Gate, 8, 1);
  append_note(out, as_bytes("hello"));
  append_id(out, LinkFrameKind::Gone, 7);
  return out;
}

// Feeds the bytes in pieces of one size and writes down each frame.
std::vector<std::string> frames_of(const Bytes& bytes, std::size_t piece) {
  LinkFrameReader reader;
  std::vector<std::string> all;
  for (std::size_t at = 0; at < bytes.size();) {
    const ByteSpan room = reader.room();
    const std::size_t n = std::min({piece, room.size(), bytes.size() - at});
    std::memcpy(room.data(), bytes.data() + at, n);
    reader.filled(n);
    at += n;
    for (;;) {
      auto frame = reader.next();
      if (!frame) return all.emplace_back(std::string("!") + to_text(frame.error())), all;
      if (!frame.value()) break;
      all.push_back(static_cast<char>(frame.value()->kind) + std::string(as_text(frame.value()->payload)));
    }
  }
  return all;
}

LinkFrame frame_at(const Bytes& bytes, std::size_t skip) {
  std::size_t at = 0;
  for (;; --skip) {
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + at, 4);
    if (skip == 0)
      return {static_cast<LinkFrameKind>(bytes[at + 4]), ByteView{bytes}.subspan(at + kFrameHeaderBytes, length)};
    at += kFrameHeaderBytes + length;
  }
}

TEST(LinkFrames, come_out_of_any_chopping_as_they_went_in) {
  const Bytes bytes = conversation();
  const auto whole = frames_of(bytes, bytes.size());
  EXPECT_EQ(whole.size(), 9U);
  for (std::size_t piece = 1; piece < 40; ++piece) EXPECT_EQ(frames_of(bytes, piece), whole) << piece;
}

TEST(LinkFrames, carry_every_field) {
  const Bytes bytes = conversation();
  EXPECT_EQ(read_hello(frame_at(bytes, 0).payload).value().carrier, "iceoryx");
  const auto writer = read_endpoint(frame_at(bytes, 1));
  ASSERT_TRUE(writer);
  EXPECT_TRUE(writer->is_writer && writer->open);
  EXPECT_EQ(writer->qos.resolved(), QoS(KeepAll{}).max_samples(3).deadline(100ms).transient_local().resolved());
  EXPECT_EQ(writer->topic + writer->type + writer->hash + writer->node, "/chatstd_msgs/msg/StringRIHS01_ab/writer");
  const auto reader = read_endpoint(frame_at(bytes, 2));
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->is_writer || reader->open);
  EXPECT_EQ(reader->qos.resolved(), QoS(5).best_effort().resolved());
  EXPECT_EQ(reader->command_timeout, Duration{500ms});
  EXPECT_EQ(reader->command_parameter, "cmd_vel_timeout");
  EXPECT_EQ(writer->command_timeout, Duration::zero());
  EXPECT_EQ(reader->announced, Announced::WithItsPublisher);
  EXPECT_EQ(writer->announced, Announced::Always);
  ASSERT_TRUE(reader->unless_offered);
  EXPECT_EQ(reader->unless_offered->resolved(), QoS(KeepAll{}).transient_local().resolved());
  EXPECT_FALSE(writer->unless_offered);
  std::vector<std::uint64_t> readers;
  const auto data = read_data(frame_at(bytes, 3).payload, readers);
  ASSERT_TRUE(data);
  EXPECT_EQ(readers, (std::vector<std::uint64_t>{8, 9}));
  EXPECT_EQ(data->writer + data->sequence, 49U);
  EXPECT_EQ(data->source_ns + data->expires_ns, 3'000);
  EXPECT_EQ(as_text(data->cdr), "abc");
  EXPECT_EQ(read_id_and_count(frame_at(bytes, 4).payload), (std::pair<std::uint64_t, std::uint64_t>{8, 1}));
  const auto lost = read_lost(frame_at(bytes, 5).payload);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->overwritten * 1000 + lost->full * 100 + lost->expired * 10 + lost->inactive, 1234U);
}

TEST(LinkFrames, carry_services_calls_and_answers) {
  Bytes bytes;
  append_service(bytes, {7, true, false, "/add", "/adder", "Add_Request", "RIHS01_a", "Add_Response", "RIHS01_b"});
  std::copy_n("abc", 3, append_call(bytes, 7, 42, 3));
  std::copy_n("de", 2, append_answer(bytes, 42, 2));
  append_no_answer(bytes, 43);
  const auto service = read_service(frame_at(bytes, 0).payload);
  ASSERT_TRUE(service);
  EXPECT_EQ(service->id, 7U);
  EXPECT_TRUE(service->is_server && !service->open);
  EXPECT_EQ(service->name + service->node + service->request + service->request_hash + service->response +
                service->response_hash,
            "/add/adderAdd_RequestRIHS01_aAdd_ResponseRIHS01_b");
  const auto call = read_call(frame_at(bytes, 1).payload);
  ASSERT_TRUE(call);
  EXPECT_EQ(call->end + call->number, 49U);
  EXPECT_EQ(as_text(call->cdr), "abc");
  const auto answer = read_answer(frame_at(bytes, 2).payload);
  ASSERT_TRUE(answer && answer->answered);
  EXPECT_EQ(answer->number, 42U);
  EXPECT_EQ(as_text(answer->cdr), "de");
  const auto none = read_answer(frame_at(bytes, 3).payload);
  ASSERT_TRUE(none);
  EXPECT_EQ(none->number, 43U);
  EXPECT_FALSE(none->answered);

  const ByteView whole = frame_at(bytes, 0).payload;
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(read_service(whole.first(size))) << size;
  EXPECT_FALSE(read_call(frame_at(bytes, 1).payload.first(15)));
  EXPECT_FALSE(read_answer(frame_at(bytes, 2).payload.first(8)));
  Bytes none_with_tail(frame_at(bytes, 3).payload.begin(), frame_at(bytes, 3).payload.end());
  none_with_tail.push_back(1);
  EXPECT_FALSE(read_answer(none_with_tail));
  EXPECT_FALSE(read_call(Bytes(16 + kLongestServiceBytes + 1)));
}

TEST(LinkFrames, that_are_cut_or_have_a_tail_are_refused) {
  const Bytes bytes = conversation();
  std::vector<std::uint64_t> readers;
  for (const std::size_t which : {1U, 2U, 4U, 5U, 6U, 8U}) {
    const LinkFrame good = frame_at(bytes, which);
    for (std::size_t size = 0; size <= good.payload.size() + 1; ++size) {
      if (size == good.payload.size()) continue;
      Bytes other(good.payload.begin(), good.payload.end());
      other.resize(size);
      const LinkFrame frame{good.kind, other};
      EXPECT_FALSE(which <= 2 && read_endpoint(frame)) << which << " " << size;
      EXPECT_FALSE(which == 4 && read_id_and_count(other));
      EXPECT_FALSE(which == 5 && read_lost(other));
      EXPECT_FALSE(which == 6 && read_id_and_byte(other));
      EXPECT_FALSE(which == 8 && read_id(other));
    }
  }
  const ByteView data = frame_at(bytes, 3).payload;
  for (std::size_t size = 0; size < data.size() - 3; ++size) EXPECT_FALSE(read_data(data.first(size), readers)) << size;
}

TEST(LinkFrames, from_something_else_end_the_reading_with_a_reason) {
  Bytes no_hello;
  append_id(no_hello, LinkFrameKind::Gone, 7);
  Bytes twice;
  append_hello(twice, "");
  append_hello(twice, "");

  const std::uint32_t huge = 0xFFFFFFF0;
  Bytes longest;
  append_hello(longest, "");
  longest.insert(longest.end(), reinterpret_cast<const std::uint8_t*>(&huge),
                 reinterpret_cast<const std::uint8_t*>(&huge) + 4);
  longest.push_back('D');
  EXPECT_EQ(frames_of(no_hello, 100).back(), std::string("!") + to_text(LinkFault::NoHello));
  EXPECT_EQ(frames_of(twice, 100).back(), std::string("!") + to_text(LinkFault::NoHello));
  EXPECT_EQ(frames_of(longest, 100).back(), std::string("!") + to_text(LinkFault::TooLong));
  EXPECT_EQ(frames_of({1, 0, 0, 0, 'z', 0}, 100).back(), std::string("!") + to_text(LinkFault::UnknownKind));
  Bytes other;
  append_hello(other, "x");
  other[kFrameHeaderBytes + 8] = 99;
  EXPECT_EQ(read_hello(frame_at(other, 0).payload).error(), LinkFault::OtherVersion);
  other[kFrameHeaderBytes] = 'X';
  EXPECT_EQ(read_hello(frame_at(other, 0).payload).error(), LinkFault::BadHello);
}

TEST(LinkFrames, with_values_out_of_range_are_refused) {
  const auto endpoint = [](const QoS& qos) {
    Bytes out;
    append_endpoint(out, {7, true, true, qos, "/t", "a/msg/B", "h", "/n"});
    return out;
  };
  // Behind the header and id: open, history, reliability, durability, liveliness, depth, max_samples, deadline.
  constexpr std::size_t kOpen = kFrameHeaderBytes + 8, kDepth = kOpen + 5, kDeadline = kDepth + 16;
  const auto refused = [&](std::size_t at, std::uint8_t value) {
    Bytes bytes = endpoint(QoS(3));
    bytes[at] = value;
    return !read_endpoint(frame_at(bytes, 0));
  };
  EXPECT_FALSE(refused(kOpen, 0));
  for (std::size_t at = kOpen; at < kDepth; ++at) EXPECT_TRUE(refused(at, 77)) << at;
  EXPECT_TRUE(refused(kDepth + 7, 1)) << "a queue larger than any memory";
  EXPECT_TRUE(refused(kDeadline + 7, 0x80)) << "a negative time";
  EXPECT_TRUE(refused(kDeadline + 7, 0x7F)) << "a time that would overflow sums";
}

}  // namespace
}  // namespace nacelle::transport_local
