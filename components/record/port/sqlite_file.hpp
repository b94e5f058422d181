// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "record/model/bag_rows.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace nacelle::record {

/// A recording in the SQLite 3 format of rosbag2 (`.db3`).
///
/// Nothing is written, neither to the file nor beside it, and no lock is taken. The content is hostile: views and triggers of the file
/// do not run.
/// Threads: one. Allocates: the texts of topics and definitions, and one message.
/// Source: rosbag2_storage_sqlite3, schema versions 1 to 4
class SqliteFile final : public BagRows {
 public:
  static constexpr std::size_t kMostTopics = 65'534;
  static constexpr std::size_t kMostTextBytes = std::size_t{64} << 20U;  ///< Of all topics and definitions together.

  /// Errors: a FileFault or a SqliteFault; `where` is the path.
  [[nodiscard]] static Result<std::unique_ptr<SqliteFile>, Problem> open(const std::string& path);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] const std::vector<BagRowTopic>& topics() const override { return topics_; }
  [[nodiscard]] const std::vector<BagDefinition>& definitions() const override { return definitions_; }
  void rewind() override { messages_.reset(); }
  [[nodiscard]] Step next(BagMessage& message) override;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
    void operator()(sqlite3_stmt* statement) const;
  };
  class Loader;

  SqliteFile() = default;

  std::unique_ptr<sqlite3, Close> database_;
  std::unique_ptr<sqlite3_stmt, Close> messages_;  // after the database, which it belongs to
  std::uint64_t size_ = 0;
  std::vector<BagRowTopic> topics_;
  std::vector<BagDefinition> definitions_;
};

}  // namespace nacelle::record
