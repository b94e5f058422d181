// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/parameter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace nacelle {
namespace {

using ::testing::HasSubstr;

ParameterStore store(std::map<std::string, ParameterValue> overrides = {}) { return {"/base", std::move(overrides)}; }

TEST(ParameterStore, an_override_wins_over_the_default) {
  auto parameters = store({{"rate", 100.0}});
  EXPECT_EQ(std::get<double>(parameters.declare("rate", 50.0, ParameterType::Double, {})), 100.0);
  EXPECT_EQ(std::get<double>(parameters.declare("gain", 0.1, ParameterType::Double, {})), 0.1);
}

TEST(ParameterStore, takes_a_whole_number_for_a_double_and_nothing_else) {
  auto parameters = store({{"rate", std::int64_t{100}}, {"radius", std::string("wide")}});
  EXPECT_EQ(std::get<double>(parameters.declare("rate", 50.0, ParameterType::Double, {})), 100.0);
  try {
    parameters.declare("radius", 0.033, ParameterType::Double, {});
    FAIL();
  } catch (const exceptions::InvalidParameterTypeException& e) {
    EXPECT_THAT(e.what(), HasSubstr("node /base: parameter 'radius' is double but was given string (wide)"));
  }
}

TEST(ParameterStore, a_parameter_is_declared_once) {
  auto parameters = store();
  parameters.declare("rate", 50.0, ParameterType::Double, {});
  EXPECT_THROW(parameters.declare("rate", 50.0, ParameterType::Double, {}),
               exceptions::ParameterAlreadyDeclaredException);
  EXPECT_THROW((void)parameters.get("rte"), exceptions::ParameterNotDeclaredException);
}

TEST(ParameterStore, holds_values_in_their_ranges_at_declaration_and_when_set) {
  ParameterDescriptor narrow;
  narrow.floating_point_range = FloatingPointRange{0.0, 1.0, 0.25};
  auto parameters = store({{"a", 1.5}, {"b", 0.5}});
  EXPECT_THROW(parameters.declare("a", 0.5, ParameterType::Double, narrow), exceptions::InvalidParameterValueException);
  parameters.declare("b", 0.5, ParameterType::Double, narrow);
  for (const double good : {0.0, 0.25, 0.75, 1.0})
    EXPECT_TRUE(parameters.set_atomically({{"b", good}}).successful) << good;
  for (const double bad : {-0.1, 0.3, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    const auto result = parameters.set_atomically({{"b", bad}});
    EXPECT_FALSE(result.successful) << bad;
    EXPECT_THAT(result.reason, HasSubstr("floating point range"));
  }
  ParameterDescriptor steps;
  steps.integer_range = IntegerRange{10, 21, 5};
  parameters.declare("n", std::int64_t{10}, ParameterType::Integer, steps);
  for (const std::int64_t good : {10, 15, 20, 21})
    EXPECT_TRUE(parameters.set_atomically({{"n", good}}).successful) << good;
  for (const std::int64_t bad : {9, 11, 22}) EXPECT_FALSE(parameters.set_atomically({{"n", bad}}).successful) << bad;
}

TEST(ParameterStore, sets_all_or_nothing_and_asks_the_callbacks) {
  auto parameters = store();
  parameters.declare("a", std::int64_t{1}, ParameterType::Integer, {});
  parameters.declare("b", std::int64_t{1}, ParameterType::Integer, {});
  const auto handle = parameters.add_on_set([](const std::vector<Parameter>& wanted) {
    for (const auto& p : wanted) {
      if (p.as_int() > 5) return SetParametersResult{false, "too much"};
    }
    return SetParametersResult{};
  });
  EXPECT_EQ(parameters.set_atomically({{"a", std::int64_t{2}}, {"b", std::int64_t{9}}}).reason, "too much");
  EXPECT_EQ(std::get<std::int64_t>(parameters.get("a")), 1);
  EXPECT_TRUE(parameters.set_atomically({{"a", std::int64_t{2}}, {"b", std::int64_t{3}}}).successful);
  EXPECT_EQ(std::get<std::int64_t>(parameters.get("b")), 3);
}

TEST(ParameterStore, asks_a_callback_as_long_as_its_handle_lives_the_newest_first) {
  auto parameters = store();
  parameters.declare("a", std::int64_t{1}, ParameterType::Integer, {});
  std::string asked;
  const auto older = parameters.add_on_set([&](const auto&) {
    asked += "older ";
    return SetParametersResult{};
  });
  auto newer = parameters.add_on_set([&](const auto&) {
    asked += "newer ";
    return SetParametersResult{};
  });
  EXPECT_TRUE(parameters.set_atomically({{"a", std::int64_t{2}}}).successful);
  EXPECT_EQ(asked, "newer older ");
  newer.reset();
  EXPECT_TRUE(parameters.set_atomically({{"a", std::int64_t{3}}}).successful);
  EXPECT_EQ(asked, "newer older older ");
  parameters.remove_on_set(older.get());
  EXPECT_TRUE(parameters.set_atomically({{"a", std::int64_t{4}}}).successful);
  EXPECT_EQ(asked, "newer older older ");
}

TEST(ParameterStore, undeclares_what_is_of_dynamic_type_and_nothing_else) {
  auto parameters = store();
  ParameterDescriptor any, fixed;
  any.dynamic_typing = fixed.dynamic_typing = true;
  fixed.read_only = true;
  parameters.declare("any", true, ParameterType::Bool, any);
  parameters.declare("fixed", true, ParameterType::Bool, fixed);
  parameters.declare("typed", true, ParameterType::Bool, {});
  parameters.undeclare_dynamic("any");
  EXPECT_FALSE(parameters.has("any"));
  EXPECT_THROW(parameters.undeclare_dynamic("any"), exceptions::ParameterNotDeclaredException);
  EXPECT_THROW(parameters.undeclare_dynamic("fixed"), exceptions::ParameterImmutableException);
  EXPECT_THROW(parameters.undeclare_dynamic("typed"), exceptions::InvalidParameterTypeException);
}

TEST(Parameter, gives_its_value_as_the_type_that_is_asked_for) {
  EXPECT_EQ((Parameter{"n", std::int64_t{3}}.get_value<int>()), 3);
  EXPECT_EQ((Parameter{"x", 0.5}.get_value<float>()), 0.5F);
  EXPECT_EQ((Parameter{"l", std::vector<std::int64_t>{1, 2}}.get_value<std::vector<int>>()), (std::vector<int>{1, 2}));
  EXPECT_EQ((Parameter{"s", std::string{"a"}}.get_value<std::string>()), "a");
  EXPECT_THROW(static_cast<void>(Parameter("n", std::int64_t{3}).get_value<double>()),
               exceptions::InvalidParameterTypeException);
}

TEST(ParameterStore, answers_refusals_in_rclcpps_words) {
  auto parameters = store();
  ParameterDescriptor fixed;
  fixed.read_only = true;
  parameters.declare("fixed", true, ParameterType::Bool, fixed);
  parameters.declare("n", std::int64_t{1}, ParameterType::Integer, {});
  EXPECT_EQ(parameters.set_atomically({{"fixed", false}}).reason,
            "parameter 'fixed' cannot be set because it is read-only");
  EXPECT_EQ(parameters.set_atomically({{"none", false}}).reason,
            "parameter 'none' cannot be set because it was not declared");
  EXPECT_EQ(parameters.set_atomically({{"n", std::string("x")}}).reason,
            "Wrong parameter type, parameter {n} is of type {integer}, setting it to {string} is not allowed.");
}

TEST(ParameterStore, knows_the_undeclared_overrides) {
  auto parameters = store({{"rate", 1.0}, {"rtae", 2.0}});
  parameters.declare("rate", 50.0, ParameterType::Double, {});
  EXPECT_EQ(parameters.unused_overrides(), std::vector<std::string>{"rtae"});
}

TEST(ParameterStore, collects_every_refused_override_and_goes_on_with_the_defaults) {
  const auto faults = std::make_shared<ParameterFaults>();
  ParameterStore base{
      "/base", {{"rate", std::string{"fast"}}, {"gain", 7.0}, {"name", std::string{"x"}}, {"pins", 1.5}}, faults};

  EXPECT_EQ(std::get<double>(base.declare("rate", 50.0, ParameterType::Double, {})), 50.0);
  ParameterDescriptor range;
  range.floating_point_range = FloatingPointRange{0.0, 1.0, 0.0};
  EXPECT_EQ(std::get<double>(base.declare("gain", 0.5, ParameterType::Double, range)), 0.5);
  EXPECT_EQ(std::get<std::string>(base.declare("name", std::string{}, ParameterType::String, {})), "x");
  base.declare("pins", std::vector<std::int64_t>{}, ParameterType::IntegerArray, {});

  const auto found = *faults->lock();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].problem.where.parameter, "rate");
  EXPECT_EQ(found[0].problem.what, "parameter 'rate' is double but was given string (fast)");
  EXPECT_EQ(found[1].problem.where.parameter, "gain");
  EXPECT_NE(found[1].problem.what.find("7 is not in 0 to 1"), std::string::npos) << found[1].problem.what;
  EXPECT_EQ(found[0].problem.way_out, "write a double value");
  EXPECT_EQ(found[2].problem.way_out, "write an integer array value");
}

TEST(ParameterStore, a_default_out_of_its_range_is_the_programmers_fault_even_then) {
  ParameterStore base{"/base", {}, std::make_shared<ParameterFaults>()};
  ParameterDescriptor range;
  range.floating_point_range = FloatingPointRange{0.0, 1.0, 0.0};
  EXPECT_THROW(base.declare("gain", 2.0, ParameterType::Double, range), exceptions::InvalidParameterValueException);
}

/// Records the changes that it is notified of, as text.
class Told final : public ParameterListener {
 public:
  void on_change(const ParameterChange& change) noexcept override {
    const auto append = [&](const char* what, const std::vector<Parameter>& parameters) {
      for (const auto& one : parameters) text += what + one.get_name() + "=" + to_text(one.get_parameter_value()) + " ";
    };
    append("+", change.declared);
    append("", change.set);
    append("-", change.undeclared);
  }
  std::string text;
};

TEST(ParameterStore, tells_what_has_changed_and_nothing_of_what_was_refused) {
  auto parameters = store();
  parameters.declare("before", true, ParameterType::Bool, {});
  const auto told = std::make_shared<Told>();
  parameters.set_listener(told);
  parameters.declare("rate", 50.0, ParameterType::Double, {});
  EXPECT_THROW(parameters.declare("rate", 50.0, ParameterType::Double, {}),
               exceptions::ParameterAlreadyDeclaredException);
  EXPECT_TRUE(parameters.set_atomically({{"rate", std::int64_t{10}}, {"before", false}}).successful);
  EXPECT_FALSE(parameters.set_atomically({{"rate", 20.0}, {"before", 1.0}}).successful);
  parameters.undeclare("before");
  parameters.undeclare("before");
  EXPECT_EQ(told->text, "+rate=50 rate=10 before=false -before=(not set) ");
  parameters.set_listener(nullptr);
  parameters.undeclare("rate");
  EXPECT_EQ(told->text, "+rate=50 rate=10 before=false -before=(not set) ");
}

TEST(ParameterStore, a_value_that_is_not_set_undeclares_what_has_no_fixed_type) {
  auto parameters = store();
  parameters.declare("rate", 50.0, ParameterType::Double, {});
  parameters.declare("loose", std::int64_t{1}, ParameterType::Integer, {.dynamic_typing = true});
  const auto fixed = parameters.set_atomically({{"loose", ParameterValue{}}, {"rate", ParameterValue{}}});
  EXPECT_FALSE(fixed.successful);
  EXPECT_EQ(fixed.reason, "cannot undeclare a statically typed parameter");
  EXPECT_TRUE(parameters.has("loose"));
  EXPECT_TRUE(parameters.set_atomically({{"loose", ParameterValue{}}, {"loose", std::int64_t{2}}}).successful);
  EXPECT_FALSE(parameters.has("loose"));
}

TEST(ParameterStore, shows_all_that_is_declared) {
  auto parameters = store();
  parameters.declare("b", 50.0, ParameterType::Double, {.description = "Hz"});
  parameters.declare("a", ParameterValue{}, ParameterType::Integer, {});
  std::string all;
  parameters.for_each([&](const std::string& name, const ParameterValue& value, ParameterType type,
                          const ParameterDescriptor& descriptor) {
    all += name + " " + to_text(value) + " " + to_text(type) + " " + descriptor.description + ";";
  });
  EXPECT_EQ(all, "a (not set) integer ;b 50 double Hz;");
}

}  // namespace
}  // namespace nacelle
