// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "nacelle/node/host.hpp"

namespace nacelle {

/// Answers requests of one service; see Node::create_service().
template <typename S>
class Service {
 public:
  using SharedPtr = std::shared_ptr<Service>;
  virtual ~Service() = default;
  [[nodiscard]] const std::string& get_service_name() const { return name_; }

 protected:
  explicit Service(std::string name) : name_(std::move(name)) {}
  std::string name_;
  std::unique_ptr<ServiceHandle> handle_;
};

namespace detail {

template <typename S, typename F>
class CallbackService final : public Service<S> {
 public:
  CallbackService(std::string name, F callback) : Service<S>(std::move(name)), callback_(std::move(callback)) {}
  ~CallbackService() override { this->handle_.reset(); }
  void attach(std::unique_ptr<ServiceHandle> handle) { this->handle_ = std::move(handle); }
  static void run(void* context, const void* request, void* response) {
    static_cast<CallbackService*>(context)->callback_(*static_cast<const typename S::Request*>(request),
                                                      *static_cast<typename S::Response*>(response));
  }

 private:
  F callback_;
};

}  // namespace detail

/// Calls one service; never blocks.
///
/// The response arrives in a callback on the component's own executor; `nullptr` means that the server went away first.
/// Threads: the component's executor.
template <typename S>
class Client {
 public:
  using SharedPtr = std::shared_ptr<Client>;
  using Response = typename S::Response;
  using OnResponse = std::function<void(const Response*)>;

  explicit Client(std::string name) : name_(std::move(name)) {}
  ~Client() { handle_.reset(); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  [[nodiscard]] const std::string& get_service_name() const { return name_; }
  [[nodiscard]] bool service_is_ready() const { return handle_->service_is_ready(); }
  /// Sends the request. Errors: false if no server is there; the callback will not be called then.
  bool async_send_request(typename S::Request request, OnResponse on_response) {
    const std::int64_t sequence = handle_->send(&request);
    if (sequence == 0) return false;
    waiting_[sequence] = std::move(on_response);
    return true;
  }

  void attach(std::unique_ptr<ClientHandle> handle) { handle_ = std::move(handle); }
  static void run(void* context, std::int64_t sequence, const void* response) {
    auto& self = *static_cast<Client*>(context);
    const auto call = self.waiting_.extract(sequence);
    if (!call.empty()) call.mapped()(static_cast<const Response*>(response));
  }

 private:
  std::string name_;
  std::map<std::int64_t, OnResponse> waiting_;
  std::unique_ptr<ClientHandle> handle_;
};

}  // namespace nacelle
