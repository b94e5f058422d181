// SPDX-License-Identifier: Apache-2.0
#include "record/port/ring_folder.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

class RingFolderTest : public TemporaryFolder {
 protected:
  std::shared_ptr<RingFolder> make(const std::string& name = "robot.recorder") {
    auto made = RingFolder::make(folder_, name);
    EXPECT_TRUE(made) << made.error().text();
    return made ? std::move(*made) : nullptr;
  }
  /// A folder that another process made, filled and left when it was killed.
  void leave(const std::string& name) {
    const pid_t child = ::fork();
    if (child == 0) {
      const auto folder = RingFolder::make(folder_, name);
      if (!folder) ::_exit(1);
      const auto file = (*folder)->add("000000000000.mcap", as_bytes(std::string{"bytes"}));
      ::_exit(file ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
  }
  [[nodiscard]] std::size_t entries() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator{folder_}) ++count;
    return count;
  }
};

TEST_F(RingFolderTest, goes_with_its_last_file) {
  auto folder = make();
  auto file = folder->add("a.mcap", as_bytes(std::string{"abc"}));
  ASSERT_TRUE(file);
  EXPECT_EQ((*file)->bytes(), 3U);
  EXPECT_EQ(folder->bytes(), 3U);
  EXPECT_FALSE(folder->add("a.mcap", {})) << "no file is written twice";
  folder.reset();
  EXPECT_EQ(entries(), 1U);
  file->reset();
  EXPECT_EQ(entries(), 0U);
}

TEST_F(RingFolderTest, of_a_living_process_is_not_left_behind) {
  const auto folder = make();
  EXPECT_TRUE(RingFolder::left_behind(folder_, "robot.recorder").empty());
}

TEST_F(RingFolderTest, of_a_killed_process_is_found_once_under_its_name) {
  leave("robot.recorder");
  EXPECT_TRUE(RingFolder::left_behind(folder_, "robot").empty());
  EXPECT_TRUE(RingFolder::left_behind(folder_, "robot.recorder2").empty());
  auto found = RingFolder::left_behind(folder_, "robot.recorder");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front()->files().size(), 1U);
  EXPECT_TRUE(RingFolder::left_behind(folder_, "robot.recorder").empty()) << "it is held now";
  found.clear();
  ASSERT_EQ(entries(), 1U) << "its files are not lost";
  found = RingFolder::left_behind(folder_, "robot.recorder");
  ASSERT_EQ(found.size(), 1U);
  found.front()->clear();
  found.clear();
  EXPECT_EQ(entries(), 0U);
}

TEST_F(RingFolderTest, that_others_could_have_made_is_ignored) {
  leave("robot.recorder");
  const auto real = std::filesystem::directory_iterator { folder_ } -> path();
  std::filesystem::permissions(real, std::filesystem::perms{0770});
  EXPECT_TRUE(RingFolder::left_behind(folder_, "robot.recorder").empty()) << "others may write into it";
  std::filesystem::permissions(real, std::filesystem::perms{0700});
  std::filesystem::rename(real, path("elsewhere"));
  std::filesystem::create_directory_symlink(path("elsewhere"), real);
  EXPECT_TRUE(RingFolder::left_behind(folder_, "robot.recorder").empty()) << "a symbolic link";
  std::filesystem::remove(real);
  std::filesystem::rename(path("elsewhere"), real);
  EXPECT_EQ(RingFolder::left_behind(folder_, "robot.recorder").size(), 1U);
}

TEST(PrivateFolder, belongs_to_the_user_and_is_closed_to_all_others) {
  struct stat status {};
  status.st_uid = 1000;
  status.st_mode = S_IFDIR | 0700U;
  EXPECT_TRUE(is_private(status, 1000));
  EXPECT_FALSE(is_private(status, 1001));
  status.st_mode = S_IFDIR | 0701U;
  EXPECT_FALSE(is_private(status, 1000));
  status.st_mode = S_IFREG | 0700U;
  EXPECT_FALSE(is_private(status, 1000));
}

TEST(RingName, is_a_file_name_of_its_own_for_each_node) {
  EXPECT_EQ(ring_name("/robot", "/rosbag2_recorder"), "robot.rosbag2_recorder");
  EXPECT_EQ(ring_name("/a/b", "/c d"), "a.b.c_d");
  const std::string longest = ring_name("/robot", "/" + std::string(300, 'x') + "1");
  EXPECT_LT(longest.size(), 200U);
  EXPECT_NE(longest, ring_name("/robot", "/" + std::string(300, 'x') + "2"));
}

}  // namespace
}  // namespace nacelle::record
