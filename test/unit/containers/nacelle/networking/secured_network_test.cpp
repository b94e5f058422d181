// SPDX-License-Identifier: Apache-2.0
// The container's place on a network that is secured, or cannot be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "../control/temporary_folder.hpp"
#include "nacelle/runtime/container.hpp"
#include "networking/network.hpp"
#include "security/keystore.hpp"
#include "support/manual_clock.hpp"
#include "support/own_network.hpp"

namespace nacelle::networking {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class OwnNetwork final : public ::testing::Environment {
 public:
  void SetUp() override { static_cast<void>(test::enter_own_network()); }
};
[[maybe_unused]] const auto* const kOwnNetwork = ::testing::AddGlobalTestEnvironment(new OwnNetwork);

/// A container in a network of the test's own, where the clock's day is the test's.
class SecuredNetwork : public ::testing::Test {
 public:
  void SetUp() override {
    for (const auto& made : {security::create_keystore(keystore, domain, today),
                             security::create_enclave({keystore, "/robot", domain}, today)})
      ASSERT_TRUE(made) << made.error().text();
    launch::NetworkPlan plan;
    plan.mode = launch::NetworkMode::Local;
    plan.domain_id = domain;
    plan.security = launch::SecurityPlan{keystore, "/robot", true, {}};
    network = std::make_unique<networking::Network>(plan, transport_dds::Environment{}, container.graph(),
                                                    container.service_graph(), clock,
                                                    [this](const std::string& line) { said.push_back(line); });
  }
  [[nodiscard]] bool runs() const { return network->state()["running"].get<bool>(); }

  const int domain = 100 + ::getpid() % 100;  // where no network of its own is allowed
  const WallTime today = SystemClock{}.wall_now();
  TemporaryFolder folder;
  const std::string keystore = folder.path() + "/keys";
  test::ManualClock clock;
  std::vector<std::string> said;
  runtime::Container container{[] {
                                 runtime::ContainerOptions options;
                                 options.name = "secured";
                                 return options;
                               }(),
                               clock};
  std::unique_ptr<networking::Network> network;
};

TEST_F(SecuredNetwork, is_joined_as_its_enclave) {
  clock.step_wall(today - clock.wall_now());
  ASSERT_TRUE(network->start());
  EXPECT_TRUE(runs()) << network->line();
  EXPECT_THAT(network->line(), HasSubstr("secured as /robot"));
  EXPECT_EQ(network->state()["security"]["in_force"], true);
}

TEST_F(SecuredNetwork, is_joined_anew_as_often_as_it_is_shown) {
  clock.step_wall(today - clock.wall_now());
  ASSERT_TRUE(network->start());
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(network->show(launch::NetworkMode::Off, "test"));
    EXPECT_FALSE(runs());
    ASSERT_TRUE(network->show(launch::NetworkMode::Local, "test"));
    EXPECT_TRUE(runs()) << network->line();
  }
}

TEST_F(SecuredNetwork, waits_for_a_clock_that_is_years_behind) {
  clock.step_wall(today - clock.wall_now() - std::chrono::hours(24 * 365));
  ASSERT_TRUE(network->start()) << "the robot runs without";
  EXPECT_FALSE(runs());
  EXPECT_THAT(network->line(), HasSubstr("set the clock"));
  network->note_clock_jump();
  EXPECT_FALSE(runs());
  clock.step_wall(std::chrono::hours(24 * 365));
  network->note_clock_jump();
  EXPECT_TRUE(runs()) << network->line();
  EXPECT_THAT(said, Contains(HasSubstr("secured as /robot")));
}

// Nothing tells it when a file, a port or a route is there at last.
TEST_F(SecuredNetwork, is_tried_again_with_pauses_that_grow_until_it_can_be_joined) {
  clock.step_wall(today - clock.wall_now());
  const std::string away = folder.path() + "/away";
  std::filesystem::rename(keystore, away);
  ASSERT_TRUE(network->start()) << "the robot runs without";
  EXPECT_FALSE(runs());
  std::vector<Duration> pauses;
  const auto try_again = [&] {
    ASSERT_TRUE(network->next_due());
    pauses.push_back(*network->next_due() - clock.now());
    clock.advance(pauses.back());
    network->serve(false);
  };

  for (int i = 0; i < 8; ++i) try_again();
  EXPECT_FALSE(runs());
  EXPECT_THAT(pauses, testing::ElementsAre(1s, 2s, 4s, 8s, 16s, 32s, 60s, 60s));
  EXPECT_THAT(said, testing::IsEmpty()) << "the reason is the same";

  std::filesystem::rename(away, keystore);
  try_again();
  EXPECT_TRUE(runs()) << network->line();
  EXPECT_THAT(said, testing::ElementsAre(HasSubstr("secured as /robot")));
  EXPECT_FALSE(network->next_due());
}

}  // namespace
}  // namespace nacelle::networking
