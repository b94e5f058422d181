// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <pthread.h>

#include <cstddef>

namespace nacelle::test {

/// While it lives, no thread can be started without a stack size of its own: there is no room for so much.
class NoThreads {
 public:
  NoThreads() {
    EXPECT_EQ(::pthread_getattr_default_np(&before_), 0);
    pthread_attr_t endless = before_;
    EXPECT_EQ(::pthread_attr_setstacksize(&endless, std::size_t{1} << 47U), 0);
    EXPECT_EQ(::pthread_setattr_default_np(&endless), 0);
  }
  ~NoThreads() { EXPECT_EQ(::pthread_setattr_default_np(&before_), 0); }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;

 private:
  pthread_attr_t before_{};
};

}  // namespace nacelle::test
