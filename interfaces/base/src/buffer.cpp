// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/buffer.hpp"

namespace nacelle {
namespace {

thread_local bool reserving = false;

}  // namespace

ReservingCopies::ReservingCopies() { reserving = true; }
ReservingCopies::~ReservingCopies() { reserving = false; }
bool ReservingCopies::are_on() { return reserving; }

}  // namespace nacelle
