// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "diff_drive/component/diff_drive_options.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/port/base_port.hpp"

namespace nacelle::diff_drive {

/// Opens the PWM channels, lines and encoders that the parameters name: the wheels are stopped. Precondition: validated() finds no problem.
/// Errors: a Problem that names the parameter, what is wrong (no chip, no permission, in use, no counter) and what to do.
[[nodiscard]] Result<std::unique_ptr<BasePort>, Problem> open_pwm_base(const DiffDriveOptions& options,
                                                                       const BaseWiring& wiring, const Clock& clock);

}  // namespace nacelle::diff_drive
