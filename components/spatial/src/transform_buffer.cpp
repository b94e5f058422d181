// SPDX-License-Identifier: Apache-2.0
#include "nacelle/spatial/transform_buffer.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <thread>

#include "frame_history.hpp"
#include "frame_names.hpp"
#include "nacelle/base/expect.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::spatial {
namespace {

constexpr int kMaxDepth = 1000;           // tf2: MAX_GRAPH_DEPTH
constexpr double kNormTolerance = 10e-3;  // tf2: QUATERNION_NORMALIZATION_TOLERANCE
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

std::string_view without_slash(std::string_view name) { return name.starts_with('/') ? name.substr(1) : name; }

}  // namespace

struct [[gnu::visibility("hidden")]] TransformBuffer::Impl {
  explicit Impl(const TransformBufferOptions& given)
      : options(given),
        names(given.max_frames),
        histories(std::make_unique<FrameHistory[]>(given.max_frames + 1)),
        known(std::make_unique<std::atomic<bool>[]>(given.max_frames + 1)),
        writers(std::make_unique<std::atomic<std::uint64_t>[]>(given.max_frames + 1)) {}

  [[nodiscard]] bool is_known(FrameId frame) const {
    return frame && frame.value <= options.max_frames && known[frame.value].load(std::memory_order_acquire);
  }
  [[nodiscard]] LookupFault fault(TransformError error, FrameId target, FrameId source) const {
    LookupFault f;
    f.error = error;
    f.target = FrameLabel{names.name(target.value)};
    f.source = FrameLabel{names.name(source.value)};
    return f;
  }
  [[nodiscard]] LookupFault extrapolation(const FrameHistory::Answer& answer, std::uint32_t frame, FrameId target,
                                          FrameId source, std::int64_t at_ns) const;
  [[nodiscard]] bool climb_newest(FrameId target, FrameId source, StampedTransform & out) const;
  [[nodiscard]] Result<std::int64_t, LookupFault> latest_common(FrameId target, FrameId source) const;
  [[nodiscard]] Result<StampedTransform, LookupFault> walk(FrameId target, FrameId source, std::int64_t at_ns) const;
  [[nodiscard]] Result<void, LookupFault> check(FrameId target, FrameId source) const;
  [[nodiscard]] FrameId known_frame(std::string_view name) const;
  [[nodiscard]] static LookupFault wrong_argument(bool at_target, std::string_view target, std::string_view source);
  [[nodiscard]] Result<StampedTransform, LookupFault> latest(FrameId target, FrameId source) const;
  [[nodiscard]] StampedTransform where_it_is(FrameId frame, WallTime at) const;
  template <typename Look>
  [[nodiscard]] Result<StampedTransform, LookupFault> wait(Duration timeout, const Look& look) const;

  TransformBufferOptions options;
  FrameNames names;
  std::unique_ptr<FrameHistory[]> histories;              // by id; [0] is unused
  std::unique_ptr<std::atomic<bool>[]> known;             // named by a transform, as parent or child
  std::unique_ptr<std::atomic<std::uint64_t>[]> writers;  // of each frame's last sample
  std::shared_ptr<const ClockSkews> skews_owner NACELLE_GUARDED_BY(writing);
  std::atomic<const ClockSkews*> skews{nullptr};  // asked by faults only
  mutable Mutex writing;                          // inserts, new names, stats and all below
  TransformBufferStats stats NACELLE_GUARDED_BY(writing);
  std::vector<Listener*> listeners NACELLE_GUARDED_BY(writing);
  std::thread::id feeder NACELLE_GUARDED_BY(writing);  // the thread of the last insert
  mutable std::condition_variable inserted;
  mutable int waiting NACELLE_GUARDED_BY(writing){0};
};

LookupFault TransformBuffer::Impl::extrapolation(const FrameHistory::Answer& answer, std::uint32_t frame,
                                                 FrameId target, FrameId source, std::int64_t at_ns) const {
  TransformError error = TransformError::NoDataForExtrapolation;
  if (answer.found == FrameHistory::Found::TooEarly) error = TransformError::BackwardExtrapolation;
  if (answer.found == FrameHistory::Found::TooLate) error = TransformError::ForwardExtrapolation;
  LookupFault f = fault(error, target, source);
  f.broken_at = FrameLabel{names.name(frame)};
  f.requested = WallTime{Duration{at_ns}};
  f.available = WallTime{Duration{answer.available_ns}};
  if (const ClockSkews* const asked = skews) f.skew = asked->of_writer(writers[frame].load(std::memory_order_relaxed));
  return f;
}

Result<void, LookupFault> TransformBuffer::Impl::check(FrameId target, FrameId source) const {
  if (is_known(target) && is_known(source)) return {};
  LookupFault f = fault(TransformError::Lookup, target, source);
  f.at_target = !is_known(target);
  return err(f);
}

// The fast path for the usual lookup: a sensor below the base, with one moving frame in its chain, or several with one stamp. Then
// the newest samples are the result of one walk. Returns false if this does not apply.
bool TransformBuffer::Impl::climb_newest(FrameId target, FrameId source, StampedTransform& out) const {
  std::uint32_t frame = source.value;
  std::int64_t stamp_ns = kNever;
  RigidTransform X_PC;
  for (int depth = 0; frame != target.value; ++depth) {
    const auto newest = histories[frame].newest(X_PC);
    if (newest.parent == 0 || depth > kMaxDepth) return false;
    if (!newest.is_static) {
      if (stamp_ns != kNever && newest.stamp_ns != stamp_ns) return false;
      stamp_ns = newest.stamp_ns;
    }
    if (depth == 0) {
      out.X_TS = X_PC;
    } else {
      out.X_TS = X_PC * out.X_TS;
    }
    frame = newest.parent;
  }
  out.stamp = WallTime{Duration{stamp_ns == kNever ? 0 : stamp_ns}};
  return true;
}

// The newest stamp that all frames below the common ancestor have reached. Both chains are walked by their newest parents.
Result<std::int64_t, LookupFault> TransformBuffer::Impl::latest_common(FrameId target, FrameId source) const {
  // Mark the way up from the source: the time reached at each ancestor. Chains of robots are short; longer ones walk twice.
  std::int64_t source_ns = kNever;
  std::uint32_t frame = source.value;
  struct Mark {
    std::uint32_t frame;
    std::int64_t reached_ns;
  };
  constexpr std::size_t kMarks = 64;
  std::array<Mark, kMarks> marks;
  std::size_t count = 0;
  for (int depth = 0; frame != 0; ++depth) {
    if (depth > kMaxDepth) return err(fault(TransformError::Transform, target, source));
    if (frame == target.value) return source_ns == kNever ? 0 : source_ns;
    if (count < kMarks) marks[count++] = {frame, source_ns};
    const auto newest = histories[frame].newest();
    if (newest.parent != 0 && !newest.is_static) source_ns = std::min(source_ns, newest.stamp_ns);
    frame = newest.parent;
  }
  std::int64_t target_ns = kNever;
  frame = target.value;
  for (int depth = 0; frame != 0; ++depth) {
    if (depth > kMaxDepth) return err(fault(TransformError::Transform, target, source));
    for (std::size_t i = 0; i < count; ++i) {
      if (marks[i].frame != frame) continue;
      const std::int64_t both = std::min(target_ns, marks[i].reached_ns);
      return both == kNever ? 0 : both;
    }
    const auto newest = histories[frame].newest();
    if (newest.parent != 0 && !newest.is_static) target_ns = std::min(target_ns, newest.stamp_ns);
    frame = newest.parent;
  }
  if (count < kMarks) return err(fault(TransformError::Connectivity, target, source));
  // An ancestor beyond the marks: the earliest stamp of both whole chains is common to any frame that joins them.
  const std::int64_t both = std::min(source_ns, target_ns);
  return both == kNever ? 0 : both;
}

Result<StampedTransform, LookupFault> TransformBuffer::Impl::walk(FrameId target, FrameId source,
                                                                  std::int64_t at_ns) const {
  const WallTime stamp{Duration{at_ns}};
  RigidTransform X_PC;
  RigidTransform X_top_source;
  FrameHistory::Answer stopped;  // why the source's chain ended, if not at a root
  std::uint32_t stopped_at = 0;
  std::uint32_t top = source.value;
  for (int depth = 0; top != target.value; ++depth) {
    if (depth > kMaxDepth) return err(fault(TransformError::Transform, target, source));
    const auto answer = histories[top].at(at_ns, X_PC);
    if (answer.found != FrameHistory::Found::Interpolated) {
      stopped = answer;
      stopped_at = top;
      break;
    }
    X_top_source = depth == 0 ? X_PC : X_PC * X_top_source;
    top = answer.parent;
  }
  if (top == target.value) return StampedTransform{X_top_source, stamp};

  RigidTransform X_top_target;
  std::uint32_t frame = target.value;
  for (int depth = 0; frame != top; ++depth) {
    if (depth > kMaxDepth) return err(fault(TransformError::Transform, target, source));
    const auto answer = histories[frame].at(at_ns, X_PC);
    if (answer.found == FrameHistory::Found::Nothing) break;
    if (answer.found != FrameHistory::Found::Interpolated)
      return err(extrapolation(answer, frame, target, source, at_ns));
    X_top_target = depth == 0 ? X_PC : X_PC * X_top_target;
    frame = answer.parent;
    if (frame == source.value) return StampedTransform{X_top_target.inverse(), stamp};
  }
  if (frame == top) return StampedTransform{X_top_target.inverse() * X_top_source, stamp};
  if (stopped.found != FrameHistory::Found::Nothing)
    return err(extrapolation(stopped, stopped_at, target, source, at_ns));
  return err(fault(TransformError::Connectivity, target, source));
}

FrameId TransformBuffer::Impl::known_frame(std::string_view name) const {
  const FrameId id{name.empty() || name.front() == '/' ? 0 : names.find(name)};
  return is_known(id) ? id : FrameId{};
}

LookupFault TransformBuffer::Impl::wrong_argument(bool at_target, std::string_view target, std::string_view source) {
  const std::string_view name = at_target ? target : source;
  LookupFault f;
  f.error = name.empty() || name.starts_with('/') ? TransformError::InvalidArgument : TransformError::Lookup;
  f.at_target = at_target;
  f.target = FrameLabel{target};
  f.source = FrameLabel{source};
  return f;
}

TransformBuffer::TransformBuffer(const TransformBufferOptions& options) {
  NACELLE_EXPECT(std::has_single_bit(options.samples_per_frame) && options.samples_per_frame >= 4,
                 "the history of a frame is a ring of 4, 8, 16, ... samples");
  NACELLE_EXPECT(std::has_single_bit(options.most_samples_per_frame), "rings double, up to a power of two");
  NACELLE_EXPECT(options.max_frames > 0 && options.cache_time > 0ns, "a transform buffer needs room for one frame");
  impl_ = std::make_unique<Impl>(options);
}
TransformBuffer::~TransformBuffer() = default;

FrameId TransformBuffer::intern(std::string_view name) {
  name = without_slash(name);
  if (name.empty()) return {};
  if (const std::uint32_t id = impl_->names.find(name); id != 0) return {id};
  const LockGuard lock{impl_->writing};
  return {impl_->names.add(name)};
}
void TransformBuffer::explain_by(std::shared_ptr<const ClockSkews> skews) {
  const LockGuard lock{impl_->writing};
  if (impl_->skews_owner) return;  // a lookup may be using it
  impl_->skews_owner = std::move(skews);
  impl_->skews = impl_->skews_owner.get();
}

FrameId TransformBuffer::find(std::string_view name) const { return {impl_->names.find(without_slash(name))}; }
std::string_view TransformBuffer::name(FrameId frame) const { return impl_->names.name(frame.value); }

Result<void, InsertFault> TransformBuffer::insert(FrameId parent, FrameId child, WallTime stamp,
                                                  const RigidTransform& X_PC, Permanence permanence,
                                                  std::uint64_t writer) {
  const LockGuard lock{impl_->writing};
  TransformBufferStats& stats = impl_->stats;
  const auto refuse = [](std::uint64_t& counter, InsertFault fault) -> Result<void, InsertFault> {
    ++counter;
    return err(fault);
  };
  if (!parent || !child) return refuse(stats.empty_frame, InsertFault::EmptyFrame);
  NACELLE_EXPECT(parent.value <= impl_->names.size() && child.value <= impl_->names.size(),
                 "a FrameId belongs to the buffer that made it");
  if (parent == child) return refuse(stats.self_transform, InsertFault::SelfTransform);
  if (!X_PC.rotation.coeffs().allFinite() || !X_PC.translation_m.allFinite()) {
    return refuse(stats.not_finite, InsertFault::NotFinite);
  }
  if (std::abs(X_PC.rotation.squaredNorm() - 1.0) >= kNormTolerance) {
    return refuse(stats.not_normalised, InsertFault::NotNormalised);
  }
  TransformSample sample{stamp.nanoseconds(), parent.value, X_PC};
  // Chains multiply norms, so an error within the tolerance would grow along them.
  if (std::abs(X_PC.rotation.squaredNorm() - 1.0) > 1e-12) sample.X_PC.rotation.normalize();
  const FrameHistory::Sizes sizes{impl_->options.cache_time.count(), impl_->options.samples_per_frame,
                                  impl_->options.most_samples_per_frame};
  switch (impl_->histories[child.value].add(sample, permanence, sizes)) {
    case FrameHistory::Added::TooOld: return refuse(stats.too_old, InsertFault::TooOld);
    case FrameHistory::Added::Duplicate: ++stats.duplicates; return {};
    case FrameHistory::Added::Yes: break;
  }
  ++stats.inserted;
  impl_->writers[child.value].store(writer, std::memory_order_relaxed);
  impl_->known[parent.value].store(true, std::memory_order_release);
  impl_->known[child.value].store(true, std::memory_order_release);
  impl_->feeder = std::this_thread::get_id();
  if (impl_->waiting != 0) impl_->inserted.notify_all();
  for (Listener* const listener : impl_->listeners) listener->on_insert();
  return {};
}

Result<void, InsertFault> TransformBuffer::insert(std::string_view parent, std::string_view child, WallTime stamp,
                                                  const RigidTransform& X_PC, Permanence permanence,
                                                  std::uint64_t writer) {
  parent = without_slash(parent);
  child = without_slash(child);
  if (parent == child && !parent.empty()) {
    const LockGuard lock{impl_->writing};
    ++impl_->stats.self_transform;
    return err(InsertFault::SelfTransform);
  }
  const FrameId parent_id = intern(parent);
  const FrameId child_id = parent_id ? intern(child) : FrameId{};
  if (!parent.empty() && !child.empty() && (!parent_id || !child_id)) {
    const LockGuard lock{impl_->writing};
    ++impl_->stats.too_many_frames;
    return err(InsertFault::TooManyFrames);
  }
  return insert(parent_id, child_id, stamp, X_PC, permanence, writer);
}

Result<StampedTransform, LookupFault> TransformBuffer::Impl::latest(FrameId target, FrameId source) const {
  Result<StampedTransform, LookupFault> found{StampedTransform{}};
  if (climb_newest(target, source, *found)) return found;
  const auto common = latest_common(target, source);
  if (!common) return err(common.error());
  return walk(target, source, *common);
}

// As tf2: the identity needs no known frame.
StampedTransform TransformBuffer::Impl::where_it_is(FrameId frame, WallTime at) const {
  StampedTransform here;
  here.stamp = at;
  if (at == WallTime{} && is_known(frame)) here.stamp = WallTime{Duration{histories[frame.value].newest().stamp_ns}};
  return here;
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup(FrameId target, FrameId source, WallTime at) const {
  if (target && target == source) return impl_->where_it_is(target, at);
  if (const auto known = impl_->check(target, source); !known) return err(known.error());
  return at == WallTime{} ? impl_->latest(target, source) : impl_->walk(target, source, at.nanoseconds());
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup_latest(FrameId target, FrameId source) const {
  return lookup(target, source, WallTime{});
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup(std::string_view target, std::string_view source,
                                                              WallTime at) const {
  if (target == source) return impl_->where_it_is({impl_->names.find(target)}, at);
  const FrameId target_id = impl_->known_frame(target);
  if (!target_id) return err(Impl::wrong_argument(true, target, source));
  const FrameId source_id = impl_->known_frame(source);
  if (!source_id) return err(Impl::wrong_argument(false, target, source));
  return at == WallTime{} ? impl_->latest(target_id, source_id) : impl_->walk(target_id, source_id, at.nanoseconds());
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup_latest(std::string_view target,
                                                                     std::string_view source) const {
  return lookup(target, source, WallTime{});
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup(std::string_view target, WallTime target_time,
                                                              std::string_view source, WallTime source_time,
                                                              std::string_view fixed) const {
  if (!impl_->known_frame(target)) return err(Impl::wrong_argument(true, target, source));
  if (!impl_->known_frame(source)) return err(Impl::wrong_argument(false, target, source));
  if (!impl_->known_frame(fixed)) {
    LookupFault fault = Impl::wrong_argument(false, target, fixed);
    fault.at_fixed = true;
    return err(fault);
  }
  auto X_FS = lookup(fixed, source, source_time);
  if (!X_FS) return X_FS;
  auto X_TF = lookup(target, fixed, target_time);
  if (!X_TF) return X_TF;
  return StampedTransform{X_TF->X_TS * X_FS->X_TS, X_TF->stamp};
}

// The lock keeps inserts out between a look that finds nothing and the wait.
template <typename Look>
Result<StampedTransform, LookupFault> TransformBuffer::Impl::wait(Duration timeout, const Look& look) const {
  auto found = look();
  if (found || timeout <= 0ns) return found;
  const auto deadline = std::chrono::steady_clock::now() + std::min<Duration>(timeout, 24h);
  UniqueLock lock{writing};
  if (feeder == std::this_thread::get_id()) {
    LookupFault fault = found.error();
    fault.would_starve = true;
    return err(fault);
  }
  ++waiting;
  inserted.wait_until(lock.raw(), deadline, [&] {
    found = look();
    return found.has_value();
  });
  --waiting;
  return found;
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup(std::string_view target, std::string_view source,
                                                              WallTime at, Duration timeout) const {
  return impl_->wait(timeout, [&] { return lookup(target, source, at); });
}

Result<StampedTransform, LookupFault> TransformBuffer::lookup(std::string_view target, WallTime target_time,
                                                              std::string_view source, WallTime source_time,
                                                              std::string_view fixed, Duration timeout) const {
  return impl_->wait(timeout, [&] { return lookup(target, target_time, source, source_time, fixed); });
}

void TransformBuffer::add_listener(Listener& listener) {
  const LockGuard lock{impl_->writing};
  impl_->listeners.push_back(&listener);
}
void TransformBuffer::remove_listener(Listener& listener) {
  const LockGuard lock{impl_->writing};
  std::erase(impl_->listeners, &listener);
}

std::vector<FrameInfo> TransformBuffer::frames() const {
  std::vector<FrameInfo> all;
  for (std::uint32_t id = 1; id <= impl_->names.size(); ++id) {
    const auto newest = impl_->histories[id].newest();
    if (newest.parent == 0) continue;
    const auto span = impl_->histories[id].span();
    all.push_back({std::string{impl_->names.name(id)}, std::string{impl_->names.name(newest.parent)}, newest.is_static,
                   WallTime{Duration{span.oldest_ns}}, WallTime{Duration{span.newest_ns}}, span.samples,
                   impl_->writers[id].load(std::memory_order_relaxed)});
  }
  std::sort(all.begin(), all.end(), [](const FrameInfo& a, const FrameInfo& b) { return a.child < b.child; });
  return all;
}

TransformBufferStats TransformBuffer::stats() const {
  const LockGuard lock{impl_->writing};
  return impl_->stats;
}

void TransformBuffer::clear() {
  const LockGuard lock{impl_->writing};
  for (std::uint32_t id = 1; id <= impl_->names.size(); ++id) {
    impl_->histories[id].clear();
    impl_->known[id].store(false, std::memory_order_release);
  }
}

void TransformBuffer::forget_moving() {
  const LockGuard lock{impl_->writing};
  for (std::uint32_t id = 1; id <= impl_->names.size(); ++id) {
    if (!impl_->histories[id].newest().is_static) impl_->histories[id].clear();
  }
}

std::string_view to_text(InsertFault fault) {
  switch (fault) {
    case InsertFault::EmptyFrame: return "a frame id is empty";
    case InsertFault::SelfTransform: return "parent and child are the same frame";
    case InsertFault::NotFinite: return "a value is not finite";
    case InsertFault::NotNormalised: return "the quaternion is not normalised";
    case InsertFault::TooOld: return "older than the cache time before the frame's newest sample";
    case InsertFault::TooManyFrames: return "too many frames";
  }
  return "?";
}

TransformBufferPtr make_transform_buffer(const TransformBufferOptions& options) {
  return std::make_shared<TransformBuffer>(options);
}
std::shared_ptr<void> make_shared_transform_buffer() { return make_transform_buffer(); }

}  // namespace nacelle::spatial
