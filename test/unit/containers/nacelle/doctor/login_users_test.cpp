// SPDX-License-Identifier: Apache-2.0
#include "doctor/login_users.hpp"

#include <gmock/gmock.h>

#include "machine_of_files.hpp"

namespace nacelle::doctor {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using LoginUsers = MachineOfFiles;

TEST_F(LoginUsers, are_people_with_a_shell_except_root_and_the_caller) {
  write("/etc/passwd",
        "root:x:0:0:root:/:/bin/bash\n"
        "postgres:x:101:104::/var/lib/postgresql:/bin/bash\n"
        "robot:x:1000:1000::/home/robot:/bin/bash\n"
        "pupil:x:1002:1002:A pupil,,,:/home/pupil:/usr/bin/fish\n"
        "guest:x:1001:1001::/home/guest:\n"
        "backup:x:1003:1003::/srv:/usr/sbin/nologin\n"
        "gone:x:1004:1004::/home/gone:/bin/false\n"
        "nobody:x:65534:65534:nobody:/nonexistent:/bin/sh\n"
        "cut:x:1005\n"
        "wrong:x:many:1006::/home/wrong:/bin/sh\n");
  EXPECT_THAT(other_login_users(machine(), 1000), ElementsAre("guest", "pupil"));
  EXPECT_THAT(other_login_users(machine(), 0), ElementsAre("guest", "pupil", "robot"));
}

TEST_F(LoginUsers, are_none_where_there_is_no_such_file) {
  std::filesystem::remove_all(root);
  EXPECT_THAT(other_login_users(machine(), 1000), IsEmpty());
}

}  // namespace
}  // namespace nacelle::doctor
