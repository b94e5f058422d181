// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace nacelle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FilesTest : public ::testing::Test {
 protected:
  FilesTest() {
    std::string pattern = (fs::temp_directory_path() / "nacelle_files_XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~FilesTest() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

/// While it lives, a file may have that many bytes, and a write beyond them is an error (see refuse_oversized_files_without_signal).
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(FilesTest, reads_back_what_was_written) {
  for (const std::string& text : {std::string{}, std::string{"a\0b\n", 4}, std::string(100'000, 'x')}) {
    ASSERT_TRUE(write_whole_file(at("a"), text));

    EXPECT_EQ(read_regular_file(at("a")).value(), text);
  }
}

TEST_F(FilesTest, reads_files_whose_size_is_not_known_before) {
  EXPECT_THAT(read_regular_file("/proc/self/status").value(), HasSubstr("VmSize"));
}

// A FIFO without a writer would be waited for: the test would not end.
TEST_F(FilesTest, refuses_what_is_no_regular_file_at_once) {
  ASSERT_EQ(::mkfifo(at("fifo").c_str(), 0600), 0);

  EXPECT_EQ(read_regular_file(at("fifo")).error().text(),
            at("fifo") + ": cannot be read: it is a FIFO; give a regular file");
  EXPECT_EQ(read_regular_file(at("fifo")).error().code, FileFault::NotRegular);
  EXPECT_EQ(read_regular_file("/dev/zero").error().code, FileFault::NotRegular);
  EXPECT_EQ(read_regular_file(folder_.string()).error().code, FileFault::NotRegular);
}

TEST_F(FilesTest, refuses_a_file_above_the_limit) {
  ASSERT_TRUE(write_whole_file(at("a"), std::string(1001, 'x')));

  EXPECT_TRUE(read_regular_file(at("a"), 1001));
  const Problem refusal = read_regular_file(at("a"), 1000).error();
  EXPECT_EQ(refusal.code, FileFault::TooLarge);
  EXPECT_EQ(refusal.where, Place(at("a"), 0));
  EXPECT_EQ(refusal.what, "has more than 1000 bytes, the limit for such a file");
  EXPECT_EQ(read_regular_file("/proc/self/maps", 10).error().code, FileFault::TooLarge);
  ASSERT_EQ(::truncate(at("a").c_str(), 1 << 30), 0);
  EXPECT_EQ(read_regular_file(at("a")).error().what, "has more than 16 MiB, the limit for such a file");
}

TEST_F(FilesTest, names_the_reason_why_a_file_cannot_be_read) {
  EXPECT_EQ(read_regular_file(at("none")).error().code, FileFault::NotFound);
  EXPECT_EQ(read_regular_file(at("none")).error().where, Place(at("none"), 0));
  EXPECT_EQ(read_regular_file(at("none")).error().text(),
            at("none") + ": cannot be read: No such file or directory; is the path right?");
}

TEST_F(FilesTest, replaces_a_file_and_keeps_its_mode_and_the_link_to_it) {
  ASSERT_TRUE(write_whole_file(at("a"), "old"));
  ASSERT_EQ(::chmod(at("a").c_str(), 0640), 0);
  fs::create_symlink("a", at("link"));

  ASSERT_TRUE(write_whole_file(at("link"), "new"));

  EXPECT_EQ(read_regular_file(at("a")).value(), "new");
  EXPECT_TRUE(fs::is_symlink(at("link")));
  EXPECT_EQ(fs::status(at("a")).permissions(), static_cast<fs::perms>(0640));
  EXPECT_EQ(file_count(), 2U);
}

TEST_F(FilesTest, leaves_the_old_file_and_no_other_when_there_is_no_room) {
  ASSERT_TRUE(write_whole_file(at("a"), "old"));
  const FileSizeLimit limit{1000};

  const auto over = write_whole_file(at("a"), std::string(2000, 'x'));
  const auto fresh = write_whole_file(at("b"), std::string(2000, 'x'));

  EXPECT_EQ(over.error().code, FileFault::NoRoom);
  EXPECT_EQ(fresh.error().code, FileFault::NoRoom);
  EXPECT_EQ(read_regular_file(at("a")).value(), "old");
  EXPECT_EQ(file_count(), 1U);
}

TEST_F(FilesTest, names_the_reason_why_a_file_cannot_be_written) {
  EXPECT_EQ(write_whole_file("/dev/full", "x").error().code, FileFault::NoRoom);
  EXPECT_EQ(write_whole_file(at("none/a"), "x").error().code, FileFault::NotFound);
  EXPECT_EQ(write_whole_file(folder_.string(), "x").error().code, FileFault::NotRegular);
  EXPECT_EQ(write_whole_file("/dev/full", "x").error().text(),
            "/dev/full: cannot be written: No space left on device; make room, or give another place");
}

TEST(FileFault, has_a_code_for_what_a_reader_or_writer_can_do_about_it) {
  for (const int error : {EACCES, EPERM, EROFS})
    EXPECT_EQ(file_fault_of(error, FileFault::Unwritable), FileFault::NotPermitted) << error;
  for (const int error : {ENOSPC, EDQUOT, EFBIG})
    EXPECT_EQ(file_fault_of(error, FileFault::Unwritable), FileFault::NoRoom) << error;
  EXPECT_EQ(file_fault_of(EIO, FileFault::Unreadable), FileFault::Unreadable);
  EXPECT_STREQ(code_text(file_fault_of(EIO, FileFault::Unwritable)), "file.unwritable");
}

TEST_F(FilesTest, writes_to_a_device_and_leaves_it_one) {
  ASSERT_TRUE(write_whole_file("/dev/null", "x"));

  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace nacelle
