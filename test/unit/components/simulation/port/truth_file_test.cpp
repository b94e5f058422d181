// SPDX-License-Identifier: Apache-2.0
#include "simulation/port/truth_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

namespace nacelle::simulation {
namespace {

std::string scratch(const char* name) { return ::testing::TempDir() + name + std::to_string(getpid()); }

TEST(TruthFile, tells_another_reader_what_was_written) {
  const std::string path = scratch("truth_");
  auto file = TruthFile::create(path);
  ASSERT_TRUE(file) << file.error().text();
  const Truth truth{1.5, 0.1, -0.2, 3.0, 0.3, -0.4, 0.25, 0.26, 42, 17, 123456789, 0};
  file.value()->write(truth);
  const auto read = read_truth(path);
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, truth);
}

TEST(TruthFile, is_gone_with_its_world) {
  const std::string path = scratch("truth_gone_");
  { auto file = TruthFile::create(path); }
  EXPECT_EQ(read_truth(path).error(), TruthFault::NotThere);
}

TEST(TruthFile, is_not_mixed_up_with_other_files) {
  const std::string path = scratch("truth_other_");
  std::ofstream{path} << "not a truth";
  EXPECT_EQ(read_truth(path).error(), TruthFault::NotATruth);
  std::ofstream{path} << std::string(112, 'x');
  EXPECT_EQ(read_truth(path).error(), TruthFault::NotATruth);
  std::filesystem::remove(path);
}

TEST(TruthFile, is_never_read_half_written) {
  const std::string path = scratch("truth_torn_");
  auto file = TruthFile::create(path);
  ASSERT_TRUE(file);
  std::atomic<bool> stop{false};
  std::thread writer{[&] {
    Truth truth;
    while (!stop) {
      truth.x_m += 1.0;
      truth.y_m = truth.x_m;
      truth.contacts = static_cast<std::uint64_t>(truth.x_m);
      file.value()->write(truth);
    }
  }};
  for (int i = 0; i < 2000; ++i) {
    const auto truth = read_truth(path);
    if (!truth) continue;  // a writer that never pauses may win a thousand times
    EXPECT_EQ(truth->x_m, truth->y_m);
    EXPECT_EQ(truth->contacts, static_cast<std::uint64_t>(truth->x_m));
  }
  stop = true;
  writer.join();
}

}  // namespace
}  // namespace nacelle::simulation
