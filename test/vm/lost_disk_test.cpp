// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/ioctl.h>
#include <sys/mount.h>

#include <algorithm>
#include <std_msgs/msg/string.hpp>

#include "in_machine.hpp"
#include "nacelle/base/bell.hpp"
#include "record/component/recording.hpp"
#include "record/model/recording_check.hpp"
#include "record/model/recording_copy.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"

namespace nacelle::test {
namespace {

using std_msgs::msg::String;
using namespace record;

constexpr const char* kDisk = "/dev/vda";
constexpr const char* kFolder = "/run/disk";
constexpr std::size_t kMessageBytes = 1000;
constexpr std::uint64_t kMostLost = 2'000'000'000;  // ns
constexpr Duration kRecorded = 4s;                  // before the disk goes

/// Of <linux/fs.h> since Linux 6.10 and of ext4 long before: the file system gives up at once, and writes nothing more.
const unsigned long kShutdown = _IOR('X', 125, std::uint32_t);
constexpr std::uint32_t kWithoutLog = 2;

/// Which of the two machines this is: the first one is killed while it records.
[[nodiscard]] bool is_second_boot() {
  const char* const told = std::getenv("NACELLE_VM_BOOT");
  return told != nullptr && std::string{told} == "2";
}

class LostDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("record");
    mount_disk();
  }
  void TearDown() override { ::umount2(kFolder, MNT_DETACH); }

  void mount_disk() {
    std::filesystem::create_directories(kFolder);
    ASSERT_TRUE(wait_for_node(kDisk, clock_));
    ASSERT_EQ(::mount(kDisk, kFolder, "ext4", 0, nullptr), 0) << std::strerror(errno);
  }
  [[nodiscard]] static std::unique_ptr<Recording> begin(const std::string& folder) {
    auto made = Recording::begin({.folder = folder, .keep_free = 0});
    EXPECT_TRUE(made) << made.error().text();
    return made ? std::move(*made) : nullptr;
  }

  [[nodiscard]] std::uint64_t wall_ns() const { return static_cast<std::uint64_t>(clock_.wall_now().nanoseconds()); }
  /// Records messages, 200 a second, that have the time at which they were written, until the recording ends or `goes_on(time)` does not hold.
  void record_while(Recording& recording, const std::function<bool(std::uint64_t)>& goes_on) {
    const auto topic = recording.add_topic("/chatter", String::message_type(), {QoS(10)});
    String message;
    message.data = std::string(kMessageBytes, 'x');
    Bell never;
    for (MonotonicTime at = clock_.now(); !recording.problem(); at = std::max(at + 5ms, clock_.now())) {
      EXPECT_EQ(io::wait_readable(never.descriptor(), never, clock_, at), io::Wake::TimedOut);
      const std::uint64_t now = wall_ns();
      recording.write(topic, &message, {now, now});
      recording.look_at_time(clock_.now());
      if (!goes_on(now)) return;
    }
  }

  /// Mends a recording as `nacelle bag recover` does, checks the copy as `nacelle bag check` does, and returns the time of its last message.
  [[nodiscard]] static std::uint64_t recover(const std::string& from) {
    const std::string mended = from + ".mended";
    std::filesystem::remove(mended);
    const auto source = FileSource::open(from);
    const auto sink = FileSink::create(mended);
    EXPECT_TRUE(source && sink);
    if (!source || !sink) return 0;
    McapWriter writer{**sink, {}};
    EXPECT_TRUE(writer.start());
    RecordingCopy copy{writer};
    EXPECT_FALSE(walk_mcap(**source, copy)) << "it has an end";
    EXPECT_TRUE(writer.finish() && (*sink)->sync());
    const auto whole = FileSource::open(mended);
    EXPECT_TRUE(whole);
    if (!whole) return 0;
    const auto is_good = [](const std::string&, const std::string& encoding, ByteView bytes) {
      return encoding == "cdr" && bytes.size() > kMessageBytes && bytes[kMessageBytes] == std::uint8_t{'x'}
                 ? PayloadVerdict::Good
                 : PayloadVerdict::Bad;
    };
    const auto report = RecordingCheck{**whole, is_good}.run();
    EXPECT_TRUE(report.complete);
    EXPECT_EQ(report.problem_count, 0U);
    EXPECT_GT(report.messages, 0U);
    RecordingSummary summary;
    EXPECT_TRUE(walk_mcap(**whole, summary));
    return summary.last();
  }

  const SystemClock clock_{};
};

/// Two machines: the host kills the first one (SIGKILL of QEMU) when /out/recorded has come far enough.
TEST_F(LostDisk, power_loss_costs_at_most_two_seconds) {
  const std::string folder = std::string{kFolder} + "/power";
  if (!is_second_boot()) {
    const auto recording = begin(folder);
    ASSERT_TRUE(recording);
    std::ofstream told{"/out/recorded"};
    const MonotonicTime end = clock_.now() + 2 * kPatience;
    record_while(*recording, [&](std::uint64_t now) {
      told << now << '\n' << std::flush;
      return clock_.now() < end;
    });
    FAIL() << "nobody killed this machine";
  }
  std::uint64_t recorded = 0;
  std::ifstream told{"/out/recorded"};
  for (std::uint64_t time = 0; told >> time;) recorded = std::max(recorded, time);
  ASSERT_GT(recorded, 0U);
  const std::uint64_t last = recover(folder + "/power_0.mcap");
  RecordProperty("lost_ms",
                 std::to_string((static_cast<std::int64_t>(recorded) - static_cast<std::int64_t>(last)) / 1'000'000));
  EXPECT_GE(last + kMostLost, recorded);
}

TEST_F(LostDisk, a_pulled_disk_ends_the_recording_and_costs_at_most_two_seconds) {
  if (!is_second_boot()) GTEST_SKIP() << "in the second machine";
  const std::string folder = std::string{kFolder} + "/pulled";
  std::filesystem::remove_all(folder);
  auto recording = begin(folder);
  ASSERT_TRUE(recording);
  const MonotonicTime begun = clock_.now();
  const MonotonicTime end = begun + kPatience;
  std::uint64_t pulled = 0;
  record_while(*recording, [&](std::uint64_t now) {
    if (pulled == 0 && clock_.now() - begun >= kRecorded) {
      // A device that is taken away in order would be written first. A pulled one is not: its file system gives up.
      const io::Descriptor root{::open(kFolder, O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
      std::uint32_t how = kWithoutLog;
      EXPECT_EQ(::ioctl(root.number(), kShutdown, &how), 0) << std::strerror(errno);
      write_file(std::filesystem::canonical("/sys/block/vda/device/..").string() + "/remove", "1");
      pulled = now;
    }
    return clock_.now() < end;
  });
  ASSERT_GT(pulled, 0U) << "it ended before";
  const auto problem = recording->finish();
  ASSERT_TRUE(problem);
  EXPECT_THAT(problem->text(), ::testing::HasSubstr("pulled_0.mcap"));
  EXPECT_THAT(problem->text(), ::testing::HasSubstr("Input/output error"));
  recording.reset();
  EXPECT_FALSE(std::filesystem::exists(kDisk));

  ASSERT_EQ(::umount2(kFolder, 0), 0) << std::strerror(errno);
  write_file("/sys/bus/pci/rescan", "1");
  mount_disk();
  const std::uint64_t last = recover(folder + "/pulled_0.mcap");
  RecordProperty("lost_ms",
                 std::to_string((static_cast<std::int64_t>(pulled) - static_cast<std::int64_t>(last)) / 1'000'000));
  EXPECT_GE(last + kMostLost, pulled);
}

}  // namespace
}  // namespace nacelle::test
