// SPDX-License-Identifier: Apache-2.0
#include "look/model/service_rights.hpp"

#include <algorithm>
#include <array>

namespace nacelle::look {

Right right_for_service(std::string_view type) {
  constexpr std::array<std::string_view, 2> kNever{"nacelle_interfaces/srv/SetNetwork",
                                                   "nacelle_interfaces/srv/Shutdown"};
  // Packages in which services with these names change nothing.
  constexpr std::array<std::string_view, 6> kPackages{"composition_interfaces", "lifecycle_msgs",
                                                      "nacelle_interfaces",     "rcl_interfaces",
                                                      "rosbag2_interfaces",     "type_description_interfaces"};
  constexpr std::array<std::string_view, 5> kAnswers{"Get", "List", "Describe", "Lookup", "IsPaused"};
  const std::string_view package = type.substr(0, type.find('/')), name = type.substr(type.rfind('/') + 1);
  if (std::any_of(kNever.begin(), kNever.end(), [&](std::string_view one) { return type.starts_with(one); }))
    return Right::None;
  const bool answers =
      std::find(kPackages.begin(), kPackages.end(), package) != kPackages.end() &&
      std::any_of(kAnswers.begin(), kAnswers.end(), [&](std::string_view one) { return name.starts_with(one); });
  return answers ? Right::View : Right::Operate;
}

}  // namespace nacelle::look
