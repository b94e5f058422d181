// SPDX-License-Identifier: Apache-2.0
#include "drive/live_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace nacelle::drive {
namespace {

/// As many lines as an 80 x 24 terminal, and what of it goes into the scrollback.
class Screen {
 public:
  void take(const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') {
        if (row_ == kRows - 1) ++scrolled_;
        row_ = std::min(row_ + 1, kRows - 1);
      } else if (text[i] == '\033') {
        const std::size_t end = text.find_first_of("FJKhlm", i);
        if (text[end] == 'F') row_ -= std::min(row_, std::stoi(text.substr(i + 2)));
        // What terminals (tmux, PuTTY, Windows Terminal) do with a screen that is erased from its first line on.
        if (text[end] == 'J' && row_ == 0) scrolled_ += kRows;
        i = end;
      }
    }
  }
  [[nodiscard]] int scrolled() const { return scrolled_; }

 private:
  static constexpr int kRows = 24;
  int row_ = kRows - 1;  // below the shell's last line
  int scrolled_ = 0;
};

nlohmann::json stats_of_a_robot() {
  nlohmann::json stats{{"phase", "running"}, {"nodes", nlohmann::json::array()}, {"streams", nlohmann::json::array()}};
  for (int i = 0; i < 30; ++i)
    stats["streams"].push_back({{"name", "/stream_" + std::to_string(i)},
                                {"type", "std_msgs/msg/String"},
                                {"writers", 1},
                                {"readers", 2},
                                {"published", 100},
                                {"copies", 0}});
  return stats;
}

TEST(LiveView, a_block_as_high_as_the_terminal_scrolls_once_and_no_more) {
  const auto stats = stats_of_a_robot();
  Screen screen;
  LiveView view{true, MonotonicTime{}};
  const auto shown = [&](auto&& act) {
    testing::internal::CaptureStdout();
    act();
    screen.take(testing::internal::GetCapturedStdout());
  };
  shown([&] { view.show(stats, "drives", MonotonicTime{1s}); });
  const int first = screen.scrolled();
  EXPECT_LT(first, 24) << "the block makes room for itself";
  for (int i = 0; i < 20; ++i) shown([&] { view.show(stats, "drives", MonotonicTime{2s}); });
  shown([&] { view.clear(); });
  EXPECT_EQ(screen.scrolled(), first);
}

}  // namespace
}  // namespace nacelle::drive
