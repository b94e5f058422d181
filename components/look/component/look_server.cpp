// SPDX-License-Identifier: Apache-2.0
#include "look/component/look_server.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "look/component/parameter_json.hpp"
#include "look/model/service_rights.hpp"
#include "look/protocol/look_fault.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/msgs/json.hpp"

namespace nacelle::look {
namespace {

constexpr Duration kTick = 40ms;
constexpr std::uint32_t kGraphTicks = 25, kTimeTicks = 2;  // the graph once a second
constexpr int kNice = 10;
constexpr std::size_t kMostSubscriptions = 1000, kMostPublications = 100, kMostCalls = 32;
// 200 a second; asking for all parameters calls two services of each node.
constexpr std::uint32_t kMostRequests = 200, kRequestsPerTick = 8, kAllParameters = 20;
constexpr unsigned kUnauthorized = 401, kForbidden = 403;

Problem not_allowed(const std::string& what) {
  return {what, "asks for the right to operate", "open the link that `nacelle look` prints for it",
          LookFault::NotAllowed};
}
Problem too_many(const std::string& what, std::size_t most) {
  return {what, fmt::format("a viewer may have {} of them", most), "end some", LookFault::TooMany};
}

}  // namespace

LookServer::LookServer(Node& node, GenericTopics topics, GenericServices services, Options options)
    : node_(node),
      topics_(std::move(topics)),
      graph_(services),
      options_(std::move(options)),
      access_(options_.access),
      assets_(options_.asset_folders),
      requests_(node, topics_, graph_),
      questions_(requests_) {}

Result<std::unique_ptr<LookServer>, Problem> LookServer::start(Node& node, GenericTopics topics,
                                                               GenericServices services, Options options) {
  std::unique_ptr<LookServer> made{new LookServer{node, std::move(topics), services, std::move(options)}};
  auto web = WebServer::listen(made->options_.web, *made);
  if (!web) return err(web.error());
  made->web_ = std::move(*web);
  made->thread_ = std::thread{[server = made.get()] {
    ::pthread_setname_np(::pthread_self(), "look");
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
    server->web_->run();
  }};
  return made;
}

LookServer::~LookServer() {
  if (!thread_.joinable()) return;
  web_->stop();
  thread_.join();
  is_ending_ = true;
  streams_.reset();  // they tell the server of changes
  services_.reset();
}

std::uint64_t LookServer::now_ns() const {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, topics_.clock().wall_now().since_origin.count()));
}

// --- what goes out ---------------------------------------------------------------------------------------------------------

void LookServer::send(ViewerId id, Viewer& viewer, Bytes frame) {
  if (!viewer.outbox.answer(true, std::move(frame))) web_->close(id);
  web_->ask_to_write(id);
}

void LookServer::say(ViewerId id, Viewer& viewer, std::string text) {
  if (!viewer.outbox.answer(false, Bytes{text.begin(), text.end()})) web_->close(id);
  web_->ask_to_write(id);
}

void LookServer::say_later(ViewerId id, std::string text) {
  web_->post([this, id, text = std::move(text)] {
    if (const auto found = viewers_.find(id); found != viewers_.end()) say(id, *found->second, text);
  });
}

void LookServer::warn(ViewerId id, Viewer& viewer, const Problem& problem) {
  say(id, viewer, status(StatusLevel::Warning, problem.text()));
}

bool LookServer::next(ViewerId id, bool& is_binary, Bytes& out) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return false;
  const auto item = found->second->outbox.next(topics_.clock().now());
  if (!item) return false;
  is_binary = item->is_binary;
  if (item->message == nullptr) {
    out.insert(out.end(), item->answer.begin(), item->answer.end());
    return true;
  }
  const Bytes head = message_head(item->subscription, item->message->time);
  out.insert(out.end(), head.begin(), head.end());
  out.insert(out.end(), item->message->bytes.begin(), item->message->bytes.end());
  return true;
}

// --- viewers come and go -----------------------------------------------------------------------------------------------------

unsigned LookServer::refusal_of(const Handshake& handshake) {
  if (!access_.is_host_allowed(handshake.host) || !access_.is_origin_allowed(handshake.origin, handshake.host))
    return kForbidden;
  return access_.right_of(handshake.token) == Right::None ? kUnauthorized : 0;
}

void LookServer::on_open(ViewerId id, const Handshake& handshake) {
  if (!streams_) {
    const auto follow = [this] { web_->post([this] { follow_changes(); }); };
    streams_ = std::make_unique<TopicStreams>(topics_, follow, [this] { return now_ns(); });
    services_ = std::make_unique<ServiceList>(graph_, follow);
    web_->tick_every(kTick);
  }
  follow_changes();  // the others hear of what is new, and this one of all
  Viewer& viewer =
      *viewers_.emplace(id, std::make_unique<Viewer>(access_.right_of(handshake.token), options_.bytes_per_second))
           .first->second;
  viewer.requests_left = kMostRequests;
  ServerInfo info{options_.name,
                  {"parameters", "parametersSubscribe", "services", "connectionGraph", "clientPublish", "assets"},
                  {},
                  std::to_string(id)};
  if (options_.has_sim_time) info.capabilities.emplace_back("time");
  if (!options_.container.empty()) info.metadata["nacelle.container"] = options_.container;
  info.metadata["nacelle.right"] = to_text(viewer.right);
  say(id, viewer, server_info(info));
  say(id, viewer, advertise(streams_->channels()));
  say(id, viewer, advertise_services(services_->services()));
}

void LookServer::on_close(ViewerId id) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end() || is_ending_) return;
  for (const auto& [subscription, channel] : found->second->subscriptions) streams_->unsubscribe(channel);
  if (!found->second->publications.empty()) requests_.post([this, id] { requests_.close_writers(id); });
  viewers_.erase(found);
  watch_parameter_events();
  if (!viewers_.empty()) return;
  web_->tick_every(Duration::zero());
  streams_.reset();
  services_.reset();
}

void LookServer::follow_changes() {
  if (!streams_) return;
  const auto topics = streams_->take_changes();
  const auto services = services_->take_changes();
  graph_changed_ = true;
  for (auto& [id, viewer] : viewers_) {
    Viewer& one = *viewer;
    for (const std::uint32_t gone : topics.gone) {
      std::erase_if(one.by_channel, [&](const auto& entry) {
        if (entry.first != gone) return false;
        one.outbox.forget(entry.second);
        one.subscriptions.erase(entry.second);
        return true;
      });
    }
    if (!topics.gone.empty()) say(id, *viewer, unadvertise(topics.gone));
    if (!services.gone.empty()) say(id, *viewer, unadvertise_services(services.gone));
    if (!topics.made.empty()) say(id, *viewer, advertise(topics.made));
    if (!services.made.empty()) say(id, *viewer, advertise_services(services.made));
  }
}

void LookServer::tell_graph() {
  ConnectionGraph graph;
  streams_->add_to(graph);
  services_->add_to(graph);
  for (auto& [id, viewer] : viewers_) {
    if (!viewer->watches_graph || viewer->graph == graph) continue;
    say(id, *viewer, connection_graph_update(viewer->graph, graph));
    viewer->graph = graph;
  }
}

void LookServer::on_tick() {
  ++ticks_;
  streams_->take_messages([this](std::uint32_t channel, const std::shared_ptr<const Encoded>& message) {
    for (auto& [id, viewer] : viewers_) {
      for (auto one = viewer->by_channel.lower_bound({channel, 0});
           one != viewer->by_channel.end() && one->first == channel; ++one)
        viewer->outbox.message(one->second, message);
    }
  });
  if (const auto complaint = streams_->take_complaint()) {
    for (auto& [id, viewer] : viewers_) say(id, *viewer, status(StatusLevel::Warning, *complaint));
  }
  if (graph_changed_ && ticks_ % kGraphTicks == 0) {
    graph_changed_ = false;
    tell_graph();
  }
  if (questions_wait_) {
    requests_.post([this] { questions_wait_ = questions_.look_at_time(topics_.clock().now()); });
  }
  const MonotonicTime now = topics_.clock().now();
  for (auto& [id, viewer] : viewers_) {
    if (options_.has_sim_time && ticks_ % kTimeTicks == 0) send(id, *viewer, time_frame(now_ns()));
    viewer->requests_left = std::min(kMostRequests, viewer->requests_left + kRequestsPerTick);
    if (viewer->outbox.has_next(now)) web_->ask_to_write(id);
  }
}

// --- what viewers say ----------------------------------------------------------------------------------------------------------

bool LookServer::on_message(ViewerId id, bool is_binary, ByteView bytes) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return false;
  Viewer& viewer = *found->second;
  const auto message = is_binary ? read_binary(bytes) : read_text(as_text(bytes));
  if (!message) {
    warn(id, viewer, message.error());
    return true;
  }
  std::visit([&](const auto& one) { take(id, viewer, one); }, *message);
  return true;
}

void LookServer::take(ViewerId id, Viewer& viewer, const Subscribe& message) {
  for (const auto& one : message.all) {
    if (viewer.subscriptions.contains(one.subscription)) continue;
    if (viewer.subscriptions.size() >= kMostSubscriptions)
      return warn(id, viewer, too_many("subscriptions", kMostSubscriptions));
    if (!streams_->has(one.channel)) {
      warn(id, viewer,
           {fmt::format("channel {}", one.channel), "there is no such channel",
            "it may have gone: read the channels again", LookFault::UnknownChannel});
      continue;
    }
    viewer.subscriptions.emplace(one.subscription, one.channel);
    viewer.by_channel.emplace(one.channel, one.subscription);
    for (const auto& kept : streams_->subscribe(one.channel)) viewer.outbox.message(one.subscription, kept);
  }
}

void LookServer::take(ViewerId, Viewer& viewer, const Unsubscribe& message) {
  for (const std::uint32_t subscription : message.subscriptions) {
    const auto found = viewer.subscriptions.find(subscription);
    if (found == viewer.subscriptions.end()) continue;
    streams_->unsubscribe(found->second);
    viewer.outbox.forget(subscription);
    viewer.by_channel.erase({found->second, subscription});
    viewer.subscriptions.erase(found);
  }
}

std::optional<Problem> LookServer::order(Viewer& viewer, std::function<void()> work, std::uint32_t requests) {
  if (viewer.requests_left < requests)
    return Problem{"the viewer", "asks for too much at a time", "send fewer requests a second", LookFault::TooMany};
  viewer.requests_left -= requests;
  if (requests_.post(std::move(work))) return std::nullopt;
  return Problem{"the robot", "is busy: too many requests wait for the node's executor", "send fewer",
                 LookFault::TooMany};
}

void LookServer::order_or_warn(ViewerId id, Viewer& viewer, std::function<void()> work, std::uint32_t requests) {
  if (const auto problem = order(viewer, std::move(work), requests)) warn(id, viewer, *problem);
}

void LookServer::take(ViewerId id, Viewer& viewer, const Advertise& message) {
  for (const auto& one : message.all) {
    if (viewer.right != Right::Operate && !is_emergency_stop(one.topic, one.type)) {
      warn(id, viewer, not_allowed("publishing " + one.topic));
      continue;
    }
    if (viewer.publications.size() >= kMostPublications)
      return warn(id, viewer, too_many("published topics", kMostPublications));
    if (one.encoding != "cdr" && one.encoding != "json") {
      warn(id, viewer, {one.topic, "the encoding is neither cdr nor json", "use one of them", LookFault::BadEncoding});
      continue;
    }
    if (const auto valid = validate_full_topic_name(one.topic); !valid) {
      Problem problem = valid.error();
      problem.code = LookFault::BadMessage;
      warn(id, viewer, problem);
      continue;
    }
    const auto refused = order(viewer, [this, id, channel = one.channel, topic = one.topic, type = one.type] {
      const auto opened = requests_.open_writer(id, channel, topic, type);
      if (!opened) say_later(id, status(StatusLevel::Error, opened.error().text()));
    });
    if (refused) return warn(id, viewer, *refused);
    viewer.publications.insert_or_assign(one.channel, Out{one.topic, one.type, one.encoding});
  }
}

void LookServer::take(ViewerId id, Viewer& viewer, const Unadvertise& message) {
  for (const std::uint32_t channel : message.channels) {
    if (viewer.publications.erase(channel) != 0)
      requests_.post([this, id, channel] { requests_.close_writer(id, channel); });
  }
}

void LookServer::take(ViewerId id, Viewer& viewer, const Publication& message) {
  const auto found = viewer.publications.find(message.channel);
  if (found == viewer.publications.end())
    return warn(id, viewer,
                {fmt::format("channel {}", message.channel), "is not advertised", "advertise it first",
                 LookFault::UnknownChannel});
  const Out& out = found->second;
  if (viewer.right != Right::Operate && !sets_emergency_stop(out.encoding, message.data))
    return warn(id, viewer, not_allowed("releasing the emergency stop"));
  order_or_warn(id, viewer,
                [this, id, channel = message.channel, encoding = out.encoding,
                 data = Bytes{message.data.begin(), message.data.end()}] {
                  const auto published = requests_.publish(id, channel, encoding, data);
                  if (!published) say_later(id, status(StatusLevel::Error, published.error().text()));
                });
}

void LookServer::refuse_call(ViewerId id, Viewer& viewer, const ServiceCall& call, const Problem& problem) {
  say(id, viewer, service_call_failure(call.service, call.call, problem.text()));
}

void LookServer::take(ViewerId id, Viewer& viewer, const ServiceCall& message) {
  const ServiceList::Service* const service = services_->find(message.service);
  if (service == nullptr)
    return refuse_call(id, viewer, message,
                       {"service", "there is no such service", "it may have gone", LookFault::UnknownService});
  const Right needed = right_for_service(service->request->name);
  if (needed == Right::None)
    return refuse_call(
        id, viewer, message,
        {service->name, "is for the robot's own machine only", "use `nacelle` there", LookFault::NotAllowed});
  if (needed > viewer.right) return refuse_call(id, viewer, message, not_allowed("calling " + service->name));
  if (viewer.calls >= kMostCalls) return refuse_call(id, viewer, message, too_many("calls on their way", kMostCalls));
  const auto request = std::make_shared<msgs::AnyMessage>(*service->request);
  if (message.encoding == "json") {
    if (auto read = msgs::from_json(as_text(message.data), *service->request, request->get()); !read)
      return refuse_call(id, viewer, message, {service->name, read.error().text(), "", LookFault::BadEncoding});
  } else if (message.encoding != "cdr" || !service->request->decode(message.data, request->get())) {
    return refuse_call(id, viewer, message,
                       {service->name, "the request is none of its type in CDR", "", LookFault::BadEncoding});
  }
  ++viewer.calls;
  const auto answer = [this, id, service_id = message.service, call = message.call, encoding = message.encoding,
                       &type = *service->response](const void* response) {
    std::optional<Bytes> data;
    if (response != nullptr && encoding == "cdr") {
      data.emplace(type.encoded_size(response));
      type.encode(response, data->data());
    } else if (response != nullptr) {
      const std::string text = msgs::to_json(type, response);
      data.emplace(text.begin(), text.end());
    }
    web_->post([this, id, service_id, call, encoding, data = std::move(data)] {
      const auto found = viewers_.find(id);
      if (found == viewers_.end()) return;
      --found->second->calls;
      if (data) {
        send(id, *found->second, service_response(service_id, call, encoding, *data));
      } else {
        say(id, *found->second,
            service_call_failure(service_id, call,
                                 "the service does not answer: its node is not active, or went away"));
      }
    });
  };
  const auto refused = order(viewer, [this, request, answer, name = service->name, response = service->response] {
    requests_.call(name, request->type(), *response, std::move(*request), answer);
  });
  if (!refused) return;
  --viewer.calls;
  refuse_call(id, viewer, message, *refused);
}

// --- parameters, graph, assets -------------------------------------------------------------------------------------------------

ParameterQuestions::Take LookServer::parameter_answer(ViewerId id, const std::string& question) {
  return [this, id, question](nlohmann::json parameters, const std::vector<std::string>& problems) {
    for (const std::string& problem : problems) say_later(id, status(StatusLevel::Warning, problem));
    say_later(id, parameter_values(std::move(parameters), question));
  };
}

void LookServer::take(ViewerId id, Viewer& viewer, const GetParameters& message) {
  questions_wait_ = true;
  order_or_warn(
      id, viewer,
      [this, id, message, nodes = services_->nodes_with("list_parameters")] {
        questions_.get(message.names, nodes, topics_.clock().now(), parameter_answer(id, message.id));
      },
      kAllParameters);
}

void LookServer::take(ViewerId id, Viewer& viewer, const SetParameters& message) {
  if (viewer.right != Right::Operate) return warn(id, viewer, not_allowed("setting parameters"));
  questions_wait_ = true;
  order_or_warn(id, viewer, [this, id, message] {
    questions_.set(message.all, topics_.clock().now(), parameter_answer(id, message.id));
  });
}

void LookServer::take(ViewerId, Viewer& viewer, const WatchParameters& message) {
  if (message.names.empty()) {
    viewer.watches_all_parameters = message.on;
    viewer.watched_parameters.clear();
  }
  for (const std::string& name : message.names) {
    if (!message.on) {
      viewer.watched_parameters.erase(name);
    } else if (viewer.watched_parameters.size() < kMostSubscriptions) {
      viewer.watched_parameters.insert(name);
    }
  }
  watch_parameter_events();
}

void LookServer::watch_parameter_events() {
  const bool watches = std::any_of(viewers_.begin(), viewers_.end(), [](const auto& entry) {
    return entry.second->watches_all_parameters || !entry.second->watched_parameters.empty();
  });
  if (std::exchange(watches_parameters_, watches) == watches) return;
  requests_.post([this, watches] {
    parameter_events_ =
        !watches ? nullptr
                 : node_.create_subscription<rcl_interfaces::msg::ParameterEvent>(
                       "/parameter_events", QoS(100),
                       [this](const rcl_interfaces::msg::ParameterEvent& event) { on_parameter_event(event); });
  });
}

void LookServer::on_parameter_event(const rcl_interfaces::msg::ParameterEvent& event) {
  nlohmann::json changed = nlohmann::json::array();
  for (const auto* const list : {&event.new_parameters, &event.changed_parameters}) {
    for (const auto& one : *list)
      changed.push_back(parameter_json(std::string{event.node} + "." + std::string{one.name}, one.value));
  }
  web_->post([this, changed = std::move(changed)] {
    for (auto& [id, viewer] : viewers_) {
      nlohmann::json wanted = nlohmann::json::array();
      for (const auto& one : changed) {
        if (viewer->watches_all_parameters || viewer->watched_parameters.contains(one["name"].get<std::string>()))
          wanted.push_back(one);
      }
      if (!wanted.empty()) say(id, *viewer, parameter_values(std::move(wanted), ""));
    }
  });
}

void LookServer::take(ViewerId, Viewer& viewer, const WatchGraph& message) {
  viewer.watches_graph = message.on;
  viewer.graph = {};
  graph_changed_ = true;
}

void LookServer::take(ViewerId id, Viewer& viewer, const FetchAsset& message) {
  const auto read = assets_.read(message.uri);
  send(id, viewer,
       read ? asset(message.request, as_bytes(*read)) : asset_failure(message.request, read.error().text()));
}

}  // namespace nacelle::look
