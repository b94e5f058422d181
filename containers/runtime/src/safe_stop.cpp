// SPDX-License-Identifier: Apache-2.0
#include "safe_stop.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>

#include "nacelle/base/expect.hpp"
#include "stop_watcher.hpp"

namespace nacelle::runtime {
namespace {

std::atomic<CrashEntry*> head{nullptr};
std::atomic<std::size_t> numbers_given{0};
static_assert(std::atomic<CrashEntry*>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

// Returns a recycled entry, or a new one: only as many are ever made as components existed at the same time.
CrashEntry& take_entry() {
  for (CrashEntry* entry = head.load(std::memory_order_acquire); entry != nullptr; entry = entry->next) {
    bool expected = false;
    if (entry->in_use.compare_exchange_strong(expected, true)) return *entry;
  }
  auto* const made = new CrashEntry;
  made->next = head.load(std::memory_order_relaxed);
  while (!head.compare_exchange_weak(made->next, made, std::memory_order_release)) {}
  return *made;
}

template <std::size_t N>
void copy_text(const std::string& text, std::array<char, N>& into) {
  into.fill('\0');
  std::copy_n(text.begin(), std::min(text.size(), N - 1), into.begin());
}

std::int64_t monotonic_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// A reader sees the frame with its descriptor, or no descriptor.
template <typename Stop>
void publish_frame(Stop& stop, int descriptor, ByteView frame, std::size_t bytes_a_write) {
  static_cast<void>(stop.descriptor.exchange(-1, std::memory_order_acq_rel));  // acquire: the copy stays behind it
  std::ranges::copy(frame, stop.frame.begin());
  stop.length = frame.size();
  stop.bytes_a_write = bytes_a_write;
  stop.descriptor.store(descriptor, std::memory_order_release);
}

bool write_frame(const CrashEntry& entry) noexcept {
  const int descriptor = entry.descriptor.load(std::memory_order_acquire);
  return descriptor >= 0 && write_stop(descriptor, {entry.frame.data(), entry.length}, entry.bytes_a_write);
}

std::size_t bytes_a_write_of(int descriptor) {
  constexpr std::size_t kCanFrameBytes = 16;  // struct can_frame
  int family = 0;
  socklen_t length = sizeof family;
  const bool is_socket = ::getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &family, &length) == 0;
  return is_socket && family == AF_CAN ? kCanFrameBytes : 0;
}

}  // namespace

bool write_stop(int descriptor, ByteView frame, std::size_t bytes_a_write) noexcept {
  const std::size_t step = bytes_a_write == 0 ? frame.size() : bytes_a_write;
  bool all = !frame.empty();
  for (std::size_t at = 0; at < frame.size(); at += step) {
    const std::size_t length = std::min(step, frame.size() - at);
    if (::write(descriptor, frame.data() + at, length) != static_cast<ssize_t>(length)) all = false;
  }
  return all;
}

const CrashEntry* first_crash_entry() noexcept { return head.load(std::memory_order_acquire); }

unsigned write_all_safe_stops() noexcept {
  unsigned written = 0;
  for (const CrashEntry* entry = first_crash_entry(); entry != nullptr; entry = entry->next)
    written += write_frame(*entry) ? 1U : 0U;
  return written;
}

void mirror_safe_stops() noexcept {
  for (const CrashEntry* entry = first_crash_entry(); entry != nullptr; entry = entry->next) {
    const int descriptor = entry->descriptor.load(std::memory_order_acquire);
    WatchedStop* const copy = watched_stop(entry->number);
    if (descriptor >= 0 && copy != nullptr) {
      publish_frame(*copy, descriptor, {entry->frame.data(), entry->length}, entry->bytes_a_write);
    }
  }
}

SafeStop::SafeStop(const std::string& node) : entry_(take_entry()) {
  copy_text(node, entry_.node);
  entry_.was_activated = false;
  entry_.up_since_ns = monotonic_ns();
}

SafeStop::~SafeStop() {
  clear();
  for (const auto& further : further_) {
    if (CrashEntry* const entry = further.load()) entry->in_use.store(false, std::memory_order_release);
  }
  entry_.node.fill('\0');
  entry_.image.fill('\0');
  entry_.in_use.store(false, std::memory_order_release);
}

void SafeStop::set_image(const std::string& image) { copy_text(image, entry_.image); }

CrashEntry& SafeStop::entry_for(int descriptor) {
  const auto is_its = [descriptor](const CrashEntry& entry) {
    const int has = entry.descriptor.load();
    return has < 0 || has == descriptor;
  };
  if (is_its(entry_)) return entry_;
  for (auto& further : further_) {
    if (further.load() == nullptr) further.store(&take_entry(), std::memory_order_release);
    if (is_its(*further.load())) return *further.load();
  }
  NACELLE_EXPECT(false, "a component has four stop frames at most");
  return entry_;
}

void SafeStop::set(int descriptor, ByteView frame, std::size_t bytes_a_write) {
  CrashEntry& entry = entry_for(descriptor);
  NACELLE_EXPECT(frame.size() <= entry.frame.size(), "a stop frame fits into 64 bytes");
  if (bytes_a_write == 0) bytes_a_write = bytes_a_write_of(descriptor);
  if (entry.number == CrashEntry::kNoNumber) entry.number = numbers_given.fetch_add(1);
  publish_frame(entry, descriptor, frame, bytes_a_write);
  if (WatchedStop* const copy = watched_stop(entry.number)) publish_frame(*copy, descriptor, frame, bytes_a_write);
  was_set_.store(true, std::memory_order_relaxed);
}

void SafeStop::clear() {
  const auto withdraw = [](CrashEntry& entry) {
    entry.descriptor.store(-1, std::memory_order_release);
    if (WatchedStop* const copy = watched_stop(entry.number)) copy->descriptor.store(-1, std::memory_order_release);
  };
  withdraw(entry_);
  for (const auto& further : further_) {
    if (CrashEntry* const entry = further.load()) withdraw(*entry);
  }
}

void SafeStop::note_activation() {
  entry_.up_since_ns = monotonic_ns();
  entry_.was_activated = true;
}

void SafeStop::write() const noexcept {
  static_cast<void>(write_frame(entry_));
  for (const auto& further : further_) {
    if (const CrashEntry* const entry = further.load(std::memory_order_acquire)) static_cast<void>(write_frame(*entry));
  }
}

}  // namespace nacelle::runtime
