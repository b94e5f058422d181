// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/reader_thread.hpp"

#include <pthread.h>

#include <algorithm>
#include <exception>

namespace nacelle::io {

ReaderThread::ReaderThread(ByteStream& stream, const Clock& clock, ByteSink& sink, Options options)
    : stream_(stream),
      clock_(clock),
      sink_(sink),
      options_(std::move(options)),
      backoff_(options_.first_pause, options_.longest_pause),
      thread_([this] { run(); }) {}

void ReaderThread::stop() {
  {
    const LockGuard lock{mutex_};
    stop_ = true;
  }
  stop_asked_.notify_all();
  stream_.interrupt();
  if (thread_.joinable()) thread_.join();
}

bool ReaderThread::stopping() const {
  const LockGuard lock{mutex_};
  return stop_;
}

bool ReaderThread::pause(Duration length) {
  UniqueLock lock{mutex_};
  return !stop_asked_.wait_for(lock.raw(), length, [this]() NACELLE_REQUIRES(mutex_) { return stop_; });
}

bool ReaderThread::bring_back() {
  for (;;) {
    // In pieces: a sink that watches for silence wants to hear of this one, too.
    for (Duration left = backoff_.next(); left > Duration::zero(); left -= options_.silence) {
      if (!pause(std::min(left, options_.silence))) return false;
      ++stats_.lock()->silences;
      sink_.on_silence(clock_.now());
    }
    if (stopping()) return false;
    const auto opened = reopen();
    next_set_up_ = clock_.now() + options_.longest_pause;
    if (opened) return true;
    sink_.on_refusal(opened.error());
  }
}

Result<void, StreamFault> ReaderThread::reopen() {
  if (auto opened = stream_.reopen(); !opened) return opened;
  return options_.set_up ? options_.set_up() : Result<void, StreamFault>{};
}

// The device was power-cycled behind an adapter that stayed on: the line never broke, but the device lost its settings.
void ReaderThread::set_up_again(MonotonicTime now) {
  if (!options_.set_up || sink_.hears() || now < next_set_up_) return;
  static_cast<void>(options_.set_up());  // a line that breaks says so at the next read
  next_set_up_ = clock_.now() + backoff_.next();
}

void ReaderThread::run() {
  // The name is cut, not refused: pthread_setname_np() takes 15 characters and fails on more.
  pthread_setname_np(pthread_self(), options_.name.substr(0, 15).c_str());
  if (!options_.on_exception) return read();
  try {
    read();
  } catch (const std::exception& e) { options_.on_exception(e.what()); } catch (...) {
    options_.on_exception("an exception other than a std::exception");
  }
}

void ReaderThread::read() {
  bool knows_first = false;
  while (!stopping()) {
    const auto bytes = stream_.read_until(sink_.look_at(clock_.now() + options_.silence));
    const MonotonicTime now = clock_.now();
    if (!bytes) {
      ++stats_.lock()->breaks;
      sink_.on_break(bytes.error(), now);
      if (!options_.reopen || !bring_back()) return;
      ++stats_.lock()->returns;
      sink_.on_return(clock_.now());
    } else if (bytes->empty()) {
      if (stopping()) return;
      ++stats_.lock()->silences;
      sink_.on_silence(now);
      set_up_again(now);
    } else {
      {
        auto stats = stats_.lock();
        stats->bytes += bytes->size();
        ++stats->chunks;
      }
      if (!knows_first) {
        auto first = first_.lock();
        first->add(*bytes);
        knows_first = first->is_full();
      }
      sink_.on_bytes(*bytes, now);
      if (sink_.hears()) backoff_.reset();
      set_up_again(now);
    }
  }
}

}  // namespace nacelle::io
