// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::run_page {

/// Returns the page's CSS: light and dark as the reader's system is, light on paper, one column on a phone.
[[nodiscard]] std::string page_style();

}  // namespace nacelle::run_page
