// SPDX-License-Identifier: Apache-2.0
#include "record/port/sqlite_file.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "nacelle/base/file_fault.hpp"
#include "record/port/sqlite_fault.hpp"
#include "seen_rows.hpp"

namespace nacelle::record {
namespace {

constexpr const char* kMessages =
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
    "NOT "
    "NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
constexpr const char* kTopics =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT "
    "NULL, offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);"
    "INSERT INTO topics VALUES(3, '/a', 'std_msgs/msg/String', 'cdr', '- depth: 1', 'RIHS01_0');";
constexpr const char* kDefinitions =
    "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL, "
    "encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);"
    "INSERT INTO message_definitions VALUES(1, 'std_msgs/msg/String', 'ros2msg', 'string data', 'RIHS01_0');";
constexpr const char* kMetadata =
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);";
constexpr const char* kTwo =
    "INSERT INTO messages VALUES(1, 3, 20, x'6869'); INSERT INTO messages VALUES(2, 3, 10, x'');";

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};

class SqliteFileTest : public ::testing::Test {
 protected:
  SqliteFileTest() {
    char name[] = "/tmp/sqlite_file_test.XXXXXX";
    folder_ = ::mkdtemp(name);
  }
  ~SqliteFileTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name = "bag#1 50%?.db3") const { return (folder_ / name).string(); }
  /// Runs the statements, and leaves the database open.
  std::unique_ptr<sqlite3, Close> write(const std::string& sql) const {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(path().c_str(), &database), SQLITE_OK);
    std::unique_ptr<sqlite3, Close> owner{database};
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    return owner;
  }
  void write_bytes(const std::string& name, const std::string& bytes) const {
    std::ofstream{path(name), std::ios::binary} << bytes;
  }
  /// The code of the problem; "" if there is none.
  std::string problem() const {
    const auto file = SqliteFile::open(path());
    return file ? "" : std::string{file.error().code.text()};
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator{folder_})
      all.push_back(entry.path().filename().string());
    return all;
  }

  std::filesystem::path folder_;
};

TEST_F(SqliteFileTest, reads_schema_version_4) {
  write(std::string{kMessages} + kTopics + kDefinitions + kMetadata + kTwo);
  auto file = SqliteFile::open(path());
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ((*file)->size(), std::filesystem::file_size(path()));
  const SeenRows seen{**file, nullptr};
  EXPECT_TRUE(seen.complete);
  EXPECT_EQ(seen.lines,
            (std::vector<std::string>{"header ros2", "schema 1 std_msgs/msg/String ros2msg string data",
                                      "channel 1 of 1 /a cdr offered_qos_profiles=- depth: 1 topic_type_hash=RIHS01_0",
                                      "message 1 at 20: hi", "message 1 at 10: "}));
  EXPECT_EQ((SeenRows{**file, nullptr}.lines), seen.lines);
  EXPECT_EQ(names().size(), 1U) << "nothing is written beside it";
}

TEST_F(SqliteFileTest, reads_a_closed_file_in_wal_mode_and_leaves_nothing_beside_it) {
  write(std::string{"PRAGMA journal_mode=wal;"} + kMessages + kTopics + kTwo);
  ASSERT_EQ(names().size(), 1U);
  auto file = SqliteFile::open(path());
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ((SeenRows{**file, nullptr}.lines.size()), 5U);
  EXPECT_EQ(names().size(), 1U);
}

TEST_F(SqliteFileTest, reads_old_files_without_definitions_hashes_and_qos_profiles) {
  write(std::string{kMessages} +
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
        "INSERT INTO topics VALUES(3, '/a', 'std_msgs/msg/String', 'cdr');" +
        kTwo);
  auto file = SqliteFile::open(path());
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ((SeenRows{**file, nullptr}.lines[2]), "channel 1 of 1 /a cdr");
}

TEST_F(SqliteFileTest, refuses_what_is_no_recording) {
  EXPECT_EQ(problem(), code_text(FileFault::NotFound));
  write_bytes("bag#1 50%?.db3", "");
  EXPECT_EQ(problem(), "sqlite.not_database");
  write_bytes("bag#1 50%?.db3", std::string(4096, 'x'));
  EXPECT_EQ(problem(), "sqlite.not_database");
  write_bytes("bag#1 50%?.db3", std::string{"SQLite format 3\0", 16} + std::string(4096, 'x'));
  EXPECT_EQ(problem(), "sqlite.unreadable");
  std::filesystem::remove(path());
  write("CREATE TABLE words(word TEXT);");
  EXPECT_EQ(problem(), "sqlite.not_bag");
  write(kTopics);
  EXPECT_EQ(problem(), "sqlite.not_bag") << "no table of messages";
  write("CREATE VIEW messages AS SELECT 1 AS id, 3 AS topic_id, 1 AS timestamp, x'' AS data;");
  EXPECT_EQ(problem(), "sqlite.not_bag") << "a view is no table";
}

TEST_F(SqliteFileTest, refuses_topics_without_a_name) {
  write(std::string{kMessages} +
        "CREATE TABLE topics(id, name, type, serialization_format);"
        "INSERT INTO topics VALUES(3, NULL, 'std_msgs/msg/String', 'cdr');");
  EXPECT_EQ(problem(), "sqlite.not_bag");
}

TEST_F(SqliteFileTest, refuses_texts_that_are_too_large) {
  write(std::string{kMessages} + kTopics +
        "INSERT INTO topics VALUES(4, '/b', 'x', 'cdr', printf('%.*c', 70000000, 'x'), '');");
  EXPECT_EQ(problem(), "sqlite.too_large");
}

TEST_F(SqliteFileTest, refuses_messages_that_are_compressed_one_by_one) {
  write(std::string{kMessages} + kTopics + kMetadata +
        "INSERT INTO metadata VALUES(1, 9, 'compression_format: zstd\ncompression_mode: MESSAGE');");
  EXPECT_EQ(problem(), "sqlite.compressed");
}

TEST_F(SqliteFileTest, refuses_a_file_whose_journal_is_not_played_back) {
  const auto writer = write(std::string{"PRAGMA journal_mode=wal;"} + kMessages + kTopics + kTwo);
  EXPECT_EQ(problem(), "sqlite.unfinished") << "a part of it is in the write-ahead log";
}

TEST_F(SqliteFileTest, refuses_a_file_with_a_hot_journal) {
  write(std::string{kMessages} + kTopics);
  EXPECT_EQ(problem(), "");
  write_bytes("bag#1 50%?.db3-journal", std::string(512, '\0'));
  EXPECT_EQ(problem(), "") << "a journal that was emptied";
  write_bytes("bag#1 50%?.db3-journal", std::string{"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", 8});
  EXPECT_EQ(problem(), "sqlite.unfinished");
}

TEST_F(SqliteFileTest, reports_rows_that_are_no_messages_and_damage) {
  write("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);" + std::string{kTopics} +
        "INSERT INTO messages VALUES(1, 3, 20, NULL); INSERT INTO messages VALUES(2, 3, 'noon', x'00');"
        "INSERT INTO messages VALUES(3, 3, 20, 'text'); INSERT INTO messages VALUES(4, 3, 20, zeroblob(100000));");
  {
    auto file = SqliteFile::open(path());
    ASSERT_TRUE(file) << file.error().text();
    const SeenRows seen{**file, nullptr};
    EXPECT_TRUE(seen.complete);
    EXPECT_EQ(seen.problems.size(), 3U);
  }
  const auto size = std::filesystem::file_size(path());
  {
    std::fstream bytes{path(), std::ios::binary | std::ios::in | std::ios::out};
    bytes.seekp(static_cast<std::streamoff>(size - std::size_t{3} * 4096));
    bytes << std::string(std::size_t{3} * 4096, '\0');
  }
  auto file = SqliteFile::open(path());
  ASSERT_TRUE(file) << file.error().text();
  const SeenRows seen{**file, nullptr};
  EXPECT_FALSE(seen.complete);
  ASSERT_EQ(seen.problems.size(), 4U);
  EXPECT_EQ(seen.problems.back(), (std::pair{McapFault::Truncated, std::uint64_t{3}}));
  std::filesystem::resize_file(path(), size - 4096);
  EXPECT_EQ(problem(), "sqlite.unreadable");
}

}  // namespace
}  // namespace nacelle::record
