// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "record/model/field_path.hpp"
#include "record/protocol/mcap_walk.hpp"

namespace nacelle::record {

/// A field of a topic, as "/odom.pose.pose.position.x".
struct TopicField {
  std::string topic, path;
  [[nodiscard]] std::string text() const { return topic + "." + path; }
  friend bool operator==(const TopicField&, const TopicField&) = default;
};
/// Parses "/odom.pose.pose.position.x", "odom.twist.twist.linear.x". Errors: no topic or no field; `where` names the text.
[[nodiscard]] Result<TopicField, Problem> parse_topic_field(std::string_view text);

/// A value at a time, in ns since the Unix epoch.
struct TimedValue {
  std::uint64_t time = 0;
  double value = 0.0;
  friend bool operator==(const TimedValue&, const TimedValue&) = default;
};

/// Reads the values of fields from a recording: hand it to walk_mcap() with each file.
///
/// Threads: one. Allocates: for each value 16 bytes, and what messages take.
class FieldSeries final : public McapVisitor {
 public:
  using FindType = std::function<Result<const msgs::MessageType*, Problem>(const std::string& name)>;

  FieldSeries(const std::vector<TopicField>& fields, FindType find_type);

  /// Returns the values of the field with this number in `fields`, in the order of their times.
  [[nodiscard]] std::vector<TimedValue> values(std::size_t field) const;
  /// Time of the first message of any topic; 0 if there is none.
  [[nodiscard]] std::uint64_t first() const { return first_; }
  /// Checks that each field was found. Errors: an unknown topic, with the nearest one; a type that is not installed; the errors of
  /// NumericField::find(); a topic without messages, or whose messages have no such element.
  [[nodiscard]] Result<void, Problem> check() const;
  [[nodiscard]] const std::vector<McapProblem>& problems() const { return problems_; }
  /// Forgets the ids of channels and the problems, before another file of the recording.
  void begin_file();

  void on_schema(const McapSchema& schema) override;
  void on_channel(const McapChannel& channel) override;
  void on_message(const McapMessage& message, const McapSpot& spot) override;
  void on_problem(const McapProblem& problem) override;

  static constexpr std::size_t kMostProblems = 100;

 private:
  struct Series {
    TopicField field;
    std::optional<Problem> problem;
    std::vector<TimedValue> values;
    std::uint64_t messages = 0;
  };
  struct Reading {
    std::size_t series = 0;
    NumericField field;
  };
  struct Channel {
    std::optional<msgs::AnyMessage> message;
    std::vector<Reading> readings;
  };

  const FindType find_type_;
  std::vector<Series> series_;
  std::map<std::uint16_t, std::string> types_;  // of schemas
  std::map<std::uint16_t, Channel> channels_;   // with fields to read
  std::vector<std::string> topics_;
  std::vector<McapProblem> problems_;
  std::uint64_t first_ = 0;
  bool has_messages_ = false;
};

/// Returns points of `y` over `x`: each value of y beside that of x at its time, which is interpolated between two. Values of y before the
/// first and after the last of x are left out. Both are in the order of their times.
[[nodiscard]] std::vector<std::pair<double, double>> joined(const std::vector<TimedValue>& x,
                                                            const std::vector<TimedValue>& y);

}  // namespace nacelle::record
