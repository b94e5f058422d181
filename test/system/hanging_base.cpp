// SPDX-License-Identifier: Apache-2.0
// The base of diff_drive with one more callback, which hangs forever on request: for stop_test.py.
#include <unistd.h>

#include <std_msgs/msg/bool.hpp>

#include "diff_drive/component/diff_drive_component.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::test {

class HangingBase final : public diff_drive::DiffDriveComponent {
 public:
  explicit HangingBase(const NodeOptions& options)
      : DiffDriveComponent(options),
        hang_(
            create_subscription<std_msgs::msg::Bool>("~/hang", QoS(1).reliable(), [](const std_msgs::msg::Bool& hang) {
              while (hang.data) ::pause();
            })) {}

 private:
  std::shared_ptr<Subscription<std_msgs::msg::Bool>> hang_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::HangingBase)
