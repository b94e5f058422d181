// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/crash_record.hpp"

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <sys/prctl.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string_view>

#include "executor_thread.hpp"
#include "nacelle/base/expect.hpp"
#include "nacelle/runtime/executor.hpp"
#include "safe_stop.hpp"
#include "stop_watcher.hpp"
#include "symbol.hpp"

namespace nacelle::runtime {
namespace {

// A signal handler has no user argument, so its data is static.
constexpr std::array<int, 5> kSignals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
std::array<struct sigaction, kSignals.size()> before{};
std::array<char, 4096> record_file{};
std::array<char, 64> container_name{};
std::atomic<bool> installed{false};
std::atomic<pid_t> watched_process{0};  // forked children are not watched
std::atomic<pid_t> crashing{0};         // the thread that writes the record
constexpr std::size_t kFrames = 48;
constexpr unsigned kRecordSeconds = 3;  // to write the record in

const char* name_of(int number) noexcept {
  switch (number) {
    case SIGSEGV: return "SIGSEGV";
    case SIGBUS: return "SIGBUS";
    case SIGFPE: return "SIGFPE";
    case SIGILL: return "SIGILL";
    case SIGABRT: return "SIGABRT";
    default: return "signal";
  }
}

// Text output for a signal handler: no heap, no locale, only write().
class Lines {
 public:
  explicit Lines(int file) : file_(file) {}
  Lines& operator<<(std::string_view text) noexcept {
    for (const char c : text) {
      if (used_ == buffer_.size()) flush();
      buffer_[used_++] = c;
    }
    return *this;
  }
  Lines& operator<<(const char* text) noexcept { return *this << std::string_view{text}; }
  Lines& number(std::uint64_t value) noexcept { return digits(value, 10); }
  Lines& hex(std::uint64_t value) noexcept { return (*this << "0x").digits(value, 16); }
  void flush() noexcept {
    for (const int to : {file_, STDERR_FILENO}) {
      std::size_t done = 0;
      while (to >= 0 && done < used_) {
        const ssize_t n = ::write(to, buffer_.data() + done, used_ - done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        done += static_cast<std::size_t>(n);
      }
    }
    used_ = 0;
  }

 private:
  Lines& digits(std::uint64_t value, unsigned base) noexcept {
    std::array<char, 24> text{};
    std::size_t at = text.size();
    do {
      text[--at] = "0123456789abcdef"[value % base];
      value /= base;
    } while (value != 0);
    return *this << std::string_view{text.data() + at, text.size() - at};
  }
  const int file_;
  std::array<char, 512> buffer_{};
  std::size_t used_ = 0;
};

void* program_counter(const void* context) noexcept {
  const auto& machine = static_cast<const ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  return std::bit_cast<void*>(machine.gregs[REG_RIP]);
#elif defined(__aarch64__)
  return std::bit_cast<void*>(machine.pc);
#else
  static_cast<void>(machine);
  return nullptr;
#endif
}

struct Place {
  const char* image = "";  // empty: the program itself
  std::uint64_t offset = 0;
  bool known = false;
};

// glibc promises that _dl_find_object() may be called here; dladdr() and dl_iterate_phdr() take the linker's lock.
Place place_of(void* code) noexcept {
  dl_find_object found{};
  if (code == nullptr || _dl_find_object(code, &found) != 0) return {};
  const auto* const map = found.dlfo_link_map;
  return {map->l_name, static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(code) - map->l_addr), true};
}

void show(Lines& out, const Place& place) noexcept {
  if (!place.known) {
    out << "unknown";
  } else {
    (out << (*place.image != '\0' ? place.image : "the program") << " +").hex(place.offset);
  }
}

bool is_component(const CrashEntry& entry, const Place& place) noexcept {
  return place.known && *place.image != '\0' && entry.image[0] != '\0' &&
         std::strcmp(entry.image.data(), place.image) == 0;
}

// The components whose library this is: one, unless the library made several.
bool show_owners(Lines& out, const Place& place) noexcept {
  bool any = false;
  for (const CrashEntry* entry = first_crash_entry(); entry != nullptr; entry = entry->next) {
    if (!is_component(*entry, place)) continue;
    out << (any ? " or " : "") << entry->node.data();
    any = true;
  }
  return any;
}

// The reason for the end: a signal, or a called function (`call`, with `status`).
struct Cause {
  int signal = 0;
  const siginfo_t* info = nullptr;
  const void* context = nullptr;
  const char* call = "";
  int status = 0;
};

void show_cause(Lines& out, const Cause& cause) noexcept {
  out << "\nsignal: ";
  if (cause.signal == 0) {
    (out << cause.call << "(").number(static_cast<std::uint64_t>(static_cast<unsigned>(cause.status) & 0xffU))
        << ") was called";
    return;
  }
  out << name_of(cause.signal);
  if (cause.signal != SIGABRT) (out << " at address ").hex(reinterpret_cast<std::uintptr_t>(cause.info->si_addr));
}

// Returns the age of the youngest component that `is_meant` selects.
template <typename Selects>
void show_age(Lines& out, const timespec& now, const Selects& is_meant) noexcept {
  const CrashEntry* youngest = nullptr;
  for (const CrashEntry* entry = first_crash_entry(); entry != nullptr; entry = entry->next) {
    if (is_meant(*entry) && (youngest == nullptr || entry->up_since_ns > youngest->up_since_ns)) youngest = entry;
  }
  if (youngest == nullptr) return;
  const std::int64_t age_ns = std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec - youngest->up_since_ns;
  (out << "component age: ").number(static_cast<std::uint64_t>(std::max<std::int64_t>(age_ns, 0) / 1'000'000));
  out << (youngest->was_activated ? " ms since its activation\n" : " ms since it was loaded\n");
}

void show_symbol(Lines& out, const Place& place, const char* lead, bool is_caller) noexcept {
  if (!place.known) return;
  SymbolText symbol{};
  // A return address may be the first byte of the next function.
  if (find_symbol(*place.image != '\0' ? place.image : "/proc/self/exe", place.offset - (is_caller ? 1U : 0U), symbol))
    out << lead << symbol.data();
}

void write_record(const Cause& cause, unsigned stops) noexcept {
  const int file = record_file[0] == '\0'
                       ? -1
                       : ::open(record_file.data(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  Lines out{file};
  timespec now{}, steady{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  ::clock_gettime(CLOCK_MONOTONIC, &steady);
  std::array<char, 17> thread{};
  ::prctl(PR_GET_NAME, thread.data());
  out << "nacelle crash record\ncontainer: " << container_name.data();
  show_cause(out, cause);
  (out << "\ntime: ").number(static_cast<std::uint64_t>(now.tv_sec)) << " s after 1970\nprocess: ";
  out.number(static_cast<std::uint64_t>(::getpid())) << "\nthread: " << thread.data();
  (out << "\nsafe stops written: ").number(stops) << "\n";
  const Executor::RunsHere runs = Executor::runs_here();
  const bool by_executor = *runs.node != '\0';
  if (by_executor) {
    out << "component: " << runs.node << "\ncallback: " << runs.what;
    if (*runs.name != '\0') out << " " << runs.name;
    out << "\n";
    if (*runs.name == '/') out << "stream: " << runs.name << "\n";
    show_age(out, steady, [&](const CrashEntry& entry) { return std::strcmp(entry.node.data(), runs.node) == 0; });
  }
  Place named;  // the place whose symbol the record names
  if (cause.signal != 0) {
    named = place_of(program_counter(cause.context));
    out << "library: ";
    show(out, named);
    out << "\n";
  }
  bool is_caller = false;
  out.flush();  // the next part reads a stack that may be corrupt
  std::array<void*, kFrames> frames{};
  const int count = ::backtrace(frames.data(), kFrames);
  // abort() crashes in the C library: the responsible code is further up the stack.
  for (int i = 0; i < count; ++i) {
    const Place caller = place_of(frames[static_cast<std::size_t>(i)]);
    bool is_theirs = false;
    for (const CrashEntry* entry = first_crash_entry(); entry != nullptr; entry = entry->next)
      is_theirs = is_theirs || is_component(*entry, caller);
    if (!is_theirs) continue;
    if (!by_executor) {
      out << "component: ";
      static_cast<void>(show_owners(out, caller));
      out << "\ncallback: thread " << thread.data() << "\n";
      show_age(out, steady, [&](const CrashEntry& entry) { return is_component(entry, caller); });
    }
    out << "component code: ";
    show(out, caller);
    out << "\n";
    is_caller = !named.known || caller.offset != named.offset;
    named = caller;
    break;
  }
  out.flush();
  show_symbol(out, named, "symbol: ", is_caller);
  out << "\ncalls, the innermost first:\n";
  for (int i = 0; i < count; ++i) {
    out << "  ";
    const Place call = place_of(frames[static_cast<std::size_t>(i)]);
    show(out, call);
    show_symbol(out, call, " ", true);
    out << "\n";
  }
  out << "end\n";
  out.flush();
  if (file >= 0) ::close(file);
}

// Everything to do before the process ends. The stop frames are written first, and once more after the record: other
// threads kept running, and a control loop may have written its next command after the stop.
void stop_and_record(const Cause& cause) noexcept {
  const unsigned stops = write_all_safe_stops();
  // stderr may not be read, and a process stuck in write() would keep the motor board's watchdog satisfied, hence the
  // alarm. It needs a thread that does not block it, as this one may.
  ::signal(SIGALRM, SIG_DFL);
  sigset_t alarm_only;
  sigemptyset(&alarm_only);
  sigaddset(&alarm_only, SIGALRM);
  ::pthread_sigmask(SIG_UNBLOCK, &alarm_only, nullptr);
  ::alarm(kRecordSeconds);
  write_record(cause, stops);
  static_cast<void>(write_all_safe_stops());
  ::alarm(0);
}

void on_crash(int number, siginfo_t* info, void* context) {
  pid_t first = 0;
  if (const pid_t self = ::gettid(); !crashing.compare_exchange_strong(first, self)) {
    // A second thread that crashes meanwhile must not end the process before the record is complete.
    if (first != self) {
      for (;;) ::pause();
    }
    // Writing the record caused this crash (a corrupt stack): the record ends here, and so does the process.
    static_cast<void>(write_all_safe_stops());
    ::signal(number, SIG_DFL);
    sigset_t these;
    sigemptyset(&these);
    sigaddset(&these, number);
    ::pthread_sigmask(SIG_UNBLOCK, &these, nullptr);
    ::raise(number);
    ::_exit(128 + number);
  }
  const int saved = errno;
  stop_and_record({.signal = number, .info = info, .context = context});
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before[i], nullptr);
  crashing = 0;
  errno = saved;
  // A fault of the code happens again when this returns, now with the default action. A signal that was sent must be
  // sent again.
  if (info->si_code <= 0) ::raise(number);
}

void unblock_fault_signals() noexcept {
  sigset_t these;
  sigemptyset(&these);
  for (const int number : kSignals) sigaddset(&these, number);
  ::pthread_sigmask(SIG_UNBLOCK, &these, nullptr);
}

}  // namespace

void record_exit(const char* call, int status) noexcept {
  if (!installed || ::getpid() != watched_process) return;
  pid_t first = 0;
  if (const pid_t self = ::gettid(); !crashing.compare_exchange_strong(first, self)) {
    if (first == self) return;
    for (;;) ::pause();
  }
  stop_and_record({.call = call, .status = status});
  ::_exit(status != 0 ? status : 1);
}

CrashHandler::CrashHandler(const std::string& file, const std::string& container)
    : stack_(std::make_unique<SignalStack>()) {
  NACELLE_EXPECT(!installed.exchange(true), "one CrashHandler per process at a time");
  NACELLE_EXPECT(file.size() < record_file.size(), "the path of a crash record has less than 4096 characters");
  record_file.fill('\0');
  std::ranges::copy(file, record_file.begin());
  container_name.fill('\0');
  std::copy_n(container.begin(), std::min(container.size(), container_name.size() - 1), container_name.begin());
  // The first call loads a library, which a handler must not do.
  std::array<void*, 2> frames{};
  static_cast<void>(::backtrace(frames.data(), static_cast<int>(frames.size())));
  struct sigaction action {};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &action, &before[i]);
  // The parent process may have blocked them.
  unblock_fault_signals();
  watched_process = ::getpid();
  static const bool hears_of_exits = [] {
    return ::on_exit([](int status, void*) { record_exit("exit", status); }, nullptr) == 0 &&
           std::at_quick_exit([] { record_exit("quick_exit", 0); }) == 0;
  }();
  static_cast<void>(hears_of_exits);
  watcher_ = std::make_unique<StopWatcher>();
}

CrashHandler::~CrashHandler() {
  watcher_.reset();
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before[i], nullptr);
  installed = false;
}

std::string crash_record_line(const std::string& record, const std::string& key) {
  const std::string start = key + ": ";
  for (std::size_t at = 0; at < record.size();) {
    const std::size_t end = std::min(record.find('\n', at), record.size());
    if (record.compare(at, start.size(), start) == 0 && at + start.size() <= end)
      return record.substr(at + start.size(), end - at - start.size());
    at = end + 1;
  }
  return {};
}

}  // namespace nacelle::runtime
