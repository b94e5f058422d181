// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace nacelle {

/// The text as a terminal may get it: a control character other than tab and line end becomes "\x1b", so that a name from
/// outside can neither move the cursor nor hide what was printed before. Problem::text() is made of it.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace nacelle
