// SPDX-License-Identifier: Apache-2.0
#include "record/port/recording_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "nacelle/base/file_fault.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using RecordingFileTest = TemporaryFolder;

TEST_F(RecordingFileTest, has_what_was_written_and_is_never_overwritten) {
  auto sink = FileSink::create(path("a"));
  ASSERT_TRUE(sink) << sink.error().text();
  EXPECT_TRUE((*sink)->write(as_bytes("hello ")));
  EXPECT_TRUE((*sink)->write(as_bytes("world")));
  EXPECT_TRUE((*sink)->sync());
  const auto again = FileSink::create(path("a"));
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().what.find("exists"), std::string::npos);

  auto source = FileSource::open(path("a"));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->size(), 11U);
  Bytes part(5);
  EXPECT_TRUE((*source)->read_at(6, part));
  EXPECT_EQ(as_text(part), "world");
  EXPECT_FALSE((*source)->read_at(7, part)) << "beyond the end";
  ASSERT_EQ(::truncate(path("a").c_str(), 8), 0);
  EXPECT_FALSE((*source)->read_at(6, part)) << "the file shrank";
}

TEST_F(RecordingFileTest, refuses_what_is_no_file) {
  EXPECT_EQ(FileSource::open(path("none")).error().code, ProblemCode{FileFault::NotFound});
  EXPECT_EQ(FileSource::open(folder_).error().code, ProblemCode{FileFault::NotRegular});
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(FileSource::open(path("fifo")).error().code, ProblemCode{FileFault::NotRegular}) << "without a wait";
  EXPECT_EQ(FileSink::create(path("none/a")).error().code, ProblemCode{FileFault::NotFound});
}

TEST(RecordingFile, says_that_the_disk_is_full) {
  FileSink sink{io::Descriptor{::open("/dev/full", O_WRONLY | O_CLOEXEC)}, "/dev/full"};
  EXPECT_FALSE(sink.write(as_bytes("x")));
  EXPECT_EQ(sink.problem().code, ProblemCode{FileFault::NoRoom});
}

}  // namespace
}  // namespace nacelle::record
