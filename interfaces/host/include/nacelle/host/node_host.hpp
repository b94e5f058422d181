// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/histogram.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/callback_group.hpp"
#include "nacelle/host/message.hpp"
#include "nacelle/host/transport.hpp"

namespace nacelle {

class GraphListener;
class ParameterStore;
class ServiceListener;

/// Runs a subscription's callback for one message. For Taking::Own it takes over the block's reference; for Taking::Share it
/// looks (or adds a reference of its own). Lives in the component; called on its executor only.
struct MessageCallback {
  void (*run)(void* context, Block& block, Reader& reader) = nullptr;
  void* context = nullptr;
};

/// A callback without an argument, as two words: a std::function would need the component's code to be destroyed.
struct PlainCallback {
  void (*run)(void* context) = nullptr;
  void* context = nullptr;
};

/// What a timer counts.
enum class TimerClock : std::uint8_t {
  Monotonic,  ///< Real time, which never steps.
  OfNode      ///< What the node's now() says: /clock for one with use_sim_time, else as Monotonic.
};

/// Answers a request, in place or later. Lives in the component; called on its executor only.
struct ServiceCallback {
  /// Returns whether `response` is the answer; if not, ServiceHandle::send_response(call, ...) gives it, now or later.
  bool (*run)(void* context, std::int64_t call, const void* request, void* response) = nullptr;
  void* context = nullptr;
};

/// Takes a response; null means that there will be none (the server went away). Called on the client's executor only.
struct ResponseCallback {
  void (*run)(void* context, std::int64_t sequence, const void* response) = nullptr;
  void* context = nullptr;
};

/// Handles of the host's objects. Destroying one ends the thing; its callback does not run afterwards.
class SubscriptionHandle {
 public:
  virtual ~SubscriptionHandle() = default;
  [[nodiscard]] virtual Reader& reader() = 0;
};
/// The host calls a GraphListener until this is destroyed.
class GraphWatchHandle {
 public:
  virtual ~GraphWatchHandle() = default;
};
/// The host calls a ServiceListener until this is destroyed.
class ServiceWatchHandle {
 public:
  virtual ~ServiceWatchHandle() = default;
};
/// Runs a callback after an endpoint's status has changed; several changes may share one run.
class StatusEventHandle {
 public:
  virtual ~StatusEventHandle() = default;
  [[nodiscard]] virtual StatusListener& listener() = 0;
};
class TimerHandle {
 public:
  virtual ~TimerHandle() = default;
  virtual void cancel() = 0;
  virtual void reset() = 0;
  [[nodiscard]] virtual bool is_canceled() const = 0;
};
class ServiceHandle {
 public:
  virtual ~ServiceHandle() = default;
  /// Answers a call that its callback left open. Moves the fields out of `response`. Returns false if the caller no longer
  /// waits. When the handle is destroyed, callers of open calls are notified that no response will come. Threads: any.
  virtual bool send_response(std::int64_t call, void* response) = 0;
};
class ClientHandle {
 public:
  virtual ~ClientHandle() = default;
  /// Moves the request's fields out of `request`. Returns the call's number, or 0 if no server is there.
  [[nodiscard]] virtual std::int64_t send(void* request) = 0;
  [[nodiscard]] virtual bool service_is_ready() const = 0;
  /// Why the callback that runs on this thread must not wait for a response: it would wait for itself. Empty: it may.
  [[nodiscard]] virtual std::string why_not_wait() const { return {}; }
};

/// How firmly a node means to broadcast a transform.
enum class FrameClaimKind : std::uint8_t {
  Primary,   ///< Owns the frame; two of these for one child are an error of the composition.
  Fallback,  ///< Owns it only while no other claim exists (wheel odometry beside an EKF).
  Fixed,     ///< As Primary, and the transform never changes: a fixed joint. A fallback beside it is an error, too.
};

/// A node's claim on the transform parent -> child. Every frame has one parent and one owner.
class FrameClaim {
 public:
  virtual ~FrameClaim() = default;
  /// Threads: any; one relaxed load.
  [[nodiscard]] virtual bool is_owner() const = 0;
  /// Returns the node that owns the frame; empty if this claim does.
  [[nodiscard]] virtual std::string owner() const = 0;
  /// Gives the claim up (a parameter switched the broadcast off).
  virtual void withdraw() = 0;
};

/// A container as one node sees it: everything that leaves the node goes through here.
///
/// The runtime implements it, and a recording host in test/support, so that a component runs in a unit test without an
/// executor and without a thread. Topic and service names are fully qualified and remapped already. A null group is the node's
/// own; another node's is refused with std::runtime_error, as rclcpp does.
/// Threads: from the component's executor and its constructor, unless said otherwise. Handles must not outlive the node.
class NodeHost {
 public:
  virtual ~NodeHost() = default;

  [[nodiscard]] virtual const Clock& clock() const = 0;
  [[nodiscard]] virtual std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) = 0;
  [[nodiscard]] virtual std::unique_ptr<SubscriptionHandle> create_subscription(
      const EndpointSpec& spec, Taking taking, MessageCallback callback, const CallbackGroup::SharedPtr& group) = 0;
  /// Creates a reader for a thread of the component's own. It calls the listener as Transport::create_reader() says; the listener outlives
  /// it. The node's gate does not close it. Threads: any.
  [[nodiscard]] virtual std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, ReadyListener& listener) = 0;
  /// Tells the listener of all endpoints of the container, and of each change. Those of other processes are among them as far as
  /// somebody here reads or writes their topic. The listener outlives the handle. Threads: any.
  [[nodiscard]] virtual std::unique_ptr<GraphWatchHandle> watch_graph(GraphListener& listener) = 0;
  /// Tells the listener of all servers and clients of the container, and of each change. The listener outlives the handle. Threads: any.
  [[nodiscard]] virtual std::unique_ptr<ServiceWatchHandle> watch_services(ServiceListener& listener) = 0;
  /// To be made before the endpoint that tells its listener, and to outlive it. Runs also behind a closed lifecycle gate.
  [[nodiscard]] virtual std::unique_ptr<StatusEventHandle> create_status_event(
      PlainCallback callback, const CallbackGroup::SharedPtr& group) = 0;
  [[nodiscard]] virtual std::unique_ptr<TimerHandle> create_timer(TimerClock clock, Duration period,
                                                                  PlainCallback callback,
                                                                  const CallbackGroup::SharedPtr& group) = 0;
  [[nodiscard]] virtual std::unique_ptr<ServiceHandle> create_service(const std::string& name,
                                                                      const msgs::MessageType& request,
                                                                      const msgs::MessageType& response,
                                                                      ServiceCallback callback,
                                                                      const CallbackGroup::SharedPtr& group) = 0;
  [[nodiscard]] virtual std::unique_ptr<ClientHandle> create_client(const std::string& name,
                                                                    const msgs::MessageType& request,
                                                                    const msgs::MessageType& response,
                                                                    ResponseCallback callback,
                                                                    const CallbackGroup::SharedPtr& group) = 0;
  [[nodiscard]] virtual CallbackGroup::SharedPtr create_callback_group(CallbackGroupType type) = 0;
  /// `origin` says for people what makes the node broadcast it: "parameter publish_tf".
  [[nodiscard]] virtual std::unique_ptr<FrameClaim> claim_frame(const std::string& parent, const std::string& child,
                                                                FrameClaimKind kind, const Place& origin) = 0;

  /// Returns the container's object of that name; the first call creates it. `make` must live in a library that is never unloaded.
  [[nodiscard]] virtual std::shared_ptr<void> shared_object(const std::string& name,
                                                            std::shared_ptr<void> (*make)()) = 0;

  /// A duration that reports show under the node's name. Lives as long as the node. Threads of record(): one writer.
  [[nodiscard]] virtual DurationHistogram& create_histogram(const std::string& name) = 0;

  /// Bytes that stop the hardware, and where to write them, so that it can be done without running component code (design D7).
  /// Up to four descriptors, a frame each; they stay open until clear_safe_stop(). A CAN socket takes one frame a write, of 16 bytes each.
  virtual void register_safe_stop(int descriptor, ByteView frame) = 0;
  virtual void clear_safe_stop() = 0;

  /// The component cannot go on: the host runs error processing on its executor. Threads: any.
  virtual void report_fault(std::string code, std::string text) = 0;
  /// Something is wrong that the component mends itself: shown until close_fault() of the same code, no transition, no policy.
  /// Again with the same code: another text. Threads: any.
  virtual void open_fault(std::string code, std::string text) = 0;
  /// Does nothing for a code that is not open. Threads: any.
  virtual void close_fault(const std::string& code) = 0;
  /// Opens or closes the lifecycle gate of all endpoints of the node.
  virtual void set_active(bool active) = 0;
  /// Gives the host the node's parameters, for their services. Called once, by the node's constructor; they outlive this host.
  virtual void set_parameters(ParameterStore& parameters) = 0;
};

/// The name and namespace of a node.
struct NodeIdentity {
  std::string name;
  std::string name_space;  ///< "/" or "/robot1"
  [[nodiscard]] std::string fully_qualified() const { return name_space == "/" ? "/" + name : name_space + "/" + name; }
};

/// Makes the hosts of one component's nodes. Nodes find it in their NodeOptions.
class Context {
 public:
  virtual ~Context() = default;
  /// The first node is the component. Others belong to it (NodeOptions::another_node()). Threads: any of the component's.
  /// Errors: exceptions::InvalidNameError for a name that is taken.
  [[nodiscard]] virtual std::unique_ptr<NodeHost> create_host(const NodeIdentity& identity) = 0;
};

}  // namespace nacelle
