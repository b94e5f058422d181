// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/component/ekf_options.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::ekf {

/// smooth_lagged_data, history_length, permit_corrected_publication and reset_on_time_jump.
void declare_history_parameters(Node& node);
/// After the inputs were read. Errors: the parameter, its value and what would be right.
[[nodiscard]] Result<void, Problem> read_history(const Node& node, EkfOptions& options);
/// What `nacelle check` says of values that go together badly; read_history() puts it into the notes.
void declare_history_warnings(const Node& node);

}  // namespace nacelle::ekf
