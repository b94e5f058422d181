// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/pty_pair.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace nacelle::io {
namespace {

std::string scratch(const char* name) { return ::testing::TempDir() + name + std::to_string(getpid()); }

std::unique_ptr<PtyPair> make_pty() {
  auto pty = PtyPair::create();
  EXPECT_TRUE(pty) << pty.error().text();
  return std::move(pty).value();
}

TEST(PtyPair, its_link_lives_as_long_as_it_does) {
  const std::string link = scratch("pty_link_");
  auto pty = make_pty();
  ASSERT_TRUE(pty->link_as(link));
  EXPECT_EQ(std::filesystem::read_symlink(link), pty->path());
  pty.reset();
  EXPECT_FALSE(std::filesystem::is_symlink(link));
}

TEST(PtyPair, leaves_a_link_alone_that_a_later_one_took_over) {
  const std::string link = scratch("pty_taken_");
  auto first = make_pty();
  ASSERT_TRUE(first->link_as(link));
  auto second = make_pty();
  ASSERT_TRUE(second->link_as(link));
  first.reset();
  EXPECT_EQ(std::filesystem::read_symlink(link), second->path());
}

TEST(PtyPair, does_not_replace_a_file_by_its_link) {
  const std::string path = scratch("pty_file_");
  std::ofstream{path} << "precious";
  const auto linked = make_pty()->link_as(path);
  ASSERT_FALSE(linked);
  EXPECT_EQ(linked.error().where.text(), path);
  EXPECT_TRUE(std::filesystem::is_regular_file(path));
  std::filesystem::remove(path);
}

TEST(PtyPair, a_line_without_a_reader_fills_up_and_then_takes_nothing) {
  auto pty = make_pty();
  const Bytes chunk(64, 0x55);
  std::size_t sent = 0;
  // The kernel moves bytes to the reader's side in its own time; the sum stays bounded whenever that is.
  for (int i = 0; i < 2000; ++i) sent += pty->write_some(chunk);
  EXPECT_GE(sent, PtyPair::kFullBytes - chunk.size());
  EXPECT_LT(sent, 2000 * chunk.size());
}

TEST(PtyPair, reads_nothing_when_nothing_was_written) {
  auto pty = make_pty();
  const auto bytes = pty->read();
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(bytes->empty());
}

}  // namespace
}  // namespace nacelle::io
