// SPDX-License-Identifier: Apache-2.0
#include "node_face.hpp"

#include "nacelle/base/log.hpp"
#include "nacelle/msgs/type_description.hpp"
#include "offer.hpp"

namespace nacelle::runtime {
namespace {

NodeIdentity split(const std::string& node) {
  const auto slash = node.rfind('/');
  return {node.substr(slash + 1), slash == 0 ? "/" : node.substr(0, slash)};
}

}  // namespace

NodeFace::NodeFace(NodeServices& desk, Commons& commons, Executor& executor, std::uint64_t id, NodeIdentity identity)
    : node_(
          commons, std::move(identity), executor,
          [](const std::string& code, const std::string& text, const std::string& callback) {
            Logger{"container"}.error("{}: {} (in {})", code, text, callback);
          },
          false),
      parameters_(desk, id),
      lifecycle_(desk, id) {}

std::shared_ptr<NodeFace> NodeFace::make(NodeServices& desk, Commons& commons, Executor& executor, std::uint64_t id,
                                         const std::string& node, Parts parts) {
  std::shared_ptr<NodeFace> face{new NodeFace(desk, commons, executor, id, split(node))};
  if (parts != Parts::Parameters) face->lifecycle_.start(face->node_, {face, &face->lifecycle_});
  if (parts != Parts::Lifecycle) {
    face->parameters_.start(face->node_, {face, &face->parameters_});
    face->type_description_ = offer<GetTypeDescription>(
        face->node_, "get_type_description",
        [&commons, node](const GetTypeDescription::Request& request, GetTypeDescription::Response& response) {
          const auto types = commons.broker.types_of(node);
          response = msgs::answer(request, std::vector<msgs::UsedType>(types.begin(), types.end()));
        });
  }
  face->node_.open();
  return face;
}

void NodeFace::withdraw() {
  node_.withdraw_services();
  constexpr Duration kLongest = 10s;  // they only copy, so even an overloaded machine needs less
  if (!node_.close(node_.commons().clock.now() + kLongest))
    Logger{"container"}.error("{}: a service of its does not return", node_.identity().fully_qualified());
}

void NodeFace::report_services(std::vector<ServiceReport>& out) const {
  const std::size_t before = out.size();
  node_.report_services(out);
  for (std::size_t i = before; i < out.size(); ++i) out[i].is_standard = true;
}

}  // namespace nacelle::runtime
