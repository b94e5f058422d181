// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/bytes.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "support/places.hpp"

#include <nlohmann/json.hpp>

#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace nacelle::test {

/// One row of test/data/vectors/cdr_vectors_core.json.
struct Vector {
  std::string type, sample, hash;
  nlohmann::json values;
  Bytes bytes;
};

inline std::vector<Vector> golden_vectors() {
  std::ifstream file{test::data("vectors/cdr_vectors_core.json")};
  std::vector<Vector> vectors;
  const auto document = nlohmann::json::parse(file);
  for (const auto& row : document.at("vectors")) {
    Vector vector{row.at("type"), row.at("sample"), row.at("type_hash"), row.at("values"), {}};
    if (!from_hex(row.at("cdr_hex").get<std::string>(), vector.bytes)) vector.bytes.clear();
    vectors.push_back(std::move(vector));
  }
  return vectors;
}

/// The folder of the library of test/data/own_interfaces.
inline std::string own_message_libraries() { return test::built("test/own_interfaces"); }

/// Every message package of this build.
inline msgs::TypeLibrary& type_library() {
  static msgs::TypeLibrary library{{test::message_libraries(), own_message_libraries()}};
  return library;
}

inline const msgs::MessageType& message_type(const std::string& name) {
  const auto found = type_library().message(name);
  if (!found) throw std::runtime_error(found.error().text());
  return *found.value();
}

inline std::string to_json(const msgs::AnyMessage& message) { return msgs::to_json(message.type(), message.get()); }

}  // namespace nacelle::test
