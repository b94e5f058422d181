// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/descriptor.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <system_error>

namespace nacelle::io {
namespace {

TEST(Bell, that_finds_no_descriptor_is_an_exception_and_not_the_end_of_the_process) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "a sanitizer needs descriptors of its own";
#endif
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const Descriptor free{
      ::open("/dev/null", O_RDONLY | O_CLOEXEC)};  // the lowest that is free, and with it all below are taken
  rlimit none = before;
  none.rlim_cur = static_cast<rlim_t>(free.number());
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);

  EXPECT_THROW(Bell{}, std::system_error);

  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  Bell bell;
  bell.ring();
  EXPECT_TRUE(bell.silence());
}

}  // namespace
}  // namespace nacelle::io
