// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/bell.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <system_error>

namespace nacelle {
namespace {

TEST(Bell, can_be_waited_for_once_it_has_rung_until_it_is_silenced) {
  Bell bell;
  pollfd wait{bell.descriptor(), POLLIN, 0};
  EXPECT_EQ(::poll(&wait, 1, 0), 0);
  bell.ring();
  bell.ring();
  EXPECT_EQ(::poll(&wait, 1, 0), 1);
  EXPECT_TRUE(bell.silence());
  EXPECT_FALSE(bell.silence());
  EXPECT_EQ(::poll(&wait, 1, 0), 0);
}

TEST(Bell, that_finds_no_descriptor_is_an_exception_and_not_the_end_of_the_process) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "a sanitizer needs descriptors of its own";
#endif
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const int lowest = ::open("/dev/null", O_RDONLY | O_CLOEXEC);  // that is free, and with it all below are taken
  rlimit none = before;
  none.rlim_cur = static_cast<rlim_t>(lowest);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);

  EXPECT_THROW(Bell{}, std::system_error);

  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  ::close(lowest);
  Bell bell;
  bell.ring();
  EXPECT_TRUE(bell.silence());
}

}  // namespace
}  // namespace nacelle
