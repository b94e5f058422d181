// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "nacelle/base/result.hpp"
#include "transport_dds/port/blob_type.hpp"
#include "transport_dds/port/cyclone_log.hpp"
#include "transport_dds/port/endpoint.hpp"

namespace nacelle::transport_dds {

/// The domain and participant that all endpoints share.
struct ParticipantCore {
  Entity domain;       // destroying it destroys everything in it
  Entity participant;  // destroyed first
  BlobLimits limits;
  Gid gid;
  std::vector<Problem> remarks;  // Participant::remarks()
};

/// A topic with Cyclone's type object: the same one for all topics of that name and structure.
struct BlobTopic {
  std::shared_ptr<ParticipantCore> core;  // destroyed last
  Entity topic;
  const BlobType* type = nullptr;  // lives as long as the topic
};

[[nodiscard]] Result<BlobTopic, Problem> make_topic(std::shared_ptr<ParticipantCore> core,
                                                    const EndpointOptions& options);

/// Returns why Cyclone did not make a topic or an endpoint; `log` has its messages meanwhile.
[[nodiscard]] Problem problem_of(const std::string& what, const EndpointOptions& options, const CapturedLog& log,
                                 dds_return_t error);

/// Returns the endpoints that are matched with a writer or reader. `are_writers`: the matched ones are writers.
[[nodiscard]] std::vector<MatchedPeer> matched_peers(dds_entity_t endpoint, bool are_writers);

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using CycloneListener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

}  // namespace nacelle::transport_dds
