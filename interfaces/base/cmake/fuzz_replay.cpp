// SPDX-License-Identifier: Apache-2.0
// The main() of a fuzz target that runs as a test: every file of the corpus, every prefix of it up to a limit, and seeded
// damage to it. What a fuzzer once found stays found, on every machine and under every sanitizer.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {
using Bytes = std::vector<std::uint8_t>;

constexpr unsigned kSeed = 20261121;
constexpr std::size_t kLongestPrefix = 256;
constexpr int kDamagedForms = 64;

// A copy that ends where its allocation ends, so that the address sanitizer sees the first byte read too many.
void run(const Bytes& bytes, std::size_t size) {
  const Bytes exact(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

Bytes damaged(Bytes bytes, std::mt19937& random) {
  for (std::size_t hits = 1 + random() % 4; hits > 0 && !bytes.empty(); --hits) {
    bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
  }
  return bytes;
}
}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s CORPUS_FOLDER\n", argv[0]);
    return 2;
  }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[1])) {
    if (entry.is_regular_file() && entry.path().filename() != "README.md") files.push_back(entry.path());
  }
  if (files.empty()) {
    std::fprintf(stderr, "%s: no corpus there\n", argv[1]);
    return 1;
  }
  std::sort(files.begin(), files.end());

  std::mt19937 random{kSeed};
  std::size_t inputs = 0;
  for (const auto& file : files) {
    // Said before the run: when the target dies, the last line names the input.
    std::printf("%s\n", file.c_str());
    std::fflush(stdout);
    std::ifstream in{file, std::ios::binary};
    const Bytes bytes{std::istreambuf_iterator<char>{in}, {}};
    for (std::size_t size = 0; size < std::min(bytes.size(), kLongestPrefix); ++size, ++inputs) run(bytes, size);
    run(bytes, bytes.size());
    for (int form = 0; form < kDamagedForms; ++form, ++inputs) run(damaged(bytes, random), bytes.size());
    ++inputs;
  }
  std::printf("%zu files, %zu inputs, seed %u\n", files.size(), inputs, kSeed);
  return 0;
}
