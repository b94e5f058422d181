// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/container_facts.hpp"
#include "record/component/ring.hpp"
#include "record/component/snapshot_thread.hpp"

namespace nacelle::record {

/// Decides when a ring is written: when it is asked, and by itself a second after an emergency stop or a fault, so that what follows is in it,
/// too. Those by itself are 10 s apart or more; what happens meanwhile shares the next one.
///
/// Threads: look_at(), on_stop() and snapshot() are the recorder's; the others, any.
class BlackBox {
 public:
  struct Options {
    std::function<std::string()> folder;  ///< Returns the folder for a recording that begins now.
    Compression compression = Compression::None;
    std::uint64_t keep_free = 0;
    /// Told of each snapshot, on its thread: its reason, and what became of it.
    std::function<void(const std::string&, const Result<Snapshot, Problem>&)> on_written;
  };
  BlackBox(Options options, std::shared_ptr<const ContainerFacts> facts);

  /// To be called several times a second.
  void look_at(Ring& ring, MonotonicTime now);
  /// Writes the ring at once if an event waits: the recorder ends.
  void finish(Ring& ring);
  /// The emergency stop of this topic was set.
  void on_stop(const std::string& topic);
  /// Writes the ring. `done` is called on the snapshots' thread.
  void snapshot(Ring& ring, const std::string& reason, const std::function<void(bool is_written)>& done);
  /// Writes what a killed process left.
  void recover(std::shared_ptr<RingFolder> left);

  struct Figures {
    std::uint64_t snapshots = 0;
    std::string last;                ///< The folder of the last one.
    std::optional<Problem> problem;  ///< Why the last one could not be written.
  };
  [[nodiscard]] Figures figures() const { return *figures_.lock(); }

 private:
  void look_for_faults();
  [[nodiscard]] SnapshotWish wish(const std::string& reason) const;
  void note(const std::string& reason, const Result<Snapshot, Problem>& result);

  const Options options_;
  const std::shared_ptr<const ContainerFacts> facts_;
  // The recorder's own.
  std::uint64_t faults_seen_;
  std::string event_;  // empty: none
  std::optional<MonotonicTime> due_, last_;
  Guarded<Figures> figures_;
  SnapshotThread thread_;  // last: it ends before what it tells
};

}  // namespace nacelle::record
