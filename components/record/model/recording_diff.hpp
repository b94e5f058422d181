// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "record/model/message_diff.hpp"
#include "record/model/ordered_messages.hpp"
#include "record/model/tolerances.hpp"

namespace nacelle::record {

/// What two recordings have of a topic. Messages are numbered from 0; times are those of the log, in ns since the Unix epoch.
struct TopicDiff {
  struct First {
    std::uint64_t number = 0;
    std::uint64_t time_a = 0, time_b = 0;
    ValueDifference value;  ///< Without a path if whole messages were compared.
  };

  std::string name, type_a, type_b;  ///< A type is empty if the recording has no such topic.
  std::uint64_t in_a = 0, in_b = 0;
  std::uint64_t equal = 0, different = 0;  ///< Of the pairs.
  std::optional<First> first;
  std::map<std::string, FieldDifference> fields;  ///< As MessageDiff::fields().
  std::string remark;                             ///< Why messages were compared by their bytes; empty: they were not.

  [[nodiscard]] bool is_equal() const { return in_a == in_b && different == 0 && (type_a == type_b || in_a == 0); }
};

/// Compares two recordings: the n-th message of a topic in one with the n-th in the other. Times are not compared.
///
/// Messages of types that are not known, or that were recorded with another definition, are compared by their bytes.
/// Holds those messages that the other recording has later, at most `pairs` of a topic. Threads: one.
class RecordingDiff {
 public:
  /// Returns the type with this name; null if it is not known. It must outlive the comparison.
  using FindType = std::function<const msgs::MessageType*(const std::string& name)>;
  struct Topic {
    std::string type;  ///< Empty: there is no such topic.
    std::string hash;  ///< RIHS01_...; empty: not recorded.
    std::uint64_t messages = 0;
  };

  RecordingDiff(const Tolerances& tolerances, FindType find_type)
      : tolerances_(tolerances), find_type_(std::move(find_type)) {}
  /// Adds a topic that is to be compared. Errors: a tolerance whose path leads to no field.
  [[nodiscard]] Result<void, Problem> add_topic(const std::string& name, const Topic& in_a, const Topic& in_b);
  /// Reads both to their ends; topics that were not added are left out.
  void run(OrderedMessages& a, OrderedMessages& b);
  /// By name.
  [[nodiscard]] std::vector<TopicDiff> topics() const;

 private:
  struct Waiting {
    std::uint64_t time = 0;
    Bytes bytes;
  };
  struct Pairing {
    TopicDiff result;
    std::uint64_t pairs = 0, done = 0;
    std::uint64_t seen[2] = {};
    std::deque<Waiting> waiting[2];  // one of them is empty
    std::unique_ptr<MessageDiff> diff;
    std::unique_ptr<msgs::AnyMessage> a, b;
  };
  void take(std::size_t side, const std::string& topic, const OrderedMessages::Message& message);
  static void compare(Pairing& pairing, std::uint64_t time_a, ByteView a, std::uint64_t time_b, ByteView b);

  const Tolerances& tolerances_;
  const FindType find_type_;
  std::map<std::string, Pairing> topics_;
};

}  // namespace nacelle::record
