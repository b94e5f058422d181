// SPDX-License-Identifier: Apache-2.0
#include "control/trust.hpp"

#include <grp.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/client.hpp"
#include "control/server.hpp"
#include "temporary_folder.hpp"

namespace nacelle::control {
namespace {

constexpr uid_t kVictim = 12340, kStranger = 12350;
constexpr gid_t kOperators = 12360;

/// Runs it in a process of that user, and gives its exit code; 99: it could not become that user.
int as_user(uid_t user, const std::function<int()>& act, std::optional<gid_t> also_in = std::nullopt) {
  const pid_t child = ::fork();
  if (child == 0) {
    const gid_t also = also_in.value_or(0);
    const bool is_changed = ::setgroups(also_in ? 1 : 0, &also) == 0 && ::setgid(user) == 0 && ::setuid(user) == 0;
    ::_exit(is_changed ? act() : 99);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 98;
}

/// A process of that user that listens on a socket there until the object goes.
class Listener {
 public:
  Listener(uid_t user, const std::string& path) {
    std::array<int, 2> ready{};
    EXPECT_EQ(::pipe(ready.data()), 0);
    child_ = ::fork();
    if (child_ == 0) {
      sockaddr_un address{};
      address.sun_family = AF_UNIX;
      std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
      const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
      const bool listens = ::setgroups(0, nullptr) == 0 && ::setgid(user) == 0 && ::setuid(user) == 0 &&
                           ::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
                           ::chmod(path.c_str(), 0666) == 0 && ::listen(fd, 4) == 0;
      const char word = listens ? 'y' : 'n';
      static_cast<void>(!::write(ready[1], &word, 1));
      for (;;) ::pause();
    }
    char word = 'n';
    EXPECT_EQ(::read(ready[0], &word, 1), 1);
    EXPECT_EQ(word, 'y');
    ::close(ready[0]);
    ::close(ready[1]);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }

 private:
  pid_t child_ = 0;
};

class Silent final : public FastService {
 public:
  Result<std::uint16_t, std::string> open_writer(NamePair) override { return err(std::string{"none"}); }
  void close_writer(std::uint16_t) override {}
  const char* publish(const Publication&) override { return "none"; }
  TransformAnswer lookup(NamePair) override { return {}; }
  void append_stats(std::string& out) override { out += "{}"; }
  void request_shutdown() override {}
  bool is_emergency_stop(NamePair) const override { return false; }
  void descriptors_ran_out(bool) override {}
  void descriptor_was_lost() override {}
};

/// Two users besides root. Its folder may be entered by all.
class TwoUsers : public ::testing::Test {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can be two users";
    ASSERT_EQ(::chmod(folder_.path().c_str(), 0711), 0);
  }
  std::string folder_of(uid_t user, mode_t mode, const char* name = "sockets") const {
    const std::string path = folder_.path() + "/" + name;
    std::filesystem::create_directory(path);
    EXPECT_EQ(::chown(path.c_str(), user, user), 0);
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
    return path;
  }
  TemporaryFolder folder_;
  const SystemClock clock_;
};

TEST_F(TwoUsers, ignores_a_folder_of_another_user) {
  const std::string folder = folder_of(kStranger, 0755);
  const Listener listener{kStranger, folder + "/other.sock"};

  const int code = as_user(kVictim, [&] {
    std::vector<Problem> ignored;
    if (!running_containers({"", "", folder}, &ignored).empty()) return 1;
    if (ignored.size() != 1 || ignored[0].text().find("owned by user 12350") == std::string::npos) return 2;
    return folder_for_socket({"", "", folder}) ? 3 : 0;
  });

  EXPECT_EQ(code, 0);
}

TEST_F(TwoUsers, a_socket_of_another_user_is_ignored_where_the_folder_is_trusted) {
  const std::string folder = folder_of(kVictim, 0777);
  const Listener listener{kStranger, folder + "/other.sock"};
  ASSERT_EQ(::chmod(folder.c_str(), 0700), 0);

  const int code = as_user(kVictim, [&] {
    const auto claim = SocketClaim::take({"", "", folder}, "own");
    std::vector<Problem> ignored;
    const auto found = running_containers({"", "", folder}, &ignored);
    if (!claim || found.size() != 1 || found[0].name != "own") return 1;
    return ignored.size() == 1 && ignored[0].text().find("other.sock (owned by user 12350)") != std::string::npos ? 0
                                                                                                                  : 2;
  });

  EXPECT_EQ(code, 0);
}

TEST_F(TwoUsers, sends_nothing_to_a_listener_of_another_user) {
  const std::string folder = folder_of(kStranger, 0755);
  const Listener listener{kStranger, folder + "/other.sock"};

  const int code = as_user(kVictim, [&] {
    const auto client = Client::connect(folder + "/other.sock");
    return !client && client.error().text().find("belongs to user 12350") != std::string::npos ? 0 : 1;
  });

  EXPECT_EQ(code, 0);
}

TEST_F(TwoUsers, a_container_refuses_another_user_and_reports_it) {
  auto claim = SocketClaim::take({"", "", folder_.path() + "/sockets"}, "robot");
  ASSERT_TRUE(claim);
  const std::string path = claim.value().path();
  Silent service;
  const ControlServer server{std::move(claim).value(), service, clock_};
  // As after a chmod by mistake: what the folder keeps out otherwise.
  ASSERT_EQ(::chmod((folder_.path() + "/sockets").c_str(), 0755), 0);
  ASSERT_EQ(::chmod(path.c_str(), 0666), 0);

  const int code = as_user(kStranger, [&] {
    auto client = Client::connect(path);
    if (!client) return 1;
    const auto answer = client.value().stats(5s);
    return !answer && answer.error().text().find("its own user, root and its group only") != std::string::npos ? 0 : 2;
  });

  EXPECT_EQ(code, 0);
  EXPECT_TRUE(Client::connect(path).value().stats(5s)) << "its own user is served";
}

TEST_F(TwoUsers, members_of_the_group_ask_a_container_of_the_system_and_others_do_not) {
  const std::string system = folder_of(0, 0750, "run");
  ASSERT_EQ(::chown(system.c_str(), 0, kOperators), 0);
  auto claim = SocketClaim::take({"", system, ""}, "robot");
  ASSERT_TRUE(claim) << claim.error().text();
  struct stat seen {};
  ASSERT_EQ(::stat(claim.value().path().c_str(), &seen), 0);
  EXPECT_EQ(seen.st_mode & 0777U, 0660U);
  EXPECT_EQ(seen.st_gid, kOperators);
  Silent service;
  const ControlServer server{std::move(claim).value(), service, clock_};
  const auto ask = [&] {
    std::vector<Problem> ignored;
    const auto found = running_containers({"", system, ""}, &ignored);
    if (found.empty()) return ignored.empty() ? 1 : 2;
    auto client = Client::connect(found[0].path);
    return client && client.value().stats(5s) ? 0 : 3;
  };

  EXPECT_EQ(as_user(kVictim, ask, kOperators), 0);
  EXPECT_EQ(as_user(kStranger, ask), 1) << "it sees nothing, and nothing is wrong";
}

// As a service with RuntimeDirectory=, User= and Group= has it.
TEST_F(TwoUsers, members_of_the_group_ask_the_container_of_a_service_and_others_do_not) {
  const std::string system = folder_of(kVictim, 0750, "run");
  ASSERT_EQ(::chown(system.c_str(), kVictim, kOperators), 0);
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  const pid_t service = ::fork();
  if (service == 0) {
    const bool is_user = ::setgroups(0, nullptr) == 0 && ::setgid(kOperators) == 0 && ::setuid(kVictim) == 0;
    auto claim = SocketClaim::take({"", system, ""}, "robot");
    const char word = is_user && claim && claim.value().group() == kOperators ? 'y' : 'n';
    Silent silent;
    std::optional<ControlServer> server;
    if (claim) server.emplace(std::move(claim).value(), silent, clock_);
    static_cast<void>(!::write(ready[1], &word, 1));
    for (;;) ::pause();
  }
  char word = 'n';
  EXPECT_EQ(::read(ready[0], &word, 1), 1);
  EXPECT_EQ(word, 'y');
  const auto ask = [&] {
    const auto found = running_containers({"", system, ""});
    if (found.empty()) return 1;
    auto client = Client::connect(found[0].path);
    return client && client.value().stats(5s) ? 0 : 2;
  };

  EXPECT_EQ(as_user(kStranger, ask, kOperators), 0);
  EXPECT_EQ(as_user(kStranger, ask), 1);

  ::kill(service, SIGKILL);
  ::waitpid(service, nullptr, 0);
  for (const int end : ready) ::close(end);
}

TEST_F(TwoUsers, a_folder_of_the_system_that_root_does_not_own_or_that_is_open_is_ignored) {
  folder_of(kStranger, 0750, "theirs");
  EXPECT_EQ(distrust_of_folder(folder_of(kStranger, 0750, "theirs/a"), FolderKind::System), "owned by user 12350");
  EXPECT_EQ(distrust_of_folder(folder_of(0, 0770, "b"), FolderKind::System), "open to other users (chmod 750 it)");
  EXPECT_EQ(distrust_of_folder(folder_of(0, 0755, "c"), FolderKind::System), "open to other users (chmod 750 it)");
  EXPECT_FALSE(distrust_of_folder(folder_of(0, 0750, "d"), FolderKind::System));
}

TEST(FolderOfSockets, a_name_that_is_none_is_ignored_and_printed_without_control_characters) {
  const TemporaryFolder folder;
  const std::string sockets = folder.path() + "/s";
  auto claim = SocketClaim::take({"", "", sockets}, "robot");
  ASSERT_TRUE(claim);
  const std::ofstream odd{sockets + "/robot\x1b[2J\xc2\x9b.sock"};
  std::vector<Problem> ignored;
  const auto found = running_containers({"", "", sockets}, &ignored);
  ASSERT_EQ(found.size(), 1U);
  ASSERT_EQ(ignored.size(), 1U);
  EXPECT_NE(ignored[0].text().find("robot\\x1b[2J\\xc2\\x9b.sock"), std::string::npos) << ignored[0].text();
  EXPECT_EQ(ignored[0].text().find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace nacelle::control
