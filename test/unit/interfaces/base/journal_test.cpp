// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/journal.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>

#include "support/allocation_guard.hpp"

namespace nacelle {
namespace {

using Fields = std::map<std::string, std::string>;

/// A journal of the test: a socket, and a file that stands for stderr.
class JournalTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path().c_str(), sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    stream_ = ::open((folder_ + "/stderr").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  }
  ~JournalTest() override {
    ::close(socket_);
    ::close(stream_);
    std::filesystem::remove_all(folder_);
  }
  [[nodiscard]] std::string path() const { return folder_ + "/socket"; }
  [[nodiscard]] std::string name_of_stream() const {
    struct stat file {};
    EXPECT_EQ(::fstat(stream_, &file), 0);
    return std::to_string(file.st_dev) + ":" + std::to_string(file.st_ino);
  }
  [[nodiscard]] std::optional<Journal> journal() const {
    return Journal::behind(name_of_stream().c_str(), stream_, path());
  }
  /// Reads an entry as systemd-journald does: "name\n", the length in 64 bits, the value, "\n".
  [[nodiscard]] Fields receive() const {
    std::string bytes(100'000, '\0');
    const auto size = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    EXPECT_GE(size, 0) << "no entry";
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    Fields fields;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t end = bytes.find('\n', at);
      std::uint64_t length = 0;
      for (unsigned i = 0; i < 8; ++i)
        length |= std::uint64_t{static_cast<unsigned char>(bytes.at(end + 1 + i))} << (8 * i);
      fields[bytes.substr(at, end - at)] = bytes.substr(end + 9, length);
      at = end + 9 + length;
      EXPECT_EQ(bytes.at(at), '\n');
      ++at;
    }
    return fields;
  }

 private:
  std::string folder_ = (std::filesystem::temp_directory_path() / "nacelle-journal-XXXXXX").string();
  int socket_ = -1;

 protected:
  int stream_ = -1;
};

TEST_F(JournalTest, a_line_is_an_entry_with_its_node_component_and_place) {
  const auto journal = this->journal();
  ASSERT_TRUE(journal);

  ASSERT_TRUE(journal->send(LogLevel::Warn, "robot1.lidar", "no frame", {"lidar.cpp", "read", 12},
                            {"/robot1/lidar", "/robot1/lidar"}));

  EXPECT_EQ(receive(), (Fields{{"MESSAGE", "[robot1.lidar] no frame"},
                               {"PRIORITY", "4"},
                               {"SYSLOG_IDENTIFIER", "nacelle"},
                               {"NACELLE_LOGGER", "robot1.lidar"},
                               {"NACELLE_NODE", "/robot1/lidar"},
                               {"NACELLE_COMPONENT", "/robot1/lidar"},
                               {"CODE_FILE", "lidar.cpp"},
                               {"CODE_LINE", "12"},
                               {"CODE_FUNC", "read"}}));
}

TEST_F(JournalTest, lines_of_a_value_stay_in_their_field_and_control_characters_are_escaped) {
  ASSERT_TRUE(journal()->send(LogLevel::Error, "a", "one\nPRIORITY=0\n\x1b[2J", {}, {}));

  EXPECT_EQ(receive(), (Fields{{"MESSAGE", "[a] one\nPRIORITY=0\n\\x1b[2J"},
                               {"PRIORITY", "3"},
                               {"SYSLOG_IDENTIFIER", "nacelle"},
                               {"NACELLE_LOGGER", "a"}}));
}

TEST_F(JournalTest, a_text_that_is_too_long_is_cut_between_characters_and_marked) {
  std::string text(Journal::kLongestText - 1, 'x');
  text += "\xc3\xa9 and more";

  ASSERT_TRUE(journal()->send(LogLevel::Info, "a", text, {}, {}));

  EXPECT_EQ(receive()["MESSAGE"], "[a] " + std::string(Journal::kLongestText - 1, 'x') + " ... (truncated)");
}

TEST_F(JournalTest, is_used_only_if_stderr_goes_there) {
  EXPECT_FALSE(Journal::behind(nullptr, stream_, path()));
  EXPECT_FALSE(Journal::behind("1:1", stream_, path()));
  EXPECT_FALSE(Journal::behind((name_of_stream() + "7").c_str(), stream_, path()));
  EXPECT_FALSE(Journal::behind("", stream_, path()));
  EXPECT_FALSE(Journal::behind(":", stream_, path()));
  EXPECT_TRUE(Journal::behind(name_of_stream().c_str(), stream_, path()));
}

TEST_F(JournalTest, a_line_is_refused_if_no_journal_listens) {
  const auto journal = Journal::behind(name_of_stream().c_str(), stream_, path() + "-without-a-listener");
  ASSERT_TRUE(journal);
  EXPECT_FALSE(journal->send(LogLevel::Info, "a", "text", {}, {}));
}

TEST_F(JournalTest, a_line_allocates_nothing) {
  const auto journal = this->journal();
  const test::AllocationGuard guard;
  EXPECT_TRUE(
      journal->send(LogLevel::Warn, "ekf", "a line of the usual length", {"ekf.cpp", "update", 7}, {"/ekf", "/ekf"}));
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace nacelle
