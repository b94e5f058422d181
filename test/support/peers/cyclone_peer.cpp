// SPDX-License-Identifier: Apache-2.0
// A peer on plain Cyclone DDS: types of idlc, dds_write() and dds_take().
#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "cyclone_types.hpp"
#include "peer.hpp"
#include "ros_types.h"

namespace nacelle::test::peers {
namespace {

[[noreturn]] void die(const char* what, dds_return_t error) {
  std::fprintf(stderr, "%s: %s\n", what, dds_strretcode(error));
  std::exit(1);
}
dds_entity_t must(dds_entity_t made, const char* what) {
  if (made < 0) die(what, made);
  return made;
}

// --- idlc's structs --------------------------------------------------------------------------------------------------

template <typename T>
struct Idl;

template <>
struct Idl<Text> {
  using Struct = std_msgs_msg_dds__String_;
  static const dds_topic_descriptor_t& descriptor() { return std_msgs_msg_dds__String__desc; }
  static Struct from(const Text& text) { return {const_cast<char*>(text.data.c_str())}; }
  static Text to(const Struct& text) { return {text.data}; }
};
template <>
struct Idl<Image> {
  using Struct = sensor_msgs_msg_dds__Image_;
  static const dds_topic_descriptor_t& descriptor() { return sensor_msgs_msg_dds__Image__desc; }
  static Struct from(const Image& in) {
    Struct out{};
    out.header.stamp = {in.sec, in.nanosec};
    out.header.frame_id = const_cast<char*>(in.frame_id.c_str());
    out.height = in.height;
    out.width = in.width;
    out.encoding = const_cast<char*>(in.encoding.c_str());
    out.is_bigendian = in.is_bigendian;
    out.step = in.step;
    out.data._length = out.data._maximum = static_cast<std::uint32_t>(in.data.size());
    out.data._buffer = const_cast<std::uint8_t*>(in.data.data());
    return out;
  }
  static Image to(const Struct& in) {
    return {in.header.stamp.sec,
            in.header.stamp.nanosec,
            in.header.frame_id,
            in.height,
            in.width,
            in.encoding,
            in.is_bigendian,
            in.step,
            {in.data._buffer, in.data._buffer + in.data._length}};
  }
};
template <>
struct Idl<Twist> {
  using Struct = geometry_msgs_msg_dds__Twist_;
  static const dds_topic_descriptor_t& descriptor() { return geometry_msgs_msg_dds__Twist__desc; }
  static Struct from(const Twist& in) {
    Struct out{};
    std::copy(in.linear_angular.begin(), in.linear_angular.end(), out.linear_angular);
    return out;
  }
  static Twist to(const Struct& in) {
    Twist out;
    std::copy_n(in.linear_angular, out.linear_angular.size(), out.linear_angular.begin());
    return out;
  }
};
template <>
struct Idl<Odometry> {
  using Struct = nav_msgs_msg_dds__Odometry_;
  static const dds_topic_descriptor_t& descriptor() { return nav_msgs_msg_dds__Odometry__desc; }
  static Struct from(const Odometry& in) {
    Struct out{};
    out.header.stamp = {in.sec, in.nanosec};
    out.header.frame_id = const_cast<char*>(in.frame_id.c_str());
    out.child_frame_id = const_cast<char*>(in.child_frame_id.c_str());
    std::copy(in.pose.begin(), in.pose.end(), out.pose);
    std::copy(in.twist.begin(), in.twist.end(), out.twist);
    return out;
  }
  static Odometry to(const Struct& in) {
    Odometry out{in.header.stamp.sec, in.header.stamp.nanosec, in.header.frame_id, in.child_frame_id, {}, {}};
    std::copy_n(in.pose, out.pose.size(), out.pose.begin());
    std::copy_n(in.twist, out.twist.size(), out.twist.begin());
    return out;
  }
};
template <>
struct Idl<AddRequest> {
  using Struct = example_interfaces_srv_dds__AddTwoInts_Request_;
  static const dds_topic_descriptor_t& descriptor() { return example_interfaces_srv_dds__AddTwoInts_Request__desc; }
  static Struct from(const AddRequest& in) { return {in.client, in.number, in.a, in.b}; }
  static AddRequest to(const Struct& in) { return {in.client, in.number, in.a, in.b}; }
};
template <>
struct Idl<AddResponse> {
  using Struct = example_interfaces_srv_dds__AddTwoInts_Response_;
  static const dds_topic_descriptor_t& descriptor() { return example_interfaces_srv_dds__AddTwoInts_Response__desc; }
  static Struct from(const AddResponse& in) { return {in.client, in.number, in.sum}; }
  static AddResponse to(const Struct& in) { return {in.client, in.number, in.sum}; }
};

dds_qos_t* make_qos(const Qos& qos) {
  dds_qos_t* const out = dds_create_qos();
  const auto history = qos.keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST;
  dds_qset_reliability(out, qos.best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_durability(out, qos.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(out, history, qos.depth);
  dds_qset_durability_service(out, 0, history, qos.depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED);
  return out;
}

class Cyclone {
 public:
  // CYCLONEDDS_URI configures the network.
  Cyclone(const Options& options, Bell& bell)
      : bell_(bell),
        ahead_(DDS_MSECS(options.ahead_ms)),
        participant_(must(dds_create_participant(options.domain, nullptr, nullptr), "participant")) {}
  Cyclone(const Cyclone&) = delete;
  Cyclone& operator=(const Cyclone&) = delete;
  ~Cyclone() { dds_delete(DDS_CYCLONEDDS_HANDLE); }

  template <typename T>
  class Writer {
   public:
    Writer(Cyclone& dds, const std::string& topic, const Qos& qos)
        : writer_(dds.make(topic, Idl<T>::descriptor(), qos, true)), ahead_(dds.ahead_) {}
    [[nodiscard]] int matched() const { return matched_of(writer_); }
    void write(const T& message) {
      const auto idl = Idl<T>::from(message);
      if (const dds_return_t did = dds_write_ts(writer_, &idl, dds_time() + ahead_); did != 0) die("write", did);
    }
    [[nodiscard]] std::uint64_t handle() const {
      dds_instance_handle_t handle = 0;
      dds_get_instance_handle(writer_, &handle);
      return handle;
    }

   private:
    const dds_entity_t writer_;
    const dds_duration_t ahead_;
  };

  template <typename T>
  class Reader {
   public:
    Reader(Cyclone& dds, const std::string& topic, const Qos& qos)
        : reader_(dds.make(topic, Idl<T>::descriptor(), qos, false)) {}
    [[nodiscard]] int matched() const {
      dds_subscription_matched_status_t status{};
      dds_get_subscription_matched_status(reader_, &status);
      return static_cast<int>(status.current_count);
    }
    [[nodiscard]] std::optional<T> take() {
      for (;;) {
        void* sample = nullptr;
        dds_sample_info_t info{};
        if (dds_take(reader_, &sample, &info, 1, 1) <= 0) return std::nullopt;
        std::optional<T> out;
        if (info.valid_data) out = Idl<T>::to(*static_cast<typename Idl<T>::Struct*>(sample));
        dds_return_loan(reader_, &sample, 1);
        if (out) return out;
      }
    }

   private:
    const dds_entity_t reader_;
  };

  /// Says that it writes a type, and writes something else.
  class GarbageWriter {
   public:
    GarbageWriter(Cyclone& dds, const std::string& topic, const char* type, const Qos& qos)
        : writer_(dds.make(topic, without_xtypes(peer_Garbage_desc, type), qos, true)) {}
    [[nodiscard]] int matched() const { return matched_of(writer_); }
    void write(std::mt19937& random) {
      peer_Garbage garbage{};
      for (auto& byte : garbage.bytes) byte = static_cast<std::uint8_t>(random());
      garbage.bytes[3] |= 0x80;  // no text is that long
      if (const dds_return_t did = dds_write(writer_, &garbage); did != 0) die("write", did);
    }

   private:
    const dds_entity_t writer_;
  };

 private:
  static int matched_of(dds_entity_t writer) {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer, &status);
    return static_cast<int>(status.current_count);
  }
  dds_entity_t make(const std::string& name, const dds_topic_descriptor_t& type, const Qos& qos, bool is_writer) {
    dds_listener_t* const listener = dds_create_listener(&bell_);
    dds_lset_data_available(listener, [](dds_entity_t, void* bell) { static_cast<Bell*>(bell)->ring(); });
    dds_lset_publication_matched_arg(
        listener,
        [](dds_entity_t, const dds_publication_matched_status_t, void* bell) { static_cast<Bell*>(bell)->ring(); },
        &bell_, false);
    dds_lset_subscription_matched_arg(
        listener,
        [](dds_entity_t, const dds_subscription_matched_status_t, void* bell) { static_cast<Bell*>(bell)->ring(); },
        &bell_, false);
    dds_qos_t* const policies = make_qos(qos);
    const dds_entity_t topic = must(dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr), "topic");
    const dds_entity_t made = must(is_writer ? dds_create_writer(participant_, topic, policies, listener)
                                             : dds_create_reader(participant_, topic, policies, listener),
                                   "endpoint");
    dds_delete_qos(policies);
    dds_delete_listener(listener);
    return made;
  }

  Bell& bell_;
  const dds_duration_t ahead_;
  const dds_entity_t participant_;
};

}  // namespace
}  // namespace nacelle::test::peers

int main(int argc, char** argv) {
  using namespace nacelle::test::peers;
  return Peer<Cyclone>(read_options(argc, argv)).run();
}
