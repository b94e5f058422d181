// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "run_page/figures.hpp"

namespace nacelle::run_page {

/// Returns the figures of a run as a page of HTML that needs no other file and no script. It is well-formed XML, too. Pure.
[[nodiscard]] std::string page_of(const Figures& figures);

}  // namespace nacelle::run_page
