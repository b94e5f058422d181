// SPDX-License-Identifier: Apache-2.0
// What `ros2 bag record -a` does, on plain Cyclone DDS: subscribes to each topic of ROS 2 that it finds. A name with two types it
// leaves out, as that does.
// Usage: cyclone_recorder
//   a line on standard input: subscribes to what has come since, and answers with one line of JSON: the names that have two types, the
//   type of each name that it has subscribed to, and the names of which it has heard a message.
#include <dds/dds.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

#include "cyclone_types.hpp"
#include "ros_types.h"

namespace {

dds_entity_t must(dds_entity_t made, const char* what) {
  if (made >= 0) return made;
  std::fprintf(stderr, "%s: %s\n", what, dds_strretcode(made));
  std::exit(1);
}

class Recorder {
 public:
  Recorder()
      : participant_(must(dds_create_participant(DDS_DOMAIN_DEFAULT, nullptr, nullptr), "participant")),
        ends_{must(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr), "writers"),
              must(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr), "readers")} {}
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder() { dds_delete(DDS_CYCLONEDDS_HANDLE); }

  void subscribe() {
    clashes_.clear();
    for (const auto& [name, types] : types_of_topics()) {
      if (types.size() != 1) {
        clashes_.insert(name);
      } else if (!readers_.contains(name)) {
        records_[name] = *types.begin();
        readers_[name] = make_reader(name, records_[name]);
      }
    }
  }
  void listen() {
    for (const auto& [name, reader] : readers_) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      while (dds_take(reader, &sample, &info, 1, 1) > 0) {
        if (info.valid_data) heard_.insert(name);
        dds_return_loan(reader, &sample, 1);
        sample = nullptr;
      }
    }
  }
  void tell() const {
    std::string records;
    for (const auto& [name, type] : records_) {
      records += (records.empty() ? "\"" : ", \"") + name;
      records += "\": \"" + type + "\"";
    }
    std::printf("{\"clashes\": [%s], \"records\": {%s}, \"heard\": [%s]}\n", list(clashes_).c_str(), records.c_str(),
                list(heard_).c_str());
    std::fflush(stdout);
  }

 private:
  // Both ends count: so ROS 2's tools do.
  [[nodiscard]] std::map<std::string, std::set<std::string>> types_of_topics() const {
    constexpr std::size_t kMost = 1024;
    std::map<std::string, std::set<std::string>> found;
    for (const dds_entity_t end : ends_) {
      std::array<void*, kMost> samples{};
      std::array<dds_sample_info_t, kMost> infos{};
      const dds_return_t count = dds_read(end, samples.data(), infos.data(), kMost, kMost);
      for (std::size_t i = 0; count > 0 && i < static_cast<std::size_t>(count); ++i) {
        const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
        if (!infos[i].valid_data || infos[i].instance_state != DDS_IST_ALIVE) continue;
        const std::string name = endpoint.topic_name;
        if (name.starts_with("rt/")) found[name].insert(endpoint.type_name);
      }
      if (count > 0) dds_return_loan(end, samples.data(), count);
    }
    return found;
  }
  [[nodiscard]] dds_entity_t make_reader(const std::string& name, const std::string& type) const {
    dds_qos_t* const qos = dds_create_qos();  // best effort and volatile: what any writer offers
    dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
    const dds_topic_descriptor_t descriptor = without_xtypes(peer_Anything_desc, type.c_str());
    const dds_entity_t topic =
        must(dds_create_topic(participant_, &descriptor, name.c_str(), nullptr, nullptr), name.c_str());
    const dds_entity_t reader = must(dds_create_reader(participant_, topic, qos, nullptr), name.c_str());
    dds_delete_qos(qos);
    return reader;
  }
  static std::string list(const std::set<std::string>& names) {
    std::string text;
    for (const auto& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
    return text;
  }

  const dds_entity_t participant_;
  const std::array<dds_entity_t, 2> ends_;
  std::map<std::string, dds_entity_t> readers_;
  std::map<std::string, std::string> records_;
  std::set<std::string> clashes_, heard_;
};

}  // namespace

int main() {
  Recorder recorder;
  std::puts("ready");
  std::fflush(stdout);
  for (;;) {
    pollfd asked{STDIN_FILENO, POLLIN, 0};
    const bool is_asked = ::poll(&asked, 1, 20) > 0;
    recorder.listen();
    if (!is_asked) continue;
    std::array<char, 64> ignored{};
    if (::read(STDIN_FILENO, ignored.data(), ignored.size()) <= 0) return 0;
    recorder.subscribe();
    recorder.tell();
  }
}
