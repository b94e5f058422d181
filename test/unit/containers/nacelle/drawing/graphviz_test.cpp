// SPDX-License-Identifier: Apache-2.0
#include "drawing/graphviz.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace nacelle::drawing {
namespace {

using testing::HasSubstr;

/// A folder of this test's own, and PATH as it was before.
class Graphviz : public testing::Test {
 protected:
  Graphviz() : path_(std::getenv("PATH")) {
    std::string name = testing::TempDir() + "graphviz-XXXXXX";
    folder_ = ::mkdtemp(name.data());
  }
  ~Graphviz() override {
    ::setenv("PATH", path_.c_str(), 1);
    std::filesystem::remove_all(folder_);
  }
  Graphviz(const Graphviz&) = delete;
  Graphviz& operator=(const Graphviz&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) names.push_back(entry.path().filename());
    return names;
  }
  static std::string text_of(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream{path}.rdbuf();
    return text.str();
  }
  /// A `dot` in front of all others.
  void install(const std::string& script) const {
    std::filesystem::create_directory(file("bin"));
    std::ofstream{file("bin/dot")} << "#!/bin/sh\n" << script;
    std::filesystem::permissions(file("bin/dot"), std::filesystem::perms::owner_all);
    ::setenv("PATH", (file("bin") + ":" + path_).c_str(), 1);
  }

  const std::string path_;
  std::string folder_;
};

TEST_F(Graphviz, gets_the_text_and_the_format_that_the_name_asks_for) {
  install("echo \"$@\"; cat\n");
  const auto told = write_drawing(file("x.svg"), "digraph {}");
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_EQ(told.value(), "");
  EXPECT_EQ(text_of(file("x.svg")), "-Tsvg\ndigraph {}");
}

TEST_F(Graphviz, without_it_writes_the_dot_file_and_the_command_that_draws_it) {
  ::setenv("PATH", folder_.c_str(), 1);
  const auto told = write_drawing(file("x.svg"), "digraph {}");
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_THAT(told.value(), HasSubstr("`dot -Tsvg " + file("x.dot") + " -o " + file("x.svg") + "`"));
  EXPECT_EQ(text_of(file("x.dot")), "digraph {}");
  EXPECT_THAT(files(), testing::ElementsAre("x.dot"));
}

TEST_F(Graphviz, a_failure_keeps_the_old_drawing_and_reports_the_reason) {
  std::ofstream{file("x.svg")} << "old";
  install("echo half; echo 'syntax error in line 1' >&2; exit 1\n");
  const auto told = write_drawing(file("x.svg"), "digraph {}");
  ASSERT_FALSE(told);
  EXPECT_THAT(told.error().text(), HasSubstr("`dot` failed: syntax error in line 1"));
  EXPECT_EQ(text_of(file("x.svg")), "old");
  EXPECT_THAT(files(), testing::UnorderedElementsAre("bin", "x.svg"));
}

TEST_F(Graphviz, needs_a_folder_that_is_there) {
  for (const char* const name : {"none/x.svg", "none/x.dot"})
    EXPECT_THAT(write_drawing(file(name), "digraph {}").error().text(), HasSubstr("No such file or directory")) << name;
}

TEST(DrawingFormat, is_the_end_of_the_name) {
  EXPECT_EQ(drawing_format("a.svg"), "svg");
  EXPECT_EQ(drawing_format("a/b.dot"), "dot");
  EXPECT_EQ(drawing_format("a.jpg"), std::nullopt);
  EXPECT_EQ(drawing_format(".svg"), std::nullopt);
}

}  // namespace
}  // namespace nacelle::drawing
