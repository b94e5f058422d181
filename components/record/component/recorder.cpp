// SPDX-License-Identifier: Apache-2.0
#include "record/component/recorder.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <set>

namespace nacelle::record {
namespace {

constexpr Duration kTick = 250ms;        // chunks and figures
constexpr Duration kBreather = 5ms;      // publishers do not wake the thread meanwhile
constexpr std::size_t kLeastDepth = 16;  // several breathers of a stream of 1 kHz
constexpr int kMostAtOnce = 256;
constexpr int kNice = 5;

/// Of messages in a device's memory as few as possible are kept from it.
QoS fitting(const std::vector<QoS>& offered, bool holds_buffers) {
  return holds_buffers ? reader_qos(offered, 1, 1) : reader_qos(offered, kLeastDepth, 4 * kLeastDepth);
}

std::uint64_t nanoseconds(WallTime time) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, time.since_origin.count()));
}

}  // namespace

struct Recorder::Stream final : ReadyListener {
  explicit Stream(Recorder& o) : owner(o) {}
  void on_ready() noexcept override {
    if (!queued.exchange(true)) owner.note_ready(*this);
  }
  Recorder& owner;
  std::size_t topic = 0;
  QoS qos{1};
  std::atomic<bool> queued{false};
  std::uint64_t lost_before = 0;  // by earlier readers
  std::unique_ptr<Reader> reader;
};

Recorder::Recorder(GenericTopics topics, Options options, std::unique_ptr<Recording> recording,
                   std::function<void(const Problem&)> on_end)
    : topics_(std::move(topics)),
      options_(std::move(options)),
      on_end_(std::move(on_end)),
      recording_(std::move(recording)),
      begun_(topics_.clock().now()),
      is_paused_(options_.starts_paused) {
  graph_ = topics_.watch(*this);
  {
    const LockGuard lock{mutex_};
    std::swap(changes_, changes_now_);
  }
  take_changes();  // what is published from now on is recorded
  note_figures();
  thread_ = std::thread{[this] { run(); }};
}

Recorder::~Recorder() { static_cast<void>(stop()); }

std::optional<Problem> Recorder::stop() {
  if (!thread_.joinable()) return std::nullopt;
  graph_.reset();
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  auto problem = recording_->problem() ? std::nullopt : recording_->finish();
  note_figures();
  return problem;
}

void Recorder::split() {
  {
    const LockGuard lock{mutex_};
    splits_ = true;
  }
  changed_.notify_all();
}

RecorderFigures Recorder::figures() const {
  const LockGuard lock{mutex_};
  return figures_;
}

// --- told by publishers, with locks of theirs held ------------------------------------------------------------------------

void Recorder::on_made(const EndpointInfo& endpoint) noexcept {
  if (!endpoint.is_writer) return;
  {
    const LockGuard lock{mutex_};
    if (is_ending_) return;
    changes_.push_back({endpoint.id, endpoint});
  }
  changed_.notify_all();
}

void Recorder::on_gone(std::uint64_t id) noexcept {
  const LockGuard lock{mutex_};
  if (!is_ending_) changes_.push_back({id, std::nullopt});  // read with the next change: it does not wake the thread
}

void Recorder::note_ready(Stream& stream) noexcept {
  bool wakes = false;
  {
    const LockGuard lock{mutex_};
    ready_.push_back(&stream);
    wakes = is_sleeping_ && ready_.size() == 1;
  }
  if (wakes) changed_.notify_all();
}

// --- the recorder's thread ----------------------------------------------------------------------------------------------

void Recorder::run() {
  ::pthread_setname_np(::pthread_self(), "record");
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
  bool goes_on = true;
  while (goes_on && !recording_->problem()) {
    goes_on = wait();
    recording_->look_at_time(topics_.clock().now());
    take_changes();
    // At the end all queues are emptied: a stream may have been made ready without a word.
    if (goes_on) {
      for (Stream* const stream : ready_now_) take_messages(*stream);
    } else {
      for (auto& [key, stream] : streams_) take_messages(*stream);
    }
    if (topics_.clock().now() >= figures_due_) note_figures();
  }
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;  // changes are not collected any more
  }
  // A recorder that has ended costs its publishers nothing.
  for (auto& [key, stream] : streams_) close_reader(*stream);
  note_figures();
  if (recording_->problem()) on_end_(*recording_->problem());
}

/// Keeps what the reader has lost, for the figures.
void Recorder::close_reader(Stream& stream) {
  stream.lost_before += stream.reader->status().lost;
  stream.reader.reset();
}

/// Returns false when it is to end.
bool Recorder::wait() {
  UniqueLock lock{mutex_};
  changed_.wait_for(lock.raw(), kBreather, [this]() NACELLE_REQUIRES(mutex_) { return is_ending_; });
  is_sleeping_ = true;
  changed_.wait_for(lock.raw(), kTick, [this]() NACELLE_REQUIRES(mutex_) {
    return is_ending_ || splits_ || !changes_.empty() || !ready_.empty();
  });
  is_sleeping_ = false;
  changes_now_.clear();
  ready_now_.clear();
  std::swap(changes_, changes_now_);
  std::swap(ready_, ready_now_);
  const bool splits = std::exchange(splits_, false), goes_on = !is_ending_;
  lock.unlock();
  if (splits) recording_->split();
  return goes_on;
}

void Recorder::take_changes() {
  std::set<Key> touched;
  for (Change& change : changes_now_) {
    if (!change.made) {
      writers_.erase(change.writer);
    } else if (options_.choice.takes(change.made->spec.topic)) {
      Key key{change.made->spec.topic, change.made->spec.type};
      touched.insert(key);
      writers_.insert_or_assign(change.writer, std::pair{std::move(key), change.made->spec.qos});
    }
  }
  for (const Key& key : touched) read(key);
}

void Recorder::read(const Key& key) {
  std::vector<QoS> offered;
  for (const auto& [id, writer] : writers_) {
    if (writer.first == key) offered.push_back(writer.second);
  }
  if (offered.empty()) return;  // it came and went
  const QoS qos = fitting(offered, key.second->holds_buffers);
  auto& stream = streams_[key];
  const bool is_new = !stream;
  if (is_new) {
    stream = std::make_unique<Stream>(*this);
    stream->topic = recording_->add_topic(key.first, *key.second, std::move(offered));
  } else if (stream->qos.reliability() == qos.reliability() && stream->qos.durability() == qos.durability()) {
    return;
  } else {
    take_messages(*stream);
    close_reader(*stream);  // before the next one is made: no message is recorded twice
  }
  stream->qos = qos;
  stream->reader = topics_.read(key.first, *key.second, qos, *stream);
  take_messages(*stream);  // its history
}

void Recorder::take_messages(Stream& stream) {
  // Reset before reading: messages that come meanwhile signal again.
  stream.queued = false;
  // What comes after a pause is not understood without the messages that stay (a map, fixed transforms).
  const bool is_wanted = !is_paused_ || stream.qos.durability() == Durability::TransientLocal;
  for (int left = kMostAtOnce; left > 0; --left) {
    Block* const block = stream.reader->take();
    if (block == nullptr) return;
    if (is_wanted) {
      const Clock& clock = topics_.clock();
      const MonotonicTime now = clock.now();
      const WallTime wall = clock.wall_now();
      // A message of the publisher's history comes when the recording begins, however old it is.
      const MonotonicTime came = std::max(block->info.received_time, begun_);
      recording_->write(stream.topic, block->message, nanoseconds(wall - (now - came)),
                        nanoseconds(wall - (now - block->info.source_time)));
    }
    drop_reference(*block);
  }
  stream.on_ready();  // others get their turn
}

void Recorder::note_figures() {
  RecorderFigures made;
  made.folder = recording_->folder();
  made.file = recording_->file();
  made.files = recording_->files();
  made.bytes = recording_->bytes();
  made.messages = recording_->messages();
  made.problem = recording_->problem();
  const MonotonicTime now = topics_.clock().now();
  made.recorded = now - begun_;
  for (const auto& topic : recording_->topics())
    made.topics.push_back({topic.known.name, topic.known.type, topic.known.messages, topic.bytes, 0, topic.lost});
  for (const auto& [key, stream] : streams_)
    made.topics[stream->topic].lost_in_queue =
        stream->lost_before + (stream->reader ? stream->reader->status().lost : 0);
  for (const auto& topic : made.topics) made.lost += topic.lost_in_queue + topic.lost_to_disk;
  figures_due_ = now + kTick;
  const LockGuard lock{mutex_};
  figures_ = std::move(made);
}

}  // namespace nacelle::record
