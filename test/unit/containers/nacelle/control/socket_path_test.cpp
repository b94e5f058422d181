// SPDX-License-Identifier: Apache-2.0
#include "control/socket_path.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "nacelle/base/name_fault.hpp"
#include "temporary_folder.hpp"

namespace nacelle::control {
namespace {

class SocketPath : public ::testing::Test {
 protected:
  SocketPlaces places() const { return {"", "", folder_.path() + "/sockets"}; }
  TemporaryFolder folder_;
};

TEST_F(SocketPath, a_container_is_found_by_name_while_it_lives) {
  EXPECT_TRUE(running_containers(places()).empty());
  {
    auto claim = SocketClaim::take(places(), "robot");
    ASSERT_TRUE(claim) << claim.error().text();
    const auto running = running_containers(places());
    ASSERT_EQ(running.size(), 1U);
    EXPECT_EQ(running[0], (FoundContainer{"robot", folder_.path() + "/sockets/robot.sock"}));
  }
  EXPECT_TRUE(running_containers(places()).empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path() + "/sockets"));
}

TEST_F(SocketPath, the_name_of_a_living_container_is_refused) {
  auto first = SocketClaim::take(places(), "robot");
  ASSERT_TRUE(first);
  auto second = SocketClaim::take(places(), "robot");
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().what.find("running already"), std::string::npos);
  EXPECT_FALSE(second.error().way_out.empty());
  EXPECT_EQ(running_containers(places()).size(), 1U) << "the refusal must not remove the other's socket";
}

TEST_F(SocketPath, what_a_killed_container_left_is_replaced) {
  ASSERT_TRUE(folder_for_socket(places()));
  // As after kill -9: the files exist, without a listener and without the lock.
  const std::string path = places().fallback_dir + "/robot.sock";
  const std::ofstream lock{places().fallback_dir + "/robot.lock"};
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(dead, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(dead);
  EXPECT_TRUE(running_containers(places()).empty()) << "a dead socket is no container";

  auto claim = SocketClaim::take(places(), "robot");

  ASSERT_TRUE(claim) << claim.error().text();
  EXPECT_EQ(running_containers(places()).size(), 1U);
}

TEST_F(SocketPath, the_folder_is_for_its_user_only) {
  auto folder = folder_for_socket(places());
  ASSERT_TRUE(folder);
  struct stat seen {};
  ASSERT_EQ(::stat(folder.value().c_str(), &seen), 0);
  EXPECT_EQ(seen.st_mode & 0777U, 0700U);

  ::chmod(folder.value().c_str(), 0755);
  auto open_to_all = folder_for_socket(places());
  ASSERT_FALSE(open_to_all);
  EXPECT_NE(open_to_all.error().what.find("open to other users"), std::string::npos);
}

TEST_F(SocketPath, a_link_in_place_of_the_folder_is_refused) {
  std::filesystem::create_directory(folder_.path() + "/elsewhere");
  std::filesystem::create_directory_symlink(folder_.path() + "/elsewhere", places().fallback_dir);
  EXPECT_FALSE(folder_for_socket(places()));
}

TEST_F(SocketPath, the_user_s_runtime_folder_comes_first) {
  SocketPlaces all = places();
  all.xdg_runtime_dir = folder_.path();
  EXPECT_EQ(folder_for_socket(all).value_or(""), folder_.path() + "/nacelle");
}

TEST(ContainerName, holds_no_path) {
  for (const char* const bad : {"", ".", "..", "../x", "a/b", ".hidden", "a b", "naïve"})
    EXPECT_FALSE(validate_container_name(bad)) << bad;
  EXPECT_FALSE(validate_container_name(std::string(49, 'a')));
  for (const char* const good : {"robot", "drive-123", "a.b_c", "7"})
    EXPECT_TRUE(validate_container_name(good)) << good;
}

TEST(ContainerChoice, is_the_one_named_or_the_only_one) {
  const FoundContainer a{"a", "/a"}, b{"b", "/b"};
  EXPECT_EQ(choose_container({a}, std::nullopt).value_or(b), a);
  EXPECT_EQ(choose_container({a, b}, "b").value_or(a), b);
  EXPECT_EQ(choose_container({}, std::nullopt).error().code, NameFault::Unknown);
  EXPECT_EQ(choose_container({a}, "c").error().code, NameFault::Unknown);
  const auto many = choose_container({a, b}, std::nullopt);
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().code, NameFault::Ambiguous);
  EXPECT_NE(many.error().text().find("a, b"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::control
