// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "../linked_by_iceoryx.hpp"
#include "../transport_traits.hpp"

namespace nacelle {

/// In a program of its own, which has the daemon: a link whose streams iceoryx moves.
using EveryTransport = ::testing::Types<test::LinkedByIceoryx>;
inline constexpr NamedTransport kNamedTransports[] = {{"Iceoryx", make_transport<test::LinkedByIceoryx>}};

}  // namespace nacelle
