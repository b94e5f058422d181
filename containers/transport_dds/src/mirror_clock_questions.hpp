// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mirror_services.hpp"

namespace nacelle {

/// Queries nodes of participants whose clocks may be behind (wire/peer_clock.hpp), for the stamps of the answers.
///
/// The query is get_parameter_types without names, which every ROS 2 node serves and which changes nothing. Each open
/// query has its own client, which belongs to no node. The numbers of open and waiting queries are limited, because a
/// peer can announce any number of participants.
/// Ownership: the services'. Threads: the network's own.
class DdsMirror::Impl::Services::Questions {
 public:
  explicit Questions(Services& of) : services_(of) {}

  /// Starts a query, or queues it. The peer's PeerClock gets the answers, and end_asking() when there will be no more.
  /// Returns false if no node of the peer can be queried now.
  [[nodiscard]] bool add(const dds::Gid& peer);
  void look_at(std::uint64_t id);
  void turn();
  [[nodiscard]] MonotonicTime due() const;

 private:
  struct Question;
  [[nodiscard]] std::vector<std::string> services_of(const dds::Gid& peer) const;
  void open(const dds::Gid& peer);
  void send(Question& question);
  void receive(Question& question);
  void take(Question& question, const dds::Sample& sample);
  void look_for_server(Question& question);
  void close(std::shared_ptr<Question> question);
  [[nodiscard]] bool is_over(const Question& question) const;
  [[nodiscard]] dds::PeerClock* clock_of(const dds::Gid& peer) const;

  Services& services_;
  std::deque<dds::Gid> waiting_;
  std::map<std::uint64_t, std::shared_ptr<Question>> open_ones_;
  std::uint64_t last_id_ = 0;
  bool is_forbidden_ = false;
};

}  // namespace nacelle
