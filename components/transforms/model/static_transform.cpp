// SPDX-License-Identifier: Apache-2.0
#include "transforms/model/static_transform.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>
#include <vector>

namespace nacelle::transforms {

Result<StaticTransform, std::string> read_static_transform(const std::string& text, const std::string& frame_prefix) {
  std::istringstream in{text};
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  if (words.size() != 8 && words.size() != 9) {
    return err(
        fmt::format("'{}' has {} words; write \"x y z yaw pitch roll parent child\" (8) or "
                    "\"x y z qx qy qz qw parent child\" (9)",
                    text, words.size()));
  }
  double numbers[7]{};
  const std::size_t count = words.size() - 2;
  for (std::size_t i = 0; i < count; ++i) {
    const char* const end = words[i].data() + words[i].size();
    const char* const begin = words[i].data() + (words[i].starts_with('+') ? 1 : 0);
    const auto read = std::from_chars(begin, end, numbers[i]);
    if (read.ec != std::errc{} || read.ptr != end || !std::isfinite(numbers[i])) {
      return err(fmt::format("'{}': '{}' (word {}) is not a finite number", text, words[i], i + 1));
    }
  }
  StaticTransform made{words[count], words[count + 1], {}};
  for (std::string* frame : {&made.parent, &made.child}) {
    const bool is_nobodys = frame->starts_with('/');
    if (is_nobodys) frame->erase(0, 1);
    if (!is_nobodys && !frame->starts_with(frame_prefix)) frame->insert(0, frame_prefix);
    if (frame->empty()) return err(fmt::format("'{}': a frame has no name", text));
  }
  if (made.parent == made.child) return err(fmt::format("'{}': parent and child are the same frame", text));
  made.X_PC.translation_m = {numbers[0], numbers[1], numbers[2]};
  if (count == 6) {
    made.X_PC.rotation = spatial::quaternion_from_rpy({numbers[5], numbers[4], numbers[3]});
  } else {
    made.X_PC.rotation = Eigen::Quaterniond{numbers[6], numbers[3], numbers[4], numbers[5]};
    if (std::abs(made.X_PC.rotation.squaredNorm() - 1.0) >= 0.01) {
      return err(fmt::format("'{}': the quaternion's length is {:.4f}, not 1", text, made.X_PC.rotation.norm()));
    }
    made.X_PC.rotation.normalize();
  }
  return made;
}

}  // namespace nacelle::transforms
