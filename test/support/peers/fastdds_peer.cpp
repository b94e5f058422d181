// SPDX-License-Identifier: Apache-2.0
// A peer on Fast DDS, a second implementation of DDS: version 2 (Debian 12) or 3 (Debian 13). Its types are written by hand, since
// Debian 12 has no fastddsgen.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#if __has_include(<fastdds/utils/IPLocator.hpp>)
#define NACELLE_FASTDDS 3
#include <fastdds/rtps/flowcontrol/FlowControllerDescriptor.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>
#else
#define NACELLE_FASTDDS 2
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/rtps/flowcontrol/FlowControllerDescriptor.hpp>
#endif
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <array>
#include <atomic>
#include <type_traits>

#include "peer.hpp"

namespace nacelle::test::peers {
namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
#if NACELLE_FASTDDS >= 3
namespace rtps = eprosima::fastdds::rtps;
constexpr auto kOk = dds::RETCODE_OK;
constexpr auto kEncoding = eprosima::fastcdr::CdrVersion::DDS_CDR;
#else
namespace rtps = eprosima::fastrtps::rtps;
const auto kOk = eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
constexpr auto kEncoding = Cdr::DDS_CDR;
#endif

// --- the bytes -------------------------------------------------------------------------------------------------------

// What cannot be longer than this is not sent here.
constexpr std::size_t kOverhead = 1024;

std::size_t most_bytes(const Text& text) { return text.data.size() + kOverhead; }
std::size_t most_bytes(const Image& image) {
  return image.data.size() + image.encoding.size() + image.frame_id.size() + kOverhead;
}
std::size_t most_bytes(const Twist& /*twist*/) { return kOverhead; }
std::size_t most_bytes(const Odometry& in) { return in.frame_id.size() + in.child_frame_id.size() + kOverhead; }
std::size_t most_bytes(const AddRequest& /*request*/) { return kOverhead; }
std::size_t most_bytes(const AddResponse& /*response*/) { return kOverhead; }

void put(Cdr& cdr, const Text& text) { cdr << text.data; }
void get(Cdr& cdr, Text& text) { cdr >> text.data; }
void put(Cdr& cdr, const Image& in) {
  cdr << in.sec << in.nanosec << in.frame_id << in.height << in.width << in.encoding << in.is_bigendian << in.step
      << in.data;
}
void get(Cdr& cdr, Image& out) {
  cdr >> out.sec >> out.nanosec >> out.frame_id >> out.height >> out.width >> out.encoding >> out.is_bigendian >>
      out.step >> out.data;
}
void put(Cdr& cdr, const Twist& in) { cdr << in.linear_angular; }
void get(Cdr& cdr, Twist& out) { cdr >> out.linear_angular; }
void put(Cdr& cdr, const Odometry& in) {
  cdr << in.sec << in.nanosec << in.frame_id << in.child_frame_id << in.pose << in.twist;
}
void get(Cdr& cdr, Odometry& out) {
  cdr >> out.sec >> out.nanosec >> out.frame_id >> out.child_frame_id >> out.pose >> out.twist;
}
void put(Cdr& cdr, const AddRequest& in) { cdr << in.client << in.number << in.a << in.b; }
void get(Cdr& cdr, AddRequest& out) { cdr >> out.client >> out.number >> out.a >> out.b; }
void put(Cdr& cdr, const AddResponse& in) { cdr << in.client << in.number << in.sum; }
void get(Cdr& cdr, AddResponse& out) { cdr >> out.client >> out.number >> out.sum; }

/// What Fast DDS asks of a type, in the words of both versions.
template <typename T>
class Type final : public dds::TopicDataType {
  static constexpr std::uint32_t kMostBytes = 9000000;

 public:
#if NACELLE_FASTDDS >= 3
  Type() {
    set_name(T::kName);
    max_serialized_type_size = kMostBytes;
    is_compute_key_provided = false;
  }
  bool serialize(const void* data, rtps::SerializedPayload_t& payload, dds::DataRepresentationId_t /*id*/) override {
    return encode(*static_cast<const T*>(data), payload);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override {
    return decode(payload, *static_cast<T*>(data));
  }
  std::uint32_t calculate_serialized_size(const void* data, dds::DataRepresentationId_t /*id*/) override {
    return static_cast<std::uint32_t>(most_bytes(*static_cast<const T*>(data)));
  }
  void* create_data() override { return new T; }
  void delete_data(void* data) override { delete static_cast<T*>(data); }
  bool compute_key(rtps::SerializedPayload_t& /*payload*/, rtps::InstanceHandle_t& /*handle*/, bool /*md5*/) override {
    return false;
  }
  bool compute_key(const void* /*data*/, rtps::InstanceHandle_t& /*handle*/, bool /*md5*/) override { return false; }
#else
  Type() {
    setName(T::kName);
    m_typeSize = kMostBytes;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    return encode(*static_cast<T*>(data), *payload);
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    return decode(*payload, *static_cast<T*>(data));
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(most_bytes(*static_cast<T*>(data))); };
  }
  void* createData() override { return new T; }
  void deleteData(void* data) override { delete static_cast<T*>(data); }
  bool getKey(void* /*data*/, rtps::InstanceHandle_t* /*handle*/, bool /*force_md5*/) override { return false; }
#endif

 private:
  static bool encode(const T& message, rtps::SerializedPayload_t& payload) {
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload.data), payload.max_size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, kEncoding);
    cdr.serialize_encapsulation();
    put(cdr, message);
    payload.encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
#if NACELLE_FASTDDS >= 3
    payload.length = static_cast<std::uint32_t>(cdr.get_serialized_data_length());
#else
    payload.length = static_cast<std::uint32_t>(cdr.getSerializedDataLength());
#endif
    return true;
  }
  static bool decode(rtps::SerializedPayload_t& payload, T& message) {
    try {
      eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload.data), payload.length);
      Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, kEncoding);
      cdr.read_encapsulation();
      get(cdr, message);
      return true;
    } catch (const eprosima::fastcdr::exception::Exception&) { return false; }
  }
};

// --- the endpoints ---------------------------------------------------------------------------------------------------

template <typename Policies>
void set(Policies& out, const Qos& qos) {
  out.reliability().kind = qos.best_effort ? dds::BEST_EFFORT_RELIABILITY_QOS : dds::RELIABLE_RELIABILITY_QOS;
  out.durability().kind = qos.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  out.history().kind = qos.keep_all ? dds::KEEP_ALL_HISTORY_QOS : dds::KEEP_LAST_HISTORY_QOS;
  out.history().depth = qos.depth;
  // Sized by the messages that arrive, not by the longest possible one.
  out.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
}

constexpr const char* kPace = "pace";

class FastDds {
 public:
  FastDds(const Options& options, Bell& bell) : bell_(bell) {
    dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
    if (options.at_home) {
      // Source: participant.cpp of rmw_fastrtps (jazzy).
      auto& builtin = qos.wire_protocol().builtin;
      builtin.metatrafficMulticastLocatorList.clear();
      builtin.metatrafficUnicastLocatorList.push_back(rtps::Locator_t{});
      rtps::Locator_t here;
      rtps::IPLocator::setIPv4(here, "127.0.0.1");
      builtin.initialPeersList.push_back(here);
    } else if (!options.as_delivered) {
      // The loopback interface only, and no shared memory: as a peer on another machine.
      auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
      udp->interfaceWhiteList = {"127.0.0.1"};
      qos.transport().use_builtin_transports = false;
      qos.transport().user_transports = {udp};
      qos.transport().listen_socket_buffer_size = 4 << 20;
    }
    // A socket's buffer holds two packets of a long message; a writer that outruns its reader sends most of them again,
    // seconds later. For images only: discovery goes through a flow controller, too, as soon as there is one, and when it announces
    // itself again before the last announcement has left, Fast DDS 3.1 ends the process (FlowControllerImpl.hpp:1130,
    // "!change->writer_info.is_linked").
    if (options.verb == "pub" && options.type == "image") {
      auto pace = std::make_shared<eprosima::fastdds::rtps::FlowControllerDescriptor>();
      pace->name = kPace;
      pace->max_bytes_per_period = 130000;
      pace->period_ms = 4;
      qos.flow_controllers().push_back(pace);
      qos.wire_protocol().builtin.discovery_config.initial_announcements.period = {0, 500 * 1000 * 1000};
    }
    if (const char* const seconds = std::getenv("NACELLE_PEER_LEASE_S")) {  // Cyclone reads its own from CYCLONEDDS_URI
      auto& discovery = qos.wire_protocol().builtin.discovery_config;
      discovery.leaseDuration = {std::atoi(seconds), 0};
      discovery.leaseDuration_announcementperiod = {1, 0};
    }
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(options.domain, qos);
    if (participant_ == nullptr) std::exit(1);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  FastDds(const FastDds&) = delete;
  FastDds& operator=(const FastDds&) = delete;
  ~FastDds() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  template <typename T>
  class Writer final : public dds::DataWriterListener {
   public:
    Writer(FastDds& dds, const std::string& topic, const Qos& qos) : bell_(dds.bell_) {
      dds::DataWriterQos policies = dds::DATAWRITER_QOS_DEFAULT;
      set(policies, qos);
      if constexpr (std::is_same_v<T, Image>) {
        policies.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;  // it needs several packets
        policies.publish_mode().flow_controller_name = kPace;
      }
#if NACELLE_FASTDDS >= 3
      policies.reliable_writer_qos().times.heartbeat_period = {0, 100 * 1000 * 1000};
#else
      policies.reliable_writer_qos().times.heartbeatPeriod = {0, 100 * 1000 * 1000};
#endif
      writer_ = dds.publisher_->create_datawriter(dds.make_topic<T>(topic), policies, this);
      if (writer_ == nullptr) std::exit(1);
    }
    ~Writer() override { writer_->set_listener(nullptr); }
    [[nodiscard]] int matched() const { return matched_; }
    void write(T message) {
#if NACELLE_FASTDDS >= 3
      if (writer_->write(&message) != kOk) std::exit(1);
#else
      if (!writer_->write(&message)) std::exit(1);
#endif
    }
    /// Any unique number.
    [[nodiscard]] std::uint64_t handle() const {
      std::uint64_t out = 0;
      std::memcpy(&out, writer_->guid().guidPrefix.value + 4, sizeof(out));
      return out;
    }

   private:
    void on_publication_matched(dds::DataWriter* /*writer*/, const dds::PublicationMatchedStatus& status) override {
      matched_ = status.current_count;
      bell_.ring();
    }
    Bell& bell_;
    std::atomic<int> matched_{0};
    dds::DataWriter* writer_ = nullptr;
  };

  template <typename T>
  class Reader final : public dds::DataReaderListener {
   public:
    Reader(FastDds& dds, const std::string& topic, const Qos& qos) : bell_(dds.bell_) {
      dds::DataReaderQos policies = dds::DATAREADER_QOS_DEFAULT;
      set(policies, qos);
      reader_ = dds.subscriber_->create_datareader(dds.make_topic<T>(topic), policies, this);
      if (reader_ == nullptr) std::exit(1);
    }
    ~Reader() override { reader_->set_listener(nullptr); }
    [[nodiscard]] int matched() const { return matched_; }
    [[nodiscard]] std::optional<T> take() {
      T message;
      dds::SampleInfo info;
      while (reader_->take_next_sample(&message, &info) == kOk) {
        if (info.valid_data) return message;
      }
      return std::nullopt;
    }

   private:
    void on_data_available(dds::DataReader* /*reader*/) override { bell_.ring(); }
    void on_subscription_matched(dds::DataReader* /*reader*/, const dds::SubscriptionMatchedStatus& status) override {
      matched_ = status.current_count;
      bell_.ring();
    }
    Bell& bell_;
    std::atomic<int> matched_{0};
    dds::DataReader* reader_ = nullptr;
  };

 private:
  template <typename T>
  dds::Topic* make_topic(const std::string& name) {
    const dds::TypeSupport type(new Type<T>);
    type.register_type(participant_);
    dds::Topic* const topic = participant_->create_topic(name, T::kName, dds::TOPIC_QOS_DEFAULT);
    if (topic == nullptr) std::exit(1);
    return topic;
  }

  Bell& bell_;
  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
};

}  // namespace
}  // namespace nacelle::test::peers

int main(int argc, char** argv) {
  using namespace nacelle::test::peers;
  return Peer<FastDds>(read_options(argc, argv)).run();
}
