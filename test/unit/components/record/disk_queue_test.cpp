// SPDX-License-Identifier: Apache-2.0
#include "record/port/disk_queue.hpp"

#include <fcntl.h>

#include <array>
#include <atomic>
#include <thread>

#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using DiskQueueTest = TemporaryFolder;

TEST_F(DiskQueueTest, writes_files_in_their_order) {
  {
    DiskQueue queue{1000};
    for (const char* name : {"a", "b"}) {
      auto made = FileSink::create(path(name));
      ASSERT_TRUE(made) << made.error().text();
      QueuedFile file{queue, std::shared_ptr<FileSink>{std::move(*made)}};
      EXPECT_TRUE(file.write(as_bytes("hello ")));
      EXPECT_TRUE(file.write(as_bytes(name)));
    }
    queue.drain();
    EXPECT_EQ(queue.room(), 1000U);
    EXPECT_FALSE(queue.problem());
    EXPECT_EQ(std::filesystem::file_size(path("a")), 7U);
    EXPECT_LT(queue.free_bytes(), UINT64_MAX) << "the file system was asked";
  }
  EXPECT_EQ(std::filesystem::file_size(path("b")), 7U);
}

// A pipe that nobody reads is a disk that takes nothing.
TEST_F(DiskQueueTest, counts_what_waits_for_a_slow_disk) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  const io::Descriptor reads{ends[0]};
  DiskQueue queue{std::size_t{1} << 20U};
  const auto file = std::make_shared<FileSink>(io::Descriptor{ends[1]}, "pipe");
  const Bytes more(std::size_t{1} << 18U);  // four times what the pipe holds
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.write(file, more));
  EXPECT_EQ(queue.room(), std::size_t{1} << 18U);
  EXPECT_TRUE(queue.write(file, more));
  EXPECT_TRUE(queue.write(file, more)) << "above the limit, for what makes a file complete";
  EXPECT_EQ(queue.room(), 0U);
  Bytes taken(more.size());
  for (std::size_t left = 5 * more.size(); left > 0;) {
    const auto count = ::read(reads.number(), taken.data(), taken.size());
    ASSERT_GT(count, 0);
    left -= static_cast<std::size_t>(count);
  }
  queue.drain();
  EXPECT_EQ(queue.room(), std::size_t{1} << 20U);
}

TEST_F(DiskQueueTest, takes_a_buffer_without_copying_it_and_gives_another_one) {
  DiskQueue queue{std::size_t{1} << 20U};
  auto made = FileSink::create(path("a"));
  ASSERT_TRUE(made) << made.error().text();
  QueuedFile file{queue, std::shared_ptr<FileSink>{std::move(*made)}};
  constexpr std::size_t kCapacity = 100'000;
  ByteBuffer buffer{kCapacity};
  const auto hand_over = [&](const char* text) {
    buffer.append(as_bytes(text));
    EXPECT_TRUE(file.hand_over(buffer));
    EXPECT_EQ(buffer.size(), 0U);
    EXPECT_EQ(buffer.capacity(), kCapacity);
    queue.drain();
  };
  const std::uint8_t* const first = buffer.bytes().data();
  hand_over("one ");
  EXPECT_NE(buffer.bytes().data(), first) << "the queue had it";
  hand_over("two ");
  EXPECT_EQ(buffer.bytes().data(), first) << "the disk has it, so that its memory is used again";
  hand_over("three");
  EXPECT_EQ(std::filesystem::file_size(path("a")), 13U);
}

TEST_F(DiskQueueTest, waits_until_there_is_room) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  const io::Descriptor reads{ends[0]};
  DiskQueue queue{std::size_t{1} << 20U};
  const auto file = std::make_shared<FileSink>(io::Descriptor{ends[1]}, "pipe");
  const Bytes most(std::size_t{1} << 20U);
  EXPECT_TRUE(queue.write(file, most));
  std::atomic<bool> has_room{false};
  std::thread waits{[&] {
    queue.await_room(1);
    has_room = true;
  }};
  EXPECT_FALSE(has_room) << "the pipe takes a part only";
  Bytes taken(most.size());
  for (std::size_t left = most.size(); left > 0;) {
    const auto count = ::read(reads.number(), taken.data(), left);
    ASSERT_GT(count, 0);
    left -= static_cast<std::size_t>(count);
  }
  waits.join();
  EXPECT_TRUE(has_room);
}

TEST_F(DiskQueueTest, ends_with_the_first_failure) {
  DiskQueue queue{1000};
  const auto full = std::make_shared<FileSink>(io::Descriptor{::open("/dev/full", O_WRONLY | O_CLOEXEC)}, "/dev/full");
  EXPECT_TRUE(queue.write(full, as_bytes("x")));
  queue.drain();
  ASSERT_TRUE(queue.problem());
  EXPECT_NE(queue.problem()->text().find("No space left"), std::string::npos) << queue.problem()->text();
  EXPECT_FALSE(queue.write(full, as_bytes("y")));
  EXPECT_EQ(queue.room(), 1000U);
}

}  // namespace
}  // namespace nacelle::record
