// SPDX-License-Identifier: Apache-2.0
#include "loading/load_request.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "../control/temporary_folder.hpp"

namespace nacelle::loading {
namespace {

TEST(LoadRequest, carries_every_setting_of_the_launch_file) {
  launch::ComponentPlan plan;
  plan.plugin = "a::B";
  plan.name = "b";
  plan.namespace_ = "/arm";
  plan.parameters = {{"rate", std::int64_t{50}, {}}, {"port", std::string{"/dev/x"}, {}}};
  plan.remaps = {{RemapKind::TopicOrService, "", "scan", "front/scan"}};
  plan.thread = {.own = true, .priority = 20, .cpus = {1, 2}, .threads = 3};
  launch::TopicQos qos{"/arm/scan", launch::Side::Subscription, {}, {}, {}};
  qos.patch.reliability = Reliability::BestEffort;
  plan.qos = {qos};

  const auto request = load_request_of(plan);

  EXPECT_EQ(request.plugin, "a::B");
  EXPECT_EQ(request.name, "b");
  EXPECT_EQ(request.name_space, "/arm");
  EXPECT_EQ(std::get<std::int64_t>(request.parameters.at("rate")), 50);
  EXPECT_EQ(std::get<std::string>(request.parameters.at("port")), "/dev/x");
  EXPECT_EQ(request.remaps, plan.remaps);
  EXPECT_TRUE(request.thread.own);
  EXPECT_EQ(request.thread.priority, 20);
  EXPECT_EQ(request.thread.cpus, (std::vector<int>{1, 2}));
  EXPECT_EQ(request.thread.threads, 3U);
  ASSERT_EQ(request.qos.size(), 1U);
  EXPECT_EQ(request.qos[0].topic, "/arm/scan");
  EXPECT_FALSE(request.qos[0].for_publisher);
  EXPECT_EQ(request.qos[0].apply(QoS{7}).reliability(), Reliability::BestEffort);
  EXPECT_EQ(request.qos[0].apply(QoS{7}).depth(), 7U);
}

TEST(ProgramSpec, the_simulated_world_is_this_program_and_reports_when_it_is_ready) {
  launch::ProgramPlan plan;
  plan.package = plan.executable = "nacelle";
  plan.arguments = {"sim", "world", "--dir", "/x/y", "--seed", "3"};
  plan.required = true;
  const auto spec = program_spec_of(plan, "/usr/bin/nacelle", {});
  ASSERT_TRUE(spec);
  EXPECT_EQ(spec.value().path, "/usr/bin/nacelle");
  EXPECT_EQ(spec.value().ready_file, "/x/y/ready");
  EXPECT_TRUE(spec.value().required);
  EXPECT_EQ(spec.value().arguments[6], "--parent");
}

TEST(ProgramSpec, a_program_of_a_package_is_looked_for_in_the_prefixes) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() + "/lib/pkg");
  const std::string path = folder.path() + "/lib/pkg/tool";
  launch::ProgramPlan plan;
  plan.package = "pkg";
  plan.executable = "tool";
  const auto missing = program_spec_of(plan, "", {"/nowhere", folder.path()});
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().what.find(path), std::string::npos) << missing.error().text();

  std::ofstream{path} << "#!/bin/sh\n";
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  const auto found = program_spec_of(plan, "", {"/nowhere", folder.path()});
  ASSERT_TRUE(found);
  EXPECT_EQ(found.value().path, path);
}

TEST(ContainerParameters, are_seconds_in_a_range) {
  const auto options = container_options_of(
      {{.name = "hang_after", .value = 0.5}, {.name = "transition_timeout", .value = std::int64_t{5}}}, "f:1");
  ASSERT_TRUE(options);
  EXPECT_EQ(options->hang_after, 500ms);
  EXPECT_EQ(options->transition_timeout, 5s);
  EXPECT_EQ(options->handover_after, runtime::ContainerOptions{}.handover_after);
}

TEST(ContainerParameters, reports_each_mistake_at_its_place) {
  const auto options = container_options_of({{.name = "hang_afer", .value = 0.5, .where = {"a.yaml", 3}},
                                             {.name = "hang_after", .value = -1.0, .where = {"a.yaml", 4}},
                                             {.name = "transition_timeout", .value = "long"}},
                                            "f:1");
  ASSERT_FALSE(options);
  ASSERT_EQ(options.error().size(), 3);
  EXPECT_EQ(options.error()[0].text(),
            "a.yaml:3: the container has no parameter 'hang_afer'; did you mean 'hang_after'?");
  EXPECT_EQ(options.error()[1].text(),
            "a.yaml:4: parameter 'hang_after' of the container must be seconds from 0.001 to 3600, not -1; leave it "
            "out for the default");
  EXPECT_EQ(options.error()[2].where.text(), "f:1");
  const auto shorter = container_options_of({{.name = "hang_after", .value = 0.01, .where = {"a.yaml", 5}}}, "f:1");
  ASSERT_FALSE(shorter);
  EXPECT_EQ(shorter.error().at(0).where.text(), "a.yaml:5");
}

}  // namespace
}  // namespace nacelle::loading
