// SPDX-License-Identifier: Apache-2.0
// Any text as a calibration file: it is refused with a place and a reason, or every number in it is finite and it reads back from
// what is written of it.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "camera/protocol/camera_info_writer.hpp"
#include "camera/protocol/camera_info_yaml.hpp"
#include "nacelle/base/bytes.hpp"

namespace {
void require(bool holds) {
  if (!holds) std::abort();
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = nacelle::camera::parse_camera_info(nacelle::as_text({data, size}), "any.yaml");
  if (!read) {
    require(read.error().where.file == "any.yaml" && !read.error().what.empty());
    return 0;
  }
  const auto finite = [](const auto& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); });
  };
  const auto& info = read.value().info;
  require(finite(info.k) && finite(info.d) && finite(info.r) && finite(info.p));
  require(info.d.size() == 4 || info.d.size() == 5 || info.d.size() == 8);
  require(nacelle::camera::check_camera_info(info, info.width, info.height).has_value());
  const auto again =
      nacelle::camera::parse_camera_info(nacelle::camera::camera_info_yaml(read.value()), "written.yaml");
  require(again.has_value() && again->info == info && again->camera_name == read->camera_name);
  return 0;
}
