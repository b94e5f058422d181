// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/scripted_stream.hpp"

namespace nacelle::io {

ScriptedStream::ScriptedStream(std::vector<Step> script, AtEnd at_end, Wait wait)
    : script_(std::make_move_iterator(script.begin()), std::make_move_iterator(script.end())),
      at_end_(at_end),
      wait_(std::move(wait)) {}

Result<ByteView, StreamFault> ScriptedStream::read_until(MonotonicTime deadline) {
  UniqueLock lock{mutex_};
  if (broken_) return err(*broken_);
  if (script_.empty() && at_end_ == AtEnd::Blocks) {
    reader_waits_ = true;
    changed_.notify_all();
    changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return interrupted_ || !script_.empty(); });
    reader_waits_ = false;
  }
  if (std::exchange(interrupted_, false)) return ByteView{};
  if (script_.empty() && at_end_ == AtEnd::HangsUp) {
    broken_ = StreamFault::HungUp;
    return err(*broken_);
  }
  if (script_.empty() || script_.front().at > deadline) {
    if (wait_) wait_(deadline);
    return ByteView{};
  }
  Step step = std::move(script_.front());
  script_.pop_front();
  if (wait_) wait_(step.at);
  if (step.fault) {
    broken_ = step.fault;
    return err(*broken_);
  }
  current_ = std::move(step.bytes);
  return ByteView{current_};
}

Result<void, StreamFault> ScriptedStream::write(ByteView bytes) {
  const LockGuard lock{mutex_};
  if (broken_) return err(*broken_);
  if (write_fault_) return err(*write_fault_);
  if (holds_writes_) {
    unsent_.insert(unsent_.end(), bytes.begin(), bytes.end());
    return {};
  }
  written_.insert(written_.end(), bytes.begin(), bytes.end());
  if (device_) {
    Bytes answer = device_(bytes);
    if (!answer.empty()) {
      const MonotonicTime at = script_.empty() ? MonotonicTime{} : script_.front().at;
      script_.push_front({at, std::move(answer), {}});
      changed_.notify_all();
    }
  }
  return {};
}

std::size_t ScriptedStream::unsent() const noexcept {
  const LockGuard lock{mutex_};
  return unsent_.size();
}

void ScriptedStream::drop_unsent() noexcept {
  const LockGuard lock{mutex_};
  unsent_.clear();
}

Result<void, StreamFault> ScriptedStream::set_data_terminal_ready(bool ready) {
  const LockGuard lock{mutex_};
  if (broken_) return err(*broken_);
  data_terminal_ready_ = ready;
  return {};
}

std::optional<bool> ScriptedStream::data_terminal_ready() const {
  const LockGuard lock{mutex_};
  return data_terminal_ready_;
}

void ScriptedStream::hold_writes(bool hold) {
  const LockGuard lock{mutex_};
  holds_writes_ = hold;
  if (hold) return;
  written_.insert(written_.end(), unsent_.begin(), unsent_.end());
  unsent_.clear();
}

void ScriptedStream::interrupt() noexcept {
  const LockGuard lock{mutex_};
  interrupted_ = true;
  changed_.notify_all();
}

Result<void, StreamFault> ScriptedStream::reopen() {
  const LockGuard lock{mutex_};
  if (refusals_ > 0) {
    --refusals_;
    return err(StreamFault::NotFound);
  }
  broken_.reset();
  away_ = false;
  return {};
}

bool ScriptedStream::is_away() const noexcept {
  const LockGuard lock{mutex_};
  return away_;
}

void ScriptedStream::start_away() {
  const LockGuard lock{mutex_};
  away_ = true;
  broken_ = StreamFault::NotFound;
}

void ScriptedStream::append(Step step) {
  const LockGuard lock{mutex_};
  script_.push_back(std::move(step));
  changed_.notify_all();
}

void ScriptedStream::wait_until_read() {
  UniqueLock lock{mutex_};
  changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return reader_waits_ && script_.empty(); });
}

void ScriptedStream::refuse_reopen(std::size_t times) {
  const LockGuard lock{mutex_};
  refusals_ = times;
}

void ScriptedStream::fail_writes(std::optional<StreamFault> fault) {
  const LockGuard lock{mutex_};
  write_fault_ = fault;
}

Bytes ScriptedStream::written() const {
  const LockGuard lock{mutex_};
  return written_;
}

void ScriptedStream::answer_writes(std::function<Bytes(ByteView)> device) {
  const LockGuard lock{mutex_};
  device_ = std::move(device);
}

}  // namespace nacelle::io
