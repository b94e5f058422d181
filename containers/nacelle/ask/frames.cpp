// SPDX-License-Identifier: Apache-2.0
#include "ask/frames.hpp"

#include "nacelle/spatial/rotation.hpp"

namespace nacelle::ask {

using nlohmann::json;

Result<json, Problem> list_frames(Nodes& nodes, const std::string& container) {
  auto answer = nodes.ask_container(container, "get_frames", "nacelle_interfaces/srv/GetFrames");
  if (!answer) return answer;
  for (json& row : answer.value()["frames"]) {
    row["static"] = row["is_static"];
    row.erase("is_static");
    if (row["clock_skew"].get_ref<const std::string&>().empty()) row.erase("clock_skew");
  }
  return answer;
}

Result<json, Problem> lookup_transform(Nodes& nodes, const std::string& container, const std::string& target,
                                       const std::string& source) {
  const auto answer = nodes.ask_container(container, "lookup_transform", "nacelle_interfaces/srv/LookupTransform",
                                          {{"target", target}, {"source", source}});
  if (!answer) return err(answer.error());
  if (!answer.value()["success"].get<bool>()) return err(problem_of(answer.value()));
  const json& stamp = answer.value()["transform"]["header"]["stamp"];
  const json& transform = answer.value()["transform"]["transform"];
  const json& t = transform["translation"];
  const json& q = transform["rotation"];
  const auto angles = spatial::rpy_from_quaternion(
      {q["w"].get<double>(), q["x"].get<double>(), q["y"].get<double>(), q["z"].get<double>()});
  return json{{"stamp_ns", stamp["sec"].get<std::int64_t>() * 1'000'000'000 + stamp["nanosec"].get<std::int64_t>()},
              {"translation_m", {t["x"], t["y"], t["z"]}},
              {"rotation_xyzw", {q["x"], q["y"], q["z"], q["w"]}},
              {"rpy_rad", {angles.roll_rad, angles.pitch_rad, angles.yaw_rad}}};
}

}  // namespace nacelle::ask
