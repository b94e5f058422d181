// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "nacelle/base/mutex.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// Receives the messages of a topic in a test, without a node. Threads: one.
template <typename T>
class TestSubscription : ReadyListener {
 public:
  TestSubscription(Transport& transport, const std::string& topic, const QoS& qos)
      : topic_(topic),
        reader_(transport.create_reader({topic, &T::message_type(), qos, "/test"}, Taking::Share, this)) {}
  ~TestSubscription() override { reader_.reset(); }

  /// Returns whether a message waits, after `limit` at most.
  bool waits(Duration limit) {
    UniqueLock lock(mutex_);
    return arrived_.wait_for(lock.raw(), limit, [this]() NACELLE_REQUIRES(mutex_) { return count_ > 0; });
  }
  /// Returns the next message. Throws std::runtime_error, which fails the test, if none comes within 20 s.
  T next() {
    if (!waits(20s)) throw std::runtime_error{"no message on " + topic_};
    {
      const LockGuard lock(mutex_);
      --count_;
    }
    Block* const block = reader_->take();
    T message = *static_cast<const T*>(block->message);
    writer_ = block->info.writer_id;
    drop_reference(*block);
    return message;
  }
  /// Returns the id of the endpoint that wrote the last message that next() returned.
  [[nodiscard]] std::uint64_t writer() const { return writer_; }

 private:
  void on_ready() noexcept override {
    const LockGuard lock(mutex_);
    ++count_;
    arrived_.notify_all();
  }
  const std::string topic_;
  std::uint64_t writer_ = 0;
  Mutex mutex_;
  std::condition_variable arrived_;
  int count_ NACELLE_GUARDED_BY(mutex_) = 0;
  std::unique_ptr<Reader> reader_;
};

/// Publishes on a topic in a test, without a node. Threads: one.
template <typename T>
class TestPublisher final {
 public:
  TestPublisher(Transport& transport, const std::string& topic, const QoS& qos)
      : writer_(transport.create_writer({topic, &T::message_type(), qos, "/test"})) {}
  void publish(T message) {
    Block* const block = writer_->borrow();
    *static_cast<T*>(block->message) = std::move(message);
    writer_->publish(*block);
  }

 private:
  std::unique_ptr<Writer> writer_;
};

/// A container for the test of a component, which it loads by name as `nacelle launch` does.
///
/// It looks for components in `../lib/nacelle` of the test program, where nacelle_component() and nacelle_test() put them.
/// Threads: one.
class TestContainer final {
 public:
  /// Loads a component by the name of its class, configures it and activates it.
  /// Errors: throws std::runtime_error with the reason, which fails the test.
  ComponentInfo start(const std::string& plugin, std::map<std::string, ParameterValue> parameters = {}) {
    LoadRequest request;
    request.plugin = plugin;
    request.parameters = std::move(parameters);
    const auto loaded = container_.load(request);
    if (!loaded) throw std::runtime_error{loaded.error().text()};
    for (const Transition step : {Transition::Configure, Transition::Activate}) {
      const auto outcome = container_.trigger(loaded.value().id, step);
      if (!outcome.success) throw std::runtime_error{plugin + ": " + outcome.reason};
    }
    return container_.find(std::to_string(loaded.value().id)).value();
  }
  template <typename T>
  [[nodiscard]] TestSubscription<T> subscribe(const std::string& topic, const QoS& qos) {
    return {container_.transport(), topic, qos};
  }
  template <typename T>
  [[nodiscard]] TestPublisher<T> advertise(const std::string& topic, const QoS& qos) {
    return {container_.transport(), topic, qos};
  }
  [[nodiscard]] Container& container() { return container_; }
  /// The test's own file. A process that leaves its mounts asks before: afterwards the kernel tells another name.
  static const std::filesystem::path& program() {
    static const std::filesystem::path file = std::filesystem::read_symlink("/proc/self/exe");
    return file;
  }

 private:
  static ContainerOptions options() {
    ContainerOptions options;
    options.component_path = {program().parent_path().parent_path() / "lib" / "nacelle"};
    return options;
  }
  SystemClock clock_;
  Container container_{options(), clock_};
};

}  // namespace nacelle::runtime
