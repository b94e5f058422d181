// SPDX-License-Identifier: Apache-2.0
// between what=count peer=bare|carried [bytes=44] [prepared=1] [messages=1000]   one process, a thread that receives: for callgrind
//                                                                                 (peer=bare path=inline: one thread)
// between what=ratio [bytes=44] [prepared=1] [blocks=40]                          two processes, bare and carried in turn
// Messages from a writer to a sleeping reader through iceoryx's shared memory, one at a time. Needs its daemon (roudi_for_bench).
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <new>
#include <string>
#include <thread>

#include <iceoryx_posh/runtime/posh_runtime.hpp>

#include "between/ends.hpp"
#include "ratios/ratio.hpp"
#include "support/arguments.hpp"

namespace nacelle::bench {
namespace {

constexpr std::uint32_t kMessagesPerBlock = 100;

struct Shared {
  Arrivals bare, carried;
  std::atomic<std::uint64_t> copied_by_receiver{0};
};

Shared& shared_memory() {
  void* const memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) std::perror("between"), std::exit(1);
  return *::new (memory) Shared;
}

double now_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) * 1e9 + static_cast<double>(t.tv_nsec);
}

double block(SendingEnd& sender, Arrivals& arrivals) {
  const std::uint32_t before = arrivals.count();
  const double begin = now_ns();
  for (std::uint32_t i = 1; i <= kMessagesPerBlock; ++i) {
    sender.send(static_cast<std::uint8_t>(i));
    arrivals.wait_for(before + i);
  }
  return (now_ns() - begin) / kMessagesPerBlock;
}

int count_messages(const Arguments& arguments, std::uint32_t bytes, bool prepared) {
  Arrivals arrivals;
  const bool bare = arguments.text("peer", "carried") == "bare";
  if (bare) iox::runtime::PoshRuntime::initRuntime("nacelle-bench-bare");
  if (bare && arguments.text("path", "asleep") == "inline") {
    print_figures({{"delivered", static_cast<double>(bare_in_one_thread(bytes, arguments.number("messages", 1000)))}});
    return 0;
  }
  const auto receiver = bare ? bare_receiver(bytes, arrivals) : carried_receiver(bytes, arrivals);
  const auto sender = bare ? bare_sender(bytes) : carried_sender(bytes, prepared);
  while (!sender->is_connected()) std::this_thread::yield();
  const auto messages = static_cast<std::uint32_t>(arguments.number("messages", 1000));
  for (std::uint32_t i = 1; i <= messages; ++i) {
    sender->send(static_cast<std::uint8_t>(i));
    arrivals.wait_for(i);
  }
  print_figures({{"delivered", arrivals.count()},
                 {"bytes_copied", static_cast<double>(sender->bytes_copied() + receiver->bytes_copied())}});
  return 0;
}

int compare(const Arguments& arguments, std::uint32_t bytes, bool prepared) {
  Shared& shared = shared_memory();
  int ready[2], end[2];
  if (::pipe(ready) != 0 || ::pipe(end) != 0) return std::perror("between"), 1;
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::close(end[1]);
    const auto carried = carried_receiver(bytes, shared.carried);  // starts iceoryx for both
    const auto bare = bare_receiver(bytes, shared.bare);
    char word = 'r';
    if (::write(ready[1], &word, 1) != 1) return 1;
    static_cast<void>(!::read(end[0], &word, 1));  // until the parent closes its end
    shared.copied_by_receiver = carried->bytes_copied();
    return 0;
  }
  ::close(end[0]);
  int status = 0;
  {
    const auto carried = carried_sender(bytes, prepared);
    const auto bare = bare_sender(bytes);
    char word = 0;
    if (::read(ready[0], &word, 1) != 1) return std::fputs("between: the reader did not start\n", stderr), 1;
    while (!carried->is_connected() || !bare->is_connected()) std::this_thread::yield();
    const std::uint64_t blocks = arguments.number("blocks", 40);
    std::uint64_t copied_at_first = 0;
    std::uint64_t runs = 0;
    const Ratio ratio = interleave(
        blocks,
        [&] {
          if (runs++ == 1) copied_at_first = carried->bytes_copied();
          return block(*carried, shared.carried);
        },
        [&] { return block(*bare, shared.bare); });
    ::close(end[1]);
    ::waitpid(child, &status, 0);
    const double messages = static_cast<double>(blocks) * kMessagesPerBlock;
    print_figures({{"a_ns", ratio.a_ns},
                   {"b_ns", ratio.b_ns},
                   {"ratio", ratio.value()},
                   {"copied_per_message", static_cast<double>(carried->bytes_copied() - copied_at_first) / messages},
                   {"copied_by_reader_per_message", static_cast<double>(shared.copied_by_receiver.load()) / messages}});
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

// The words may lie in two processes' memory: not FUTEX_PRIVATE, which std::atomic's wait uses.
void Arrivals::add() {
  count_.fetch_add(1, std::memory_order_acq_rel);
  ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&count_), FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}
void Arrivals::wait_for(std::uint32_t count) {
  for (std::uint32_t now = this->count(); now != count; now = this->count()) {
    ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&count_), FUTEX_WAIT, now, nullptr, nullptr, 0);
  }
}

}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  const auto bytes = static_cast<std::uint32_t>(arguments.number("bytes", 44));
  const bool prepared = arguments.number("prepared", 1) != 0;
  return arguments.text("what", "ratio") == "count" ? count_messages(arguments, bytes, prepared)
                                                    : compare(arguments, bytes, prepared);
}
