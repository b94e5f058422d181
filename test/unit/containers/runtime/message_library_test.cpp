// SPDX-License-Identifier: Apache-2.0
// Types of services outlive the component that brought them: a link to other processes may be looking at one just then.
#include <gtest/gtest.h>

#include <algorithm>

#include "container_fixture.hpp"
#include "nacelle/host/service_graph.hpp"
#include "support/child_process.hpp"

namespace nacelle::runtime {
namespace {

constexpr const char* kLibrary = "libnacelle_msgs_std_srvs.so";

/// Keeps its notifications, as a link's thread does until it handles them.
struct Ends final : ServiceListener {
  void on_made(const ServiceEndInfo& end) noexcept override { made.push_back(end); }
  void on_gone(std::uint64_t) noexcept override {}
  std::vector<ServiceEndInfo> made;
};

struct Loaded final : ContainerTest {
  void TestBody() override {}
  void loads_and_unloads(const std::string& plugin, const std::string& service) {
    ASSERT_FALSE(is_mapped(kLibrary)) << "this program must not have it itself";
    Ends ends;
    container.service_graph().join(ends);
    const auto component = load(plugin);
    ASSERT_TRUE(is_mapped(kLibrary));
    ASSERT_TRUE(container.unload(component.id).value().image_closed);
    container.service_graph().leave(ends);
    ASSERT_TRUE(is_mapped(kLibrary));
    const auto found = std::ranges::find(ends.made, service, &ServiceEndInfo::name);
    ASSERT_NE(found, ends.made.end());
    EXPECT_STREQ(found->request->name, "std_srvs/srv/SetBool_Request");
    EXPECT_STREQ(found->response->name, "std_srvs/srv/SetBool_Response");
  }
};

// Each in a process of its own, because a pinned library stays loaded.
TEST(MessageLibraryTest, of_a_server_stays) {
  EXPECT_EQ(0, test::run_in_child([] { Loaded{}.loads_and_unloads("Talker", "/talker/enable"); }));
}

TEST(MessageLibraryTest, of_a_client_stays) {
  EXPECT_EQ(0, test::run_in_child([] { Loaded{}.loads_and_unloads("Listener", "/talker/enable"); }));
}

}  // namespace
}  // namespace nacelle::runtime
