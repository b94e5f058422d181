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

/// Asks nodes of others whose clocks may be behind (wire/peer_clock.hpp) something, for the stamp of the answer.
///
/// The question is get_parameter_types of no names, which every node of ROS 2 serves and which changes nothing. Each has a
/// client of its own, of no node, as long as it is open; where nothing is in doubt there is none. A few are open at a time,
/// and some more wait: a peer can make up as many participants as it likes.
/// Ownership: the services'. Threads: the network's own.
class DdsMirror::Impl::Services::Questions {
 public:
  explicit Questions(Services& of) : services_(of) {}

  /// The peer's clock is told of the answers, and when there will be no more. False: nobody there can be asked, or not now.
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
