// SPDX-License-Identifier: Apache-2.0
#include "simulation/port/truth_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cstring>

#include "nacelle/io/descriptor.hpp"

namespace nacelle::simulation {
namespace {

constexpr std::uint64_t kMagic = 0x6874757274'6c6e63ULL;
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kWords = sizeof(Truth) / sizeof(std::uint64_t);
static_assert(kWords * sizeof(std::uint64_t) == sizeof(Truth), "every field of Truth is one word");
using Words = std::array<std::uint64_t, kWords>;

}  // namespace

// Atomics that are lock-free have the same layout in every process that maps them.
struct TruthFile::Mapped {
  std::atomic<std::uint64_t> magic;
  std::atomic<std::uint32_t> version;
  std::atomic<std::uint32_t> sequence;  // odd while a write is under way
  std::array<std::atomic<std::uint64_t>, kWords> words;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

Result<std::unique_ptr<TruthFile>, Problem> TruthFile::create(const std::string& path) {
  const auto problem = [&](const char* step) {
    return Problem{path, fmt::format("{} failed ({})", step, std::strerror(errno)), "is the directory writable?"};
  };
  ::unlink(path.c_str());  // a reader of an earlier world keeps that one's
  const io::Descriptor file{::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644)};
  if (!file.is_open()) return err(problem("making the truth file"));
  if (::ftruncate(file.number(), sizeof(Mapped)) != 0) return err(problem("sizing the truth file"));
  void* const memory = ::mmap(nullptr, sizeof(Mapped), PROT_READ | PROT_WRITE, MAP_SHARED, file.number(), 0);
  if (memory == MAP_FAILED) return err(problem("mapping the truth file"));
  auto* const mapped = new (memory) Mapped{};
  mapped->version.store(kVersion, std::memory_order_relaxed);
  mapped->magic.store(kMagic, std::memory_order_release);
  return std::unique_ptr<TruthFile>{new TruthFile{path, mapped}};
}

TruthFile::~TruthFile() {
  ::munmap(mapped_, sizeof(Mapped));
  ::unlink(path_.c_str());
}

void TruthFile::write(const Truth& truth) {
  const auto words = std::bit_cast<Words>(truth);
  const std::uint32_t sequence = mapped_->sequence.load(std::memory_order_relaxed);
  mapped_->sequence.store(sequence + 1, std::memory_order_relaxed);
  // Release on each word keeps it behind the odd number; Source: Boehm 2012, "Can seqlocks get along with programming
  // language memory models?", figure 6 without the fence, which thread sanitizers do not understand.
  for (std::size_t i = 0; i < kWords; ++i) mapped_->words[i].store(words[i], std::memory_order_release);
  mapped_->sequence.store(sequence + 2, std::memory_order_release);
}

Result<Truth, TruthFault> read_truth(const std::string& path) {
  using Mapped = TruthFile::Mapped;
  const io::Descriptor file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
  if (!file.is_open()) return err(TruthFault::NotThere);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0 || status.st_size != static_cast<off_t>(sizeof(Mapped))) {
    return err(TruthFault::NotATruth);
  }
  void* const memory = ::mmap(nullptr, sizeof(Mapped), PROT_READ, MAP_SHARED, file.number(), 0);
  if (memory == MAP_FAILED) return err(TruthFault::NotThere);
  const auto unmap = [](void* at) { ::munmap(at, sizeof(Mapped)); };
  const std::unique_ptr<void, decltype(unmap)> mapping{memory, unmap};
  const auto& mapped = *static_cast<const Mapped*>(memory);
  if (mapped.magic.load(std::memory_order_acquire) != kMagic ||
      mapped.version.load(std::memory_order_relaxed) != kVersion) {
    return err(TruthFault::NotATruth);
  }
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const std::uint32_t before = mapped.sequence.load(std::memory_order_acquire);
    Words words{};
    for (std::size_t i = 0; i < kWords; ++i) words[i] = mapped.words[i].load(std::memory_order_acquire);
    if (before % 2 == 0 && mapped.sequence.load(std::memory_order_acquire) == before)
      return std::bit_cast<Truth>(words);
    ::sched_yield();
  }
  return err(TruthFault::KeepsChanging);
}

}  // namespace nacelle::simulation
