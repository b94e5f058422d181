// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "../mirrored_brokers.hpp"
#include "../transport_traits.hpp"

namespace nacelle {

/// Two graphs that only the network joins. Its matrix of QoS is in mirrored_matrix_test.cpp, all pairs at once.
using EveryTransport = ::testing::Types<test::MirroredBrokers>;
template <>
inline constexpr bool kHoldsUp<test::MirroredBrokers> = false;
template <>
inline constexpr bool kTellsInfo<test::MirroredBrokers> = false;

}  // namespace nacelle
