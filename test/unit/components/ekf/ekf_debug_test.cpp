// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "ekf/component/debug_file.hpp"
#include "ekf_node.hpp"
#include "nacelle/base/file_fault.hpp"

namespace nacelle::ekf {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file{path};
  std::ostringstream all;
  all << file.rdbuf();
  return all.str();
}

/// A folder of this test in memory.
class InMemory {
 public:
  InMemory() {
    std::string pattern = "/dev/shm/nacelle-ekf-debug-XXXXXX";
    path_ = ::mkdtemp(pattern.data()) == nullptr ? "" : pattern;
  }
  InMemory(const InMemory&) = delete;
  InMemory& operator=(const InMemory&) = delete;
  ~InMemory() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

TEST(DebugFile, is_refused_outside_memory) {
  const auto file = DebugFile::open("/proc/debug.txt");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().text().find("is not in memory"), std::string::npos) << file.error().text();
  EXPECT_FALSE(DebugFile::open("/dev/shm/nacelle-no-such-folder/debug.txt"));
}

TEST(DebugFile, belongs_to_its_user_alone_and_does_not_follow_a_link) {
  const InMemory folder;
  ASSERT_TRUE(DebugFile::open(folder / "a.txt"));
  struct stat found {};
  ASSERT_EQ(::stat((folder / "a.txt").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777U, 0600U);
  ASSERT_EQ(::symlink((folder / "a.txt").c_str(), (folder / "b.txt").c_str()), 0);
  EXPECT_FALSE(DebugFile::open(folder / "b.txt"));
}

TEST(DebugFile, keeps_the_last_of_what_was_written) {
  const InMemory folder;
  auto file = DebugFile::open(folder / "a.txt", 100);
  ASSERT_TRUE(file);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(file->write("line " + std::to_string(i) + "\n"));
  const std::string older = text_of(folder / "a.txt.1"), newer = text_of(folder / "a.txt");
  EXPECT_LE(older.size(), 100U);
  EXPECT_LE(newer.size(), 100U);
  EXPECT_TRUE(newer.ends_with("line 98\nline 99\n")) << newer;
  EXPECT_TRUE((older + newer).find("line 85\nline 86\nline 87\n") != std::string::npos) << older << "--\n" << newer;
}

TEST(DebugFile, a_name_is_in_the_folder_of_the_user_and_has_the_node_in_it) {
  EXPECT_EQ(DebugFile::path_for("/dev/shm/x.txt", "/robot/ekf"), "/dev/shm/x.txt");
  const std::string path = DebugFile::path_for("", "/robot/ekf");
  EXPECT_TRUE(path.starts_with('/')) << path;
  EXPECT_TRUE(path.ends_with("/robot_localization_debug.robot.ekf.txt")) << path;
  EXPECT_TRUE(DebugFile::path_for("mine.txt", "/ekf").ends_with("/mine.txt"));
}

TEST_F(EkfNode, debug_writes_predictions_measurements_and_states) {
  const InMemory folder;
  options_.append_parameter_override("debug", true);
  options_.append_parameter_override("debug_out_file", folder / "debug.txt");
  options_.append_parameter_override("odom0", std::string{"odom"});
  options_.append_parameter_override("odom0_config", config_of({kVx, kVyaw}));
  options_.append_parameter_override("odom0_twist_rejection_threshold", 3.0);
  start();
  for (int i = 0; i < 20; ++i) {
    context_.advance(18ms);
    send_odometry(0.3, 0.1);
    context_.advance(2ms);
  }
  send_odometry(40.0);
  context_.advance(20ms);
  node_.reset();
  const std::string text = text_of(folder / "debug.txt");
  EXPECT_NE(text.find(" predict 0.020000000\n"), std::string::npos) << text;
  EXPECT_NE(text.find(" odom0 twist: vx 0.3 (0.3"), std::string::npos) << text;
  EXPECT_NE(text.find(": fused, "), std::string::npos);
  EXPECT_NE(text.find(" odom0 twist: vx 40 ("), std::string::npos);
  EXPECT_NE(text.find(": outside the rejection threshold\n"), std::string::npos);
  EXPECT_NE(text.find(" state x "), std::string::npos);
}

TEST_F(EkfNode, debug_outside_memory_is_refused_at_configure) {
  options_.append_parameter_override("debug", true);
  options_.append_parameter_override("debug_out_file", std::string{"/proc/debug.txt"});
  EkfComponent node{options_};
  const auto configured = node.trigger(Transition::Configure);
  EXPECT_FALSE(configured.success);
  EXPECT_NE(configured.reason.find("is not in memory"), std::string::npos) << configured.reason;
}

}  // namespace
}  // namespace nacelle::ekf
