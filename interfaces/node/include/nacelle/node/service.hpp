// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include "nacelle/base/mutex.hpp"
#include "nacelle/host/node_host.hpp"

namespace nacelle {

/// Which request of a service a response is for, as rmw_request_id_t. Valid for the service that it came from.
struct RequestId {
  std::int64_t sequence_number = 0;
};

/// Answers requests of one service; see Node::create_service().
template <typename S>
class Service {
 public:
  using SharedPtr = std::shared_ptr<Service>;
  virtual ~Service() = default;
  [[nodiscard]] const std::string& get_service_name() const { return name_; }
  /// Answers a request whose callback took a RequestId in place of a response. Returns false if the caller no longer waits.
  /// When the service is destroyed, callers of unanswered requests are notified that no response will come. Threads: any.
  bool send_response(const RequestId& request, typename S::Response response) {
    return handle_->send_response(request.sequence_number, &response);
  }

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
  static bool run(void* context, std::int64_t call, const void* request, void* response) {
    using Request = typename S::Request;
    using Response = typename S::Response;
    auto& callback = static_cast<CallbackService*>(context)->callback_;
    const auto& asked = *static_cast<const Request*>(request);
    if constexpr (std::is_invocable_v<F&, const Request&, Response&>) {
      callback(asked, *static_cast<Response*>(response));
      return true;
    } else if constexpr (std::is_invocable_v<F&, std::shared_ptr<Request>, std::shared_ptr<Response>>) {
      const auto answer = std::make_shared<Response>();
      callback(std::make_shared<Request>(asked), answer);
      *static_cast<Response*>(response) = std::move(*answer);
      return true;
    } else {
      static_assert(std::is_invocable_v<F&, const RequestId&, const Request&>,
                    "a service's callback takes (const S::Request&, S::Response&), both as std::shared_ptr, or (const "
                    "RequestId&, "
                    "const S::Request&) if it answers later with send_response()");
      callback(RequestId{call}, asked);
      return false;
    }
  }

 private:
  F callback_;
};

}  // namespace detail

namespace exceptions {
/// A callback waits for what only its own executor, or its own callback group, could do: a deadlock, refused.
struct WaitsForItself : std::logic_error {
  using logic_error::logic_error;
};
}  // namespace exceptions

/// Calls one service; sending never blocks.
///
/// The response arrives on the component's own executor, in the client's callback group: in a callback, where `nullptr` means
/// that the server went away first, or in a Future.
/// Threads: any; a Future belongs to one, and does not outlive its client.
template <typename S>
class Client {
 public:
  using SharedPtr = std::shared_ptr<Client>;
  using Request = typename S::Request;
  using Response = typename S::Response;
  using SharedResponse = std::shared_ptr<const Response>;
  using OnResponse = std::function<void(const Response*)>;

  /// A response to wait for. As rclcpp's, but waiting where it would never end is an error and not a deadlock.
  class Future {
   public:
    Future() = default;  ///< Of no call.
    [[nodiscard]] bool valid() const { return future_.valid(); }
    /// Errors: exceptions::WaitsForItself in a callback that keeps the response from being taken.
    std::future_status wait_for(Duration limit) {
      if (future_.wait_for(Duration::zero()) != std::future_status::ready) {
        if (const std::string why = client_->handle_->why_not_wait(); !why.empty())
          throw exceptions::WaitsForItself("service " + client_->name_ + ": " + why);
      }
      return future_.wait_for(limit);
    }
    /// The response, once, when wait_for() says that it is there; null if the server went away.
    [[nodiscard]] SharedResponse get() { return future_.get(); }

   private:
    friend class Client;
    Future(Client& client, std::future<SharedResponse> future) : client_(&client), future_(std::move(future)) {}
    Client* client_ = nullptr;
    std::future<SharedResponse> future_;
  };

  explicit Client(std::string name) : name_(std::move(name)) {}
  ~Client() { handle_.reset(); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  [[nodiscard]] const std::string& get_service_name() const { return name_; }
  [[nodiscard]] bool service_is_ready() const { return handle_->service_is_ready(); }
  /// Why the callback that runs on this thread must not wait for a response. Empty: it may.
  [[nodiscard]] std::string why_not_wait() const { return handle_->why_not_wait(); }
  /// Sends the request. Errors: false if no server is there; the callback will not be called then.
  bool async_send_request(typename S::Request request, OnResponse on_response) {
    // The response may come on another thread before we have noted whom it is for.
    const LockGuard lock(mutex_);
    const std::int64_t sequence = handle_->send(&request);
    if (sequence == 0) return false;
    waiting_[sequence] = std::move(on_response);
    return true;
  }
  /// The same with a future. Errors: one that is not valid() if no server is there.
  [[nodiscard]] Future async_send_request(typename S::Request request) {
    auto promise = std::make_shared<std::promise<SharedResponse>>();
    Future future{*this, promise->get_future()};
    const bool sent = async_send_request(std::move(request), [promise](const Response* response) {
      promise->set_value(response != nullptr ? std::make_shared<const Response>(*response) : nullptr);
    });
    return sent ? std::move(future) : Future{};
  }

  /// As rclcpp writes it. The request is copied.
  template <typename R>
  requires std::is_same_v<R, Request>
  [[nodiscard]] Future async_send_request(const std::shared_ptr<R>& request) { return async_send_request(*request); }
  /// Blocks until a server is available or the timeout expires. Returns whether one is available. Do not call it in a callback if
  /// the same executor runs the server.
  bool wait_for_service(Duration limit) const {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!service_is_ready()) {
      if (std::chrono::steady_clock::now() >= end) return false;
      std::this_thread::sleep_for(kLookForServer);
    }
    return true;
  }

  void attach(std::unique_ptr<ClientHandle> handle) { handle_ = std::move(handle); }
  static void run(void* context, std::int64_t sequence, const void* response) {
    auto& self = *static_cast<Client*>(context);
    typename std::map<std::int64_t, OnResponse>::node_type call;
    {
      const LockGuard lock(self.mutex_);
      call = self.waiting_.extract(sequence);
    }
    if (!call.empty()) call.mapped()(static_cast<const Response*>(response));
  }

 private:
  static constexpr Duration kLookForServer = std::chrono::milliseconds{10};

  std::string name_;
  Mutex mutex_;
  std::map<std::int64_t, OnResponse> waiting_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<ClientHandle> handle_;
};

}  // namespace nacelle
