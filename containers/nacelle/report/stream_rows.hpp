// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace nacelle::report {

/// A row for a stream in output for users.
template <typename Json>
struct StreamRow {
  std::string label;  ///< Its name; with the type if two rows have that name: "/cmd_vel Twist".
  const Json* stream;
};

/// Returns what tells a stream from the others: Twist and TwistStamped share /cmd_vel.
template <typename Json>
[[nodiscard]] std::string stream_key(const Json& stream) {
  return stream["name"].template get<std::string>() + " " + stream["type"].template get<std::string>();
}

/// Returns one row for each stream of a JSON list with "name", "type" and "published". If a name has two types (as
/// cmd_vel does) and only one of them has messages, the other is left out. The rows point into the list.
template <typename Json>
[[nodiscard]] std::vector<StreamRow<Json>> rows_of(const Json& streams) {
  const auto text = [](const Json& stream, const char* key) { return stream[key].template get<std::string>(); };
  const auto sent = [](const Json& stream) { return stream["published"] != 0; };
  std::vector<StreamRow<Json>> rows;
  for (const Json& stream : streams) {
    const std::string name = text(stream, "name");
    const auto twin = std::find_if(streams.begin(), streams.end(),
                                   [&](const Json& other) { return &other != &stream && text(other, "name") == name; });
    const bool alone = twin == streams.end();
    if (!alone && sent(stream) == sent(*twin)) {
      const std::string type = text(stream, "type");
      rows.push_back({name + " " + type.substr(type.rfind('/') + 1), &stream});
    } else if (alone || sent(stream)) {
      rows.push_back({name, &stream});
    }
  }
  return rows;
}

}  // namespace nacelle::report
