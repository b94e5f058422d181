// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/component/ekf_options.hpp"

namespace nacelle::ekf {

/// Declares process_noise and process_noise_limits.*. Call after `frequency` is declared.
void declare_wheeled_noise(Node& node);

/// Replaces the filter's process noise if `process_noise` is "wheeled". Call after the inputs are read.
/// Errors: another word; a limit that is not positive; process_noise_covariance given beside it.
[[nodiscard]] Result<void, Problem> read_wheeled_noise(const Node& node, EkfOptions& options);

}  // namespace nacelle::ekf
