// SPDX-License-Identifier: Apache-2.0
#include "record/port/sqlite_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "nacelle/base/file_fault.hpp"
#include "nacelle/io/descriptor.hpp"
#include "record/port/recording_file.hpp"
#include "record/port/sqlite_fault.hpp"

namespace nacelle::record {
namespace {

// Source: https://www.sqlite.org/fileformat2.html, sections 1.3 and 3; the bytes of locks: SQLite's os.h.
constexpr std::string_view kMagic{"SQLite format 3\0", 16};
constexpr std::string_view kJournalMagic{"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", 8};
constexpr off_t kLocks = 0x40000000, kLockBytes = 512;
constexpr int kMostMessageBytes = 1'000'000'000;  // SQLite's own limit, unless it was built with another

Problem problem(const std::string& path, SqliteFault fault, std::string what, std::string advice = "") {
  return {Place{path, 0}, std::move(what), std::move(advice), fault, ""};
}

bool begins_with(const std::string& path, std::string_view magic) {
  const auto file = FileSource::open(path);
  std::string head(magic.size(), '\0');
  return file && (*file)->size() >= magic.size() &&
         (*file)->read_at(0, {reinterpret_cast<std::uint8_t*>(head.data()), head.size()}) && head == magic;
}

bool is_written_by_another(const std::string& path) {
  const io::Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  struct flock lock {};
  lock.l_type = F_RDLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = kLocks;
  lock.l_len = kLockBytes;
  return file.is_open() && ::fcntl(file.number(), F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

/// `immutable` makes SQLite ignore locks and journals, which is right only if there are none.
std::optional<Problem> unsettled(const std::string& path) {
  const char* const kAdvice = "wait for its writer; if it was killed, open a copy once with `ros2 bag info` or sqlite3";
  struct stat status {};
  if (is_written_by_another(path)) return problem(path, SqliteFault::Locked, "is written by another program", kAdvice);
  if (::stat((path + "-wal").c_str(), &status) == 0 && status.st_size > 0)
    return problem(path, SqliteFault::Unfinished, "a part of it is still in the journal " + path + "-wal", kAdvice);
  if (begins_with(path + "-journal", kJournalMagic))
    return problem(path, SqliteFault::Unfinished, "was not finished: it has the journal " + path + "-journal", kAdvice);
  return std::nullopt;
}

std::string uri_of(const std::string& path) {
  std::string uri = path.rfind('/', 0) == 0 ? "file://" : "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri + "?mode=ro&immutable=1";
}

struct Finalize {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, Finalize>;

Statement prepare(sqlite3* database, const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr);
  return Statement{statement};
}

/// Empty for anything but a text.
std::string text_of(sqlite3_stmt* row, int column) {
  if (sqlite3_column_type(row, column) != SQLITE_TEXT) return "";
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? "" : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
}

void harden(sqlite3* database) {
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  for (const int off : {SQLITE_DBCONFIG_TRUSTED_SCHEMA, SQLITE_DBCONFIG_ENABLE_VIEW, SQLITE_DBCONFIG_ENABLE_TRIGGER})
    sqlite3_db_config(database, off, 0, nullptr);
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kMostMessageBytes);
  sqlite3_limit(database, SQLITE_LIMIT_SQL_LENGTH, 100'000);
  sqlite3_limit(database, SQLITE_LIMIT_COLUMN, 100);
  sqlite3_limit(database, SQLITE_LIMIT_EXPR_DEPTH, 20);
  sqlite3_exec(database, "PRAGMA temp_store=memory; PRAGMA cell_size_check=on; PRAGMA mmap_size=0", nullptr, nullptr,
               nullptr);
}

}  // namespace

void SqliteFile::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }
void SqliteFile::Close::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

/// Reads what precedes the messages.
class SqliteFile::Loader {
 public:
  Loader(SqliteFile& file, const std::string& path) : file_(file), path_(path) {}

  std::optional<Problem> load() {
    for (const auto& [table, column] :
         std::initializer_list<std::pair<const char*, const char*>>{{"topics", "id"},
                                                                    {"topics", "name"},
                                                                    {"topics", "type"},
                                                                    {"topics", "serialization_format"},
                                                                    {"messages", "id"},
                                                                    {"messages", "topic_id"},
                                                                    {"messages", "timestamp"},
                                                                    {"messages", "data"}}) {
      if (has(table, column)) continue;
      if (sqlite3_errcode(database()) != SQLITE_ERROR) return unreadable();
      return problem(path_, SqliteFault::NotBag, fmt::format("has no table '{}' with a column '{}'", table, column),
                     "name a recording of `ros2 bag record --storage sqlite3`");
    }
    if (auto wrong = look_for_compression()) return wrong;
    if (auto wrong = load_definitions()) return wrong;
    return load_topics();
  }

 private:
  sqlite3* database() { return file_.database_.get(); }

  bool has(const char* table, const char* column) {
    return sqlite3_table_column_metadata(database(), "main", table, column, nullptr, nullptr, nullptr, nullptr,
                                         nullptr) == SQLITE_OK;
  }
  Problem unreadable() {
    return problem(path_, SqliteFault::Unreadable, fmt::format("cannot be read: {}", sqlite3_errmsg(database())));
  }

  /// Calls `each(row)` for all rows; it returns false if they are too many.
  template <class Each>
  std::optional<Problem> for_rows(const std::string& sql, Each&& each) {
    const Statement rows = prepare(database(), sql);
    if (!rows) return unreadable();
    for (;;) {
      const int code = sqlite3_step(rows.get());
      if (code == SQLITE_DONE) return std::nullopt;
      if (code != SQLITE_ROW) return unreadable();
      for (int column = 0; column < sqlite3_column_count(rows.get()); ++column) {
        const int type = sqlite3_column_type(rows.get(), column);
        if (type == SQLITE_TEXT || type == SQLITE_BLOB)
          text_bytes_ += static_cast<std::size_t>(sqlite3_column_bytes(rows.get(), column));
      }
      if (text_bytes_ > kMostTextBytes || !each(rows.get()))
        return problem(
            path_, SqliteFault::TooLarge,
            fmt::format("has more than {} topics, or than {} MiB of their texts", kMostTopics, kMostTextBytes >> 20U));
    }
  }

  std::optional<Problem> look_for_compression() {
    if (!has("metadata", "metadata")) return std::nullopt;
    std::string last;
    auto wrong = for_rows("SELECT metadata FROM metadata", [&](sqlite3_stmt* row) {
      last = text_of(row, 0);
      return true;
    });
    if (wrong) return wrong;
    std::transform(last.begin(), last.end(), last.begin(),
                   [](unsigned char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
    if (last.find("compression_mode: message") == std::string::npos) return std::nullopt;
    return problem(path_, SqliteFault::Compressed, "its messages are compressed one by one, which is not supported",
                   "convert it with `ros2 bag convert` first");
  }

  std::optional<Problem> load_definitions() {
    if (!has("message_definitions", "topic_type") || !has("message_definitions", "encoding") ||
        !has("message_definitions", "encoded_message_definition"))
      return std::nullopt;
    return for_rows("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions",
                    [&](sqlite3_stmt* row) {
                      BagDefinition one{text_of(row, 0), text_of(row, 1), text_of(row, 2)};
                      if ((one.encoding == "ros2msg" || one.encoding == "ros2idl") && !one.text.empty())
                        file_.definitions_.push_back(std::move(one));
                      return file_.definitions_.size() <= kMostTopics;
                    });
  }

  std::optional<Problem> load_topics() {
    const char* const qos = has("topics", "offered_qos_profiles") ? "offered_qos_profiles" : "NULL";
    const char* const hash = has("topics", "type_description_hash") ? "type_description_hash" : "NULL";
    std::optional<Problem> wrong_topic;
    auto wrong = for_rows(fmt::format("SELECT id, name, type, serialization_format, {}, {} FROM topics", qos, hash),
                          [&](sqlite3_stmt* row) {
                            BagRowTopic topic{sqlite3_column_int64(row, 0),
                                              text_of(row, 1),
                                              text_of(row, 2),
                                              text_of(row, 3),
                                              text_of(row, 4),
                                              text_of(row, 5)};
                            if (topic.name.empty() || topic.type.empty() || topic.format.empty())
                              wrong_topic =
                                  problem(path_, SqliteFault::NotBag,
                                          fmt::format("topic {} has no name, no type or no format", topic.id));
                            file_.topics_.push_back(std::move(topic));
                            return file_.topics_.size() <= kMostTopics;
                          });
    return wrong ? wrong : wrong_topic;
  }

  SqliteFile& file_;
  const std::string& path_;
  std::size_t text_bytes_ = 0;
};

BagRows::Step SqliteFile::next(BagMessage& message) {
  if (!messages_)
    messages_.reset(prepare(database_.get(), "SELECT id, topic_id, timestamp, data FROM messages").release());
  if (!messages_) return Step::Unreadable;
  sqlite3_stmt* const row = messages_.get();
  switch (sqlite3_step(row)) {
    case SQLITE_ROW: break;
    case SQLITE_DONE: return Step::End;
    case SQLITE_CORRUPT: return Step::Damaged;
    case SQLITE_TOOBIG:
    case SQLITE_NOMEM: return Step::TooLarge;
    default: return Step::Unreadable;
  }
  message = {};
  message.row = sqlite3_column_int64(row, 0);
  if (sqlite3_column_type(row, 1) == SQLITE_INTEGER) message.topic_id = sqlite3_column_int64(row, 1);
  if (sqlite3_column_type(row, 2) == SQLITE_INTEGER) message.time = sqlite3_column_int64(row, 2);
  if (sqlite3_column_type(row, 3) == SQLITE_BLOB) {
    const auto* const data = static_cast<const std::uint8_t*>(sqlite3_column_blob(row, 3));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(row, 3));
    if (data == nullptr && size > 0) return Step::TooLarge;  // memory has run out
    message.data = ByteView{data, size};
  }
  return Step::Row;
}

Result<std::unique_ptr<SqliteFile>, Problem> SqliteFile::open(const std::string& path) {
  const auto file = FileSource::open(path);
  if (!file) return err(file.error());
  if (!begins_with(path, kMagic))
    return err(problem(path, SqliteFault::NotDatabase, "is no SQLite 3 database", "name a recording"));
  if (auto wrong = unsettled(path)) return err(std::move(*wrong));

  std::unique_ptr<SqliteFile> opened{new SqliteFile};
  opened->size_ = (*file)->size();
  sqlite3* database = nullptr;
  constexpr int kFlags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(uri_of(path).c_str(), &database, kFlags, nullptr);
  opened->database_.reset(database);
  if (code != SQLITE_OK)
    return err(problem(path, SqliteFault::Unreadable, fmt::format("cannot be opened: {}", sqlite3_errstr(code))));
  harden(database);
  if (auto wrong = Loader{*opened, path}.load()) return err(std::move(*wrong));
  return opened;
}

}  // namespace nacelle::record
