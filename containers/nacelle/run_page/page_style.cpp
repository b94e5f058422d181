// SPDX-License-Identifier: Apache-2.0
#include "run_page/page_style.hpp"

#include <fmt/format.h>

#include <cstddef>

#include "drawing/svg.hpp"

namespace nacelle::run_page {
namespace {

/// Lighter than the colours on white, in the same order.
constexpr const char* kDark = R"(@media screen and (prefers-color-scheme: dark) {
:root { --paper: #16191d; --ink: #d8dbe0; --grid: #30353c; --frame: #7d858f; --bad: #ff8f8f;
  --line0: #6ea8ff; --line1: #ff9d4d; --line2: #5fce98; --line3: #d98ad6; --line4: #dcb83c; --line5: #ff7d92;
  --line6: #6fd0e6; --line7: #a9adb3; }
}
)";

constexpr const char* kLayout = R"(body { background: var(--paper); color: var(--ink); font: 16px/1.45 sans-serif;
  max-width: 70rem; margin: 0 auto; padding: 0.75rem; }
h1 { font-size: 1.5rem; margin: 0.4rem 0; }
h2 { font-size: 1.15rem; margin: 1.6rem 0 0.4rem; border-bottom: 1px solid var(--grid); }
p, dl { margin: 0.4rem 0; overflow-wrap: anywhere; }
.failure { color: var(--bad); font-weight: bold; }
.tiles { display: grid; grid-template-columns: repeat(auto-fill, minmax(9.5rem, 1fr)); gap: 0.5rem; margin: 0; }
.tiles div { border: 1px solid var(--grid); border-radius: 0.3rem; padding: 0.35rem 0.6rem; }
.tiles dt { font-size: 0.85rem; }
.tiles dd { margin: 0; font-weight: bold; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 22rem), 1fr)); gap: 0.75rem; }
figure { margin: 0.4rem 0; break-inside: avoid; }
.narrow { max-width: 38rem; }
figcaption { font-size: 0.9rem; }
svg { display: block; width: 100%; height: auto; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 0.9rem; width: 100%; }
th, td { padding: 0.2rem 0.5rem; text-align: right; border-bottom: 1px solid var(--grid); white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
td svg { width: 8rem; }
tr { break-inside: avoid; }
)";

}  // namespace

std::string page_style() {
  const auto colours = drawing::svg_file_colours();
  std::string text =
      fmt::format(":root {{ color-scheme: light dark; --paper: {}; --ink: {}; --grid: {}; --frame: {}; --bad: #b00020;",
                  colours.paper, colours.ink, colours.grid, colours.frame);
  for (std::size_t i = 0; i < colours.lines.size(); ++i) text += fmt::format(" --line{}: {};", i, colours.lines[i]);
  return text + " }\n" + kDark + kLayout;
}

}  // namespace nacelle::run_page
