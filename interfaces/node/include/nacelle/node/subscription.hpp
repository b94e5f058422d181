// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "nacelle/host/node_host.hpp"
#include "nacelle/node/qos_event.hpp"

namespace nacelle {
namespace detail {

template <typename F>
struct CallableArguments {};
template <typename F>
requires requires { &F::operator(); }
struct CallableArguments<F> : CallableArguments<decltype(&F::operator())> {};
template <typename R, typename... A>
struct CallableArguments<R (*)(A...)> {
  using type = std::tuple<A...>;
};
template <typename C, typename R, typename... A>
struct CallableArguments<R (C::*)(A...)> {
  using type = std::tuple<A...>;
};
template <typename C, typename R, typename... A>
struct CallableArguments<R (C::*)(A...) const> {
  using type = std::tuple<A...>;
};
template <typename C, typename R, typename... A>
struct CallableArguments<R (C::*)(A...) noexcept> {
  using type = std::tuple<A...>;
};
template <typename C, typename R, typename... A>
struct CallableArguments<R (C::*)(A...) const noexcept> {
  using type = std::tuple<A...>;
};

template <typename F>
concept HasOneSignature = requires {
  typename CallableArguments<std::decay_t<F>>::type;
};

/// A callback takes the message as this, alone or with a MessageInfo behind it.
template <typename F, typename Argument>
inline constexpr bool kTakes =
    std::is_invocable_v<F&, Argument> || std::is_invocable_v<F&, Argument, const MessageInfo&>;

// A callable without one signature (std::bind, a generic lambda): the first of these that it can be called with. A Loan converts to
// shared_ptr, so sharing is asked for first: it is what such a callable most likely wants.
template <typename T, typename F>
auto first_argument_of_any() {
  if constexpr (kTakes<F, const T&>) {
    return std::type_identity<const T&>{};
  } else if constexpr (kTakes<F, std::shared_ptr<const T>>) {
    return std::type_identity<std::shared_ptr<const T>>{};
  } else if constexpr (kTakes<F, std::shared_ptr<T>>) {
    return std::type_identity<std::shared_ptr<T>>{};
  } else if constexpr (kTakes<F, Loan<T>>) {
    return std::type_identity<Loan<T>>{};
  } else {
    return std::type_identity<std::unique_ptr<T>>{};
  }
}

// Where there is one signature, the exact parameter type decides, not is_invocable: a Loan would silently become a sharer.
template <typename T, typename F>
auto first_argument_type() {
  if constexpr (HasOneSignature<F>) {
    return std::type_identity<std::tuple_element_t<0, typename CallableArguments<std::decay_t<F>>::type>>{};
  } else {
    return first_argument_of_any<T, F>();
  }
}
template <typename T, typename F>
using FirstArgument = typename decltype(first_argument_type<T, F>())::type;

template <typename T, typename Argument, typename Plain = std::remove_cvref_t<Argument>>
inline constexpr Taking kTaking = std::is_same_v<Plain, Loan<T>> || std::is_same_v<Plain, std::unique_ptr<T>> ||
                                          std::is_same_v<Plain, std::shared_ptr<T>>
                                      ? Taking::Own
                                      : Taking::Share;

}  // namespace detail

/// Options of a subscription, with rclcpp's names.
struct SubscriptionOptions {
  CallbackGroup::SharedPtr callback_group;  ///< Null: the node's own.
  SubscriptionEventCallbacks event_callbacks;
  CommandTimeout command_timeout{};  ///< Ours: of a reader that stops its hardware when commands stop.
  /// Ours: for a second subscription with a weaker QoS. It ignores publishers that offer at least this QoS.
  std::optional<QoS> unless_offered{};
  Announced announced = Announced::Always;  ///< Ours: for a node that reads several types on one name.
};

class SubscriptionBase {
 public:
  virtual ~SubscriptionBase() = default;
};

/// Calls back for each message of one topic; see Node::create_subscription().
template <typename T>
class Subscription : public SubscriptionBase {
 public:
  using SharedPtr = std::shared_ptr<Subscription>;

  [[nodiscard]] const std::string& get_topic_name() const { return topic_; }
  [[nodiscard]] const QoS& get_actual_qos() const { return qos_; }
  [[nodiscard]] std::size_t get_publisher_count() const { return handle_->reader().writer_count(); }
  [[nodiscard]] ReaderCounters counters() const { return handle_->reader().counters(); }
  [[nodiscard]] EndpointStatus status() const { return handle_->reader().status(); }

 protected:
  Subscription(std::string topic, QoS qos) : topic_(std::move(topic)), qos_(std::move(qos)) {}
  std::string topic_;
  QoS qos_;
  std::unique_ptr<detail::SubscriptionEvents> events_;  // outlives the reader that calls it
  std::unique_ptr<SubscriptionHandle> handle_;
};

namespace detail {

template <typename T, typename F>
class CallbackSubscription final : public Subscription<T> {
 public:
  CallbackSubscription(std::string topic, QoS qos, F callback)
      : Subscription<T>(std::move(topic), std::move(qos)), callback_(std::move(callback)) {}
  ~CallbackSubscription() override { this->handle_.reset(); }  // before the callable goes

  void attach(std::unique_ptr<SubscriptionHandle> handle, std::unique_ptr<SubscriptionEvents> events) {
    this->events_ = std::move(events);
    this->handle_ = std::move(handle);
    this->events_->watch(this->handle_->reader());
  }

  static void run(void* context, Block& block, Reader& reader) {
    auto& self = *static_cast<CallbackSubscription*>(context);
    using Argument = FirstArgument<T, F>;
    using Plain = std::remove_cvref_t<Argument>;
    if constexpr (std::is_same_v<Plain, T>) {
      self.call(*static_cast<const T*>(block.message), block.info);
    } else if constexpr (std::is_same_v<Plain, std::shared_ptr<const T>>) {
      const MessageInfo info = block.info;
      const T* const message = static_cast<const T*>(block.message);
      self.call(std::shared_ptr<const T>(share_block(block), message), info);
    } else if constexpr (std::is_same_v<Plain, Loan<T>>) {
      const MessageInfo info = block.info;
      self.call(Loan<T>{static_cast<T*>(block.message), ReturnToStore{&block}}, info);
    } else if constexpr (std::is_same_v<Plain, std::shared_ptr<T>>) {
      const MessageInfo info = block.info;
      self.call(std::shared_ptr<T>{Loan<T>{static_cast<T*>(block.message), ReturnToStore{&block}}}, info);
    } else {
      static_assert(std::is_same_v<Plain, std::unique_ptr<T>>,
                    "a callback takes const T&, std::shared_ptr<const T>, std::shared_ptr<T>, nacelle::Loan<T> or "
                    "std::unique_ptr<T>");
      const MessageInfo info = block.info;
      Loan<T> home{static_cast<T*>(block.message), ReturnToStore{&block}};
      auto own = std::make_unique<T>(std::move(*home));
      home.reset();
      reader.note_rehomed();
      self.call(std::move(own), info);
    }
  }

 private:
  template <typename M>
  void call(M&& message, const MessageInfo& info) {
    if constexpr (std::is_invocable_v<F&, M>) {
      callback_(std::forward<M>(message));
    } else {
      callback_(std::forward<M>(message), info);
    }
  }
  F callback_;
};

}  // namespace detail
}  // namespace nacelle
