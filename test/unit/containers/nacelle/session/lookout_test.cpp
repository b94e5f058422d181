// SPDX-License-Identifier: Apache-2.0
#include "session/lookout.hpp"

#include <gtest/gtest.h>

#include <future>

namespace nacelle::session {
namespace {

void nothing() noexcept {}

TEST(Lookout, acts_once_if_the_signal_was_not_handled_in_time) {
  const process::StopSignal stop{nothing};
  std::promise<void> acted;  // a second time would throw
  auto has_acted = acted.get_future();
  const Lookout lookout{stop, [] { return 1ms; }, [&] { acted.set_value(); }};
  EXPECT_EQ(has_acted.wait_for(20ms), std::future_status::timeout);
  stop.raise_by_request();
  EXPECT_EQ(has_acted.wait_for(20s), std::future_status::ready);
}

TEST(Lookout, does_not_act_when_its_owner_was_quicker) {
  bool acted = false;
  std::promise<void> asked;
  {
    const process::StopSignal stop{nothing};
    const Lookout lookout{stop,
                          [&] {
                            asked.set_value();
                            return Duration{1h};
                          },
                          [&] { acted = true; }};
    stop.raise_by_request();
    asked.get_future().wait();
  }
  EXPECT_FALSE(acted);
}

TEST(Lookout, ends_without_a_signal) {
  const process::StopSignal stop{nothing};
  const Lookout lookout{stop, [] { return Duration{}; }, [] { ADD_FAILURE() << "no stop was requested"; }};
}

}  // namespace
}  // namespace nacelle::session
