// SPDX-License-Identifier: Apache-2.0
#include "new_package/new_package.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "nacelle/base/files.hpp"
#include "support/places.hpp"

namespace nacelle::new_package {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<File> example(const std::string& name) {
  auto files = read_template(test::source("docs/examples/packages/" + name));
  EXPECT_TRUE(files) << files.error().text();
  return std::move(files).value();
}

class NewPackage : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directory(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  const fs::path folder_ = ::testing::TempDir() + "new_package_" + std::to_string(::getpid());
};

TEST(NewPackageName, is_turned_into_the_name_of_a_class) {
  EXPECT_EQ(class_name("wheel_counter"), "WheelCounter");
  EXPECT_EQ(class_name("imu2_reader"), "Imu2Reader");
  EXPECT_EQ(class_name("x"), "X");
}

TEST(NewPackageName, may_have_letters_digits_and_single_underscores) {
  for (const char* const good : {"x", "wheel_counter", "imu2", "a_1"}) EXPECT_TRUE(check_name(good)) << good;
}

TEST(NewPackageName, that_is_refused_comes_with_one_that_is_not) {
  for (const auto& [bad, better] : {std::pair{"Wheel-Counter", "wheel_counter"},
                                    {"WheelCounter", "wheel_counter"},
                                    {"2wheels", "wheels"},
                                    {"a__b", "a_b"},
                                    {"a_", "a"},
                                    {"../etc", "etc"},
                                    {"", "wheel_counter"},
                                    {"\xc3\xa4", "wheel_counter"},
                                    {"class", "my_class"},
                                    {"std", "my_std"},
                                    {"xor_eq", "my_xor_eq"},
                                    {"alignas", "my_alignas"},
                                    {"time", "my_time"},
                                    {"nacelle", "my_robot"},
                                    {"nacelle_lidar", "my_lidar"}}) {
    const auto checked = check_name(bad);
    ASSERT_FALSE(checked) << bad;
    EXPECT_EQ(checked.error().value, bad);
    EXPECT_TRUE(checked.error().way_out.ends_with(std::string{" such as "} + better)) << checked.error().text();
    EXPECT_TRUE(check_name(better)) << better;
  }
  const auto too_long = check_name(std::string(61, 'x'));
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().text(), "name: has 61 characters; use 60 at most");
}

TEST(NewPackageFiles, name_nothing_of_the_example) {
  for (const std::string from : {"talker", "mean_filter", "range_driver"}) {
    const auto files = rename(example(from), from, "wheel_counter");
    ASSERT_TRUE(files) << files.error().text();
    for (const char* const path : {"CMakeLists.txt", "README.md", "package.xml", "src/wheel_counter.cpp",
                                   "test/wheel_counter_test.cpp", "launch/wheel_counter.launch.yaml"})
      EXPECT_THAT(files.value(), Contains(Field(&File::path, path))) << from;
    EXPECT_EQ(files.value().size(), 6U);
    for (const auto& file : files.value()) {
      EXPECT_THAT(file.text, Not(AnyOf(HasSubstr("example_"), HasSubstr("example:"), HasSubstr(from),
                                       HasSubstr(class_name(from)))))
          << file.path;
      EXPECT_THAT(file.text, HasSubstr("wheel_counter")) << file.path;
    }
  }
}

TEST(NewPackageFiles, are_the_examples_own_under_its_name) {
  const auto files = rename(example("talker"), "talker", "talker");
  ASSERT_TRUE(files);
  EXPECT_THAT(files.value()[2].path, "launch/talker.launch.yaml");
  EXPECT_THAT(files.value()[2].text, HasSubstr("plugin: talker::Talker"));
}

TEST(NewPackageFiles, are_refused_where_the_class_would_hide_a_type) {
  const auto files = rename(example("range_driver"), "range_driver", "range");
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().text(),
            "name: the class would be called Range, as a type that its code uses; use another name, such as my_range");
  // A word of a comment is no type.
  EXPECT_TRUE(rename(example("range_driver"), "range_driver", "reads"));
}

TEST_F(NewPackage, is_written_into_a_new_folder_only) {
  const std::string folder = folder_ / "mine";
  const std::vector<File> files = {{"CMakeLists.txt", "a"}, {"src/mine.cpp", "b"}};
  ASSERT_TRUE(write(folder, files));
  EXPECT_EQ(read_regular_file(folder + "/src/mine.cpp").value(), "b");

  const auto again = write(folder, {{"CMakeLists.txt", "c"}});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().text(), folder + ": already exists; use another name, or go to another folder");
  EXPECT_EQ(read_regular_file(folder + "/CMakeLists.txt").value(), "a");
}

TEST_F(NewPackage, leaves_nothing_where_a_file_cannot_be_written) {
  const std::string folder = folder_ / "mine";
  const auto written = write(folder, {{"a", ""}, {"a/b", ""}});
  ASSERT_FALSE(written);
  EXPECT_FALSE(fs::exists(folder));
}

TEST_F(NewPackage, needs_its_example) {
  const auto files = read_template(folder_ / "nothing");
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().text(),
            (folder_ / "nothing").string() + ": cannot be read: No such file or directory; install Nacelle again");
}

}  // namespace
}  // namespace nacelle::new_package
