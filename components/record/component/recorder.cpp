// SPDX-License-Identifier: Apache-2.0
#include "record/component/recorder.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <set>

#include "record/component/image_memory.hpp"
#include "record/component/special_topics.hpp"

namespace nacelle::record {
namespace {

constexpr Duration kTick = 250ms;        // chunks and figures
constexpr Duration kBreather = 5ms;      // publishers do not wake the thread meanwhile
constexpr std::size_t kLeastDepth = 16;  // several breathers of a stream of 1 kHz
constexpr int kMostAtOnce = 256;
constexpr int kRecorderNice = 5;

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
  enum class Use : std::uint8_t { Record, Stop, Description } use = Use::Record;
  // Of streams that are not recorded.
  std::string name;
  const msgs::MessageType* type = nullptr;
  QoS qos{1};
  std::atomic<bool> queued{false};
  std::uint64_t lost_before = 0;  // by earlier readers
  std::uint64_t lost() const {
    if (!reader) return lost_before;
    return lost_before + reader->status().lost + reader->counters().inactive;  // closed: see take_messages()
  }
  std::unique_ptr<Reader> reader;
};

Recorder::Recorder(GenericTopics topics, Options options, std::unique_ptr<MessageLog> log,
                   std::function<void(const Problem&)> on_end)
    : topics_(std::move(topics)),
      options_(std::move(options)),
      on_end_(std::move(on_end)),
      log_(std::move(log)),
      begun_(topics_.clock().now()),
      is_paused_(options_.starts_paused),
      file_(log_->file()) {
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
  log_->say_at_end(closing_words(figures()));
  auto problem = log_->problem() ? std::nullopt : log_->finish();
  note_figures();
  return problem;
}

void Recorder::split() {
  static_cast<void>(post([this] { log_->split(); }));
}

bool Recorder::post(std::function<void()> job) {
  {
    const LockGuard lock{mutex_};
    if (is_ending_) return false;
    jobs_.push_back(std::move(job));
  }
  changed_.notify_all();
  return true;
}

RecorderFigures Recorder::figures() const {
  const LockGuard lock{mutex_};
  return figures_;
}

// --- told by publishers, with locks of theirs held ------------------------------------------------------------------------

void Recorder::on_made(const EndpointInfo& endpoint) noexcept {
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
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kRecorderNice);
  bool goes_on = true;
  while (goes_on && !log_->problem()) {
    goes_on = wait();
    log_->look_at_time(topics_.clock().now());
    take_changes();
    // At the end all queues are emptied: a stream may have been made ready without a word.
    if (goes_on) {
      for (Stream* const stream : ready_now_) take_messages(*stream);
    } else {
      for (auto& [key, stream] : streams_) take_messages(*stream);
    }
    run_jobs();
    tell_split();
    if (options_.on_round) options_.on_round(topics_.clock().now());
    if (topics_.clock().now() >= figures_due_) note_figures();
  }
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;  // changes are not collected any more
    jobs_.clear();
  }
  for (auto& [key, stream] : stops_) stream->reader.reset();
  for (auto& [key, stream] : descriptions_) stream->reader.reset();
  // A recorder that has ended costs its publishers nothing.
  for (auto& [key, stream] : streams_) close_reader(*stream);
  note_figures();
  if (log_->problem()) on_end_(*log_->problem());
}

/// Keeps what the reader has lost, for the figures.
void Recorder::close_reader(Stream& stream) {
  stream.lost_before = stream.lost();
  stream.reader.reset();
}

/// Returns false when it is to end.
bool Recorder::wait() {
  UniqueLock lock{mutex_};
  changed_.wait_for(lock.raw(), kBreather, [this]() NACELLE_REQUIRES(mutex_) { return is_ending_; });
  is_sleeping_ = true;
  changed_.wait_for(lock.raw(), kTick, [this]() NACELLE_REQUIRES(mutex_) {
    return is_ending_ || !jobs_.empty() || !changes_.empty() || !ready_.empty();
  });
  is_sleeping_ = false;
  changes_now_.clear();
  ready_now_.clear();
  std::swap(changes_, changes_now_);
  std::swap(ready_, ready_now_);
  std::swap(jobs_, jobs_now_);
  return !is_ending_;
}

/// Of several splits at once, the last one.
void Recorder::tell_split() {
  if (log_->file() == file_) return;
  if (options_.on_split) options_.on_split(file_, log_->file());
  file_ = log_->file();
}

void Recorder::run_jobs() {
  for (const auto& job : jobs_now_) job();
  jobs_now_.clear();
}

void Recorder::take_changes() {
  std::set<Key> touched;
  for (Change& change : changes_now_) {
    if (!change.made) {
      writers_.erase(change.endpoint);
      ends_.erase(change.endpoint);
      forget_stop_reader(change.endpoint);
      continue;
    }
    note_end(*change.made);
    if (!change.made->is_writer) {
      if (options_.on_stop && is_emergency_stop(change.made->spec)) look_for_stop(*change.made);
    } else {
      if (is_description(change.made->spec)) look_for_description(*change.made);
      if (!options_.choice.takes(change.made->spec.topic)) continue;
      Key key{change.made->spec.topic, change.made->spec.type};
      touched.insert(key);
      writers_.insert_or_assign(change.endpoint, std::pair{std::move(key), change.made->spec.qos});
    }
  }
  for (const Key& key : touched) {
    if (!is_left(key)) read(key);
  }
}

/// Only programs outside publish it with this type, and somebody here uses the topic with another one.
bool Recorder::is_left(const Key& key) const {
  bool is_used = false;
  for (const auto& [id, end] : ends_) {
    if (end == key) return false;
    is_used = is_used || end.first == key.first;
  }
  return is_used;
}

void Recorder::read(const Key& key) {
  std::vector<QoS> offered;
  for (const auto& [id, writer] : writers_) {
    if (writer.first == key) offered.push_back(writer.second);
  }
  if (!offered.empty()) read(key, std::move(offered));  // else it came and went
}

/// A remote topic that somebody here uses now is left to its type: the network has one reader's type for all.
void Recorder::note_end(const EndpointInfo& endpoint) {
  if (endpoint.spec.via != 0 || endpoint.spec.node == topics_.node()) return;
  const Key key{endpoint.spec.topic, endpoint.spec.type};
  ends_.emplace(endpoint.id, key);
  for (auto remote = remote_.begin(); remote != remote_.end();) {
    if (remote->first != key.first || *remote == key) {
      ++remote;
      continue;
    }
    if (Stream& stream = *streams_.at(*remote); stream.reader) close_reader(stream);
    remote = remote_.erase(remote);
  }
}

void Recorder::add_remote(const std::string& topic, const msgs::MessageType& type, const std::vector<QoS>& offered) {
  static_cast<void>(post([this, key = Key{topic, &type}, offered] {
    const auto is_used = [&](const auto& end) { return end.second.first == key.first; };
    if (std::any_of(ends_.begin(), ends_.end(), is_used)) return;
    remote_.insert(key);
    const auto known = streams_.find(key);
    if (known == streams_.end() || !known->second->reader) read(key, offered);
  }));
}

void Recorder::read(const Key& key, std::vector<QoS> offered) {
  const QoS qos = fitting(offered, key.second->holds_buffers);
  auto& stream = streams_[key];
  const bool is_new = !stream;
  if (is_new) {
    stream = std::make_unique<Stream>(*this);
    stream->topic = log_->add_topic(key.first, *key.second, std::move(offered));
  } else if (!stream->reader) {
    // It was left to another type, which nobody here uses any more.
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

void Recorder::look_for_description(const EndpointInfo& endpoint) {
  const Key key{endpoint.spec.topic, endpoint.spec.type};
  auto& stream = descriptions_[key];
  if (stream) return;
  stream = std::make_unique<Stream>(*this);
  stream->use = Stream::Use::Description;
  stream->name = key.first;
  stream->type = key.second;
  stream->reader = topics_.read(key.first, *key.second, fitting({endpoint.spec.qos}, false), *stream);
  take_description(*stream);
}

/// One text is enough: recordings have the topic for others.
void Recorder::take_description(Stream& stream) {
  stream.queued = false;
  Block* const block = stream.reader ? stream.reader->take() : nullptr;
  if (block == nullptr) return;
  log_->attach({stream.name.substr(1) + ".urdf", "application/xml", text_in(*stream.type, block->message)},
               nanoseconds(topics_.clock().wall_now()));
  drop_reference(*block);
  stream.reader.reset();
}

/// A stop is read as long as somebody else reads it. The reader fits each publisher, and gets nothing of what was published before.
void Recorder::look_for_stop(const EndpointInfo& endpoint) {
  if (endpoint.spec.node == topics_.node()) return;
  const Key key{endpoint.spec.topic, endpoint.spec.type};
  stop_readers_.emplace(endpoint.id, key);
  auto& stream = stops_[key];
  if (!stream) stream = std::make_unique<Stream>(*this);
  if (stream->reader) return;
  stream->use = Stream::Use::Stop;
  stream->name = key.first;
  stream->type = key.second;
  stream->reader = topics_.read(key.first, *key.second, QoS{kLeastDepth}.best_effort(), *stream);
}

void Recorder::forget_stop_reader(std::uint64_t reader) {
  const auto found = stop_readers_.find(reader);
  if (found == stop_readers_.end()) return;
  const Key key = found->second;
  stop_readers_.erase(found);
  const bool is_read =
      std::any_of(stop_readers_.begin(), stop_readers_.end(), [&](const auto& other) { return other.second == key; });
  if (!is_read) stops_[key]->reader.reset();
}

void Recorder::take_stops(Stream& stream) {
  stream.queued = false;
  while (stream.reader) {
    Block* const block = stream.reader->take();
    if (block == nullptr) return;
    if (is_set(*stream.type, block->message)) options_.on_stop(stream.name);
    drop_reference(*block);
  }
}

void Recorder::take_messages(Stream& stream) {
  if (stream.use == Stream::Use::Stop) return take_stops(stream);
  if (stream.use == Stream::Use::Description) return take_description(stream);
  // Reset before reading: messages that come meanwhile signal again.
  stream.queued = false;
  // What comes after a pause is not understood without the messages that stay (a map, fixed transforms).
  const bool is_wanted = !is_paused_ || stream.qos.durability() == Durability::TransientLocal;
  for (int left = stream.reader ? kMostAtOnce : 0; left > 0; --left) {
    Block* const block = stream.reader->take();
    if (block == nullptr) return;
    // The memory is a device's, which has few: no other one is held until this one is encoded.
    const bool is_only_one = block->via == 0 && is_lent(*log_->topics()[stream.topic].type, block->message);
    if (is_only_one) stream.reader->set_enabled(false);
    if (is_wanted) record(stream, *block);
    drop_reference(*block);
    if (is_only_one) stream.reader->set_enabled(true);
  }
  if (stream.reader) stream.on_ready();  // others get their turn
}

void Recorder::record(Stream& stream, Block& block) {
  const Clock& clock = topics_.clock();
  const MonotonicTime now = clock.now();
  const WallTime wall = clock.wall_now();
  // A message of the publisher's history comes when the recording begins, however old it is.
  const MonotonicTime came = std::max(block.info.received_time, begun_);
  log_->write(
      stream.topic, block.message,
      {nanoseconds(wall - (now - came)), nanoseconds(wall - (now - block.info.source_time)), block.info.writer_id});
}

void Recorder::note_figures() {
  RecorderFigures made;
  made.folder = log_->folder();
  made.file = log_->file();
  made.files = log_->files();
  made.bytes = log_->bytes();
  made.messages = log_->messages();
  made.reach = log_->reach();
  made.problem = log_->problem();
  const MonotonicTime now = topics_.clock().now();
  made.recorded = now - begun_;
  for (const auto& topic : log_->topics())
    made.topics.push_back({topic.known.name, topic.known.type, topic.known.messages, topic.bytes, 0, topic.lost,
                           is_image(*topic.type) ? topic.known.messages : 0});
  for (const auto& [key, stream] : streams_) made.topics[stream->topic].lost_in_queue = stream->lost();
  for (const auto& topic : made.topics) {
    made.copies += topic.copies;
    if (topic.copies > 0) made.bytes_copied += topic.bytes;
  }
  for (const std::string& name : options_.choice.named()) {
    const auto is_it = [&](const RecorderFigures::Topic& topic) { return topic.name == name && topic.messages > 0; };
    if (std::none_of(made.topics.begin(), made.topics.end(), is_it)) made.absent.push_back(name);
  }
  for (const auto& topic : made.topics) made.lost += topic.lost_in_queue + topic.lost_to_disk;
  figures_due_ = now + kTick;
  const LockGuard lock{mutex_};
  figures_ = std::move(made);
}

}  // namespace nacelle::record
