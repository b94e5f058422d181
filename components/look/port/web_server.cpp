// SPDX-License-Identifier: Apache-2.0
#include "look/port/web_server.hpp"

#include <fmt/format.h>
#include <libwebsockets.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace nacelle::look {
namespace {

constexpr std::uint16_t kPingAfter_s = 5, kHangUpAfter_s = 12;  // a phone that has left the Wi-Fi says nothing
constexpr std::uint32_t kSpareDescriptors = 32;                 // pages that are being fetched

std::string header(lws* socket, lws_token_indexes which) {
  const int length = lws_hdr_total_length(socket, which);
  if (length <= 0) return {};
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  const int copied = lws_hdr_copy(socket, text.data(), static_cast<int>(text.size()), which);
  text.resize(copied > 0 ? static_cast<std::size_t>(copied) : 0);
  return text;
}

/// The value of "name=" in the query; empty if there is none.
std::string query_value(lws* socket, const char* name) {
  std::array<char, 256> text{};
  const char* const found = lws_get_urlarg_by_name(socket, name, text.data(), static_cast<int>(text.size()));
  return found == nullptr ? "" : found;
}

const lws_retry_bo_t* idle_policy() {
  static const lws_retry_bo_t policy = [] {
    lws_retry_bo_t made{};
    made.secs_since_valid_ping = kPingAfter_s;
    made.secs_since_valid_hangup = kHangUpAfter_s;
    return made;
  }();
  return &policy;
}

/// Sent with every page: it runs its own scripts only, and no other page may frame it.
struct SafeHeader {
  const char *name, *value;
};
constexpr std::array kSafeHeaders{
    SafeHeader{"content-security-policy:",
               "default-src 'self'; img-src 'self' blob: data:; connect-src 'self'; style-src 'self'; "
               "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
    SafeHeader{"x-content-type-options:", "nosniff"},
    SafeHeader{"referrer-policy:", "no-referrer"},
    SafeHeader{"cache-control:", "no-cache"},
};

}  // namespace

struct WebServer::Connection {
  lws* socket = nullptr;
  Bytes incoming;
  bool is_closing = false;
};

struct WebServer::Timer {
  // The first member: libwebsockets hands its address to the callback.
  lws_sorted_usec_list_t list{};
  WebServer* owner = nullptr;
  Duration period{};
};

struct WebServer::Callbacks {
  static WebServer& server_of(lws* socket) {
    return *static_cast<WebServer*>(lws_context_user(lws_get_context(socket)));
  }

  static int call(lws* socket, lws_callback_reasons reason, void*, void* in, std::size_t length) {
    WebServer& server = server_of(socket);
    switch (reason) {
      case LWS_CALLBACK_HTTP: return send_file(server, socket, static_cast<const char*>(in));
      case LWS_CALLBACK_HTTP_WRITEABLE: return send_rest(server, socket);
      case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return filter(server, socket);
      case LWS_CALLBACK_ESTABLISHED: return open(server, socket);
      case LWS_CALLBACK_RECEIVE: return receive(server, socket, {static_cast<const std::uint8_t*>(in), length});
      case LWS_CALLBACK_SERVER_WRITEABLE: return write(server, socket);
      case LWS_CALLBACK_CLOSED: return closed(server, socket);
      case LWS_CALLBACK_CLOSED_HTTP: server.sending_.erase(socket); return 0;
      case LWS_CALLBACK_EVENT_WAIT_CANCELLED: server.take_posts(); return 0;
      default: return lws_callback_http_dummy(socket, reason, nullptr, in, length);
    }
  }

  static int refuse(lws* socket, unsigned code, const char* words) {
    static_cast<void>(lws_return_http_status(socket, code, words));
    return -1;
  }

  static int send_file(WebServer& server, lws* socket, const char* path) {
    if (!server.handler_.takes_host(header(socket, WSI_TOKEN_HOST)))
      return refuse(socket, HTTP_STATUS_FORBIDDEN,
                    "this name is not one of this machine: see docs/look.md, allowed_hosts");
    const auto found = server.options_.files.find(path);
    if (found == server.options_.files.end()) return refuse(socket, HTTP_STATUS_NOT_FOUND, "there is no such page");
    std::array<std::uint8_t, LWS_PRE + 2048> head{};
    std::uint8_t* at = &head[LWS_PRE];
    std::uint8_t* const begin = at;
    std::uint8_t* const end = head.data() + head.size();
    if (lws_add_http_common_headers(socket, HTTP_STATUS_OK, found->second.media_type.c_str(), found->second.body.size(),
                                    &at, end) != 0)
      return -1;
    for (const SafeHeader& one : kSafeHeaders) {
      const std::string_view value{one.value};
      if (lws_add_http_header_by_name(socket, reinterpret_cast<const unsigned char*>(one.name),
                                      reinterpret_cast<const unsigned char*>(value.data()),
                                      static_cast<int>(value.size()), &at, end) != 0)
        return -1;
    }
    if (lws_finalize_write_http_header(socket, begin, &at, end) != 0) return -1;
    server.sending_[socket] = {&found->second.body, 0};
    lws_callback_on_writable(socket);
    return 0;
  }

  static int send_rest(WebServer& server, lws* socket) {
    constexpr std::size_t kPiece = 16384;
    const auto found = server.sending_.find(socket);
    if (found == server.sending_.end()) return -1;
    auto& [body, sent] = found->second;
    const std::size_t size = std::min(kPiece, body->size() - sent);
    const bool is_last = sent + size == body->size();
    server.scratch_.assign(LWS_PRE, 0);
    server.scratch_.insert(server.scratch_.end(), body->begin() + static_cast<std::ptrdiff_t>(sent),
                           body->begin() + static_cast<std::ptrdiff_t>(sent + size));
    if (lws_write(socket, server.scratch_.data() + LWS_PRE, size, is_last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) !=
        static_cast<int>(size)) {
      server.sending_.erase(found);
      return -1;
    }
    sent += size;
    if (!is_last) {
      lws_callback_on_writable(socket);
      return 0;
    }
    server.sending_.erase(found);
    return lws_http_transaction_completed(socket) != 0 ? -1 : 0;
  }

  /// A WebSocket is asked for: its headers are there, no answer has gone out.
  static int filter(WebServer& server, lws* socket) {
    const lws_protocols* const protocol = lws_get_protocol(socket);
    if (protocol == nullptr || !std::string_view{protocol->name}.starts_with("foxglove."))
      return refuse(socket, HTTP_STATUS_BAD_REQUEST, "the subprotocol is not foxglove.sdk.v1 or foxglove.websocket.v1");
    if (server.connections_.size() >= server.options_.most_viewers)
      return refuse(socket, HTTP_STATUS_SERVICE_UNAVAILABLE, "there are as many viewers as max_clients");
    const std::string host = header(socket, WSI_TOKEN_HOST), origin = header(socket, WSI_TOKEN_ORIGIN),
                      token = query_value(socket, "token=");
    if (const unsigned code = server.handler_.refusal_of({host, origin, token}); code != 0)
      return refuse(socket, code,
                    code == HTTP_STATUS_UNAUTHORIZED ? "the token is wrong: `nacelle look` prints the link"
                                                     : "this page or name is not allowed: see docs/look.md");
    return 0;
  }

  static int open(WebServer& server, lws* socket) {
    const ViewerId viewer = ++server.last_viewer_;
    server.connections_.try_emplace(viewer).first->second.socket = socket;
    server.by_socket_[socket] = viewer;
    const std::string host = header(socket, WSI_TOKEN_HOST), origin = header(socket, WSI_TOKEN_ORIGIN),
                      token = query_value(socket, "token=");
    server.handler_.on_open(viewer, {host, origin, token});
    return 0;
  }

  static int receive(WebServer& server, lws* socket, ByteView bytes) {
    const auto viewer = server.by_socket_.find(socket);
    if (viewer == server.by_socket_.end()) return -1;
    Connection& connection = server.connections_.at(viewer->second);
    if (connection.is_closing) return -1;
    if (connection.incoming.size() + bytes.size() > server.options_.most_message_bytes) {
      static constexpr std::string_view kWords = "a message is too large";
      std::string words{kWords};
      lws_close_reason(socket, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, reinterpret_cast<unsigned char*>(words.data()),
                       words.size());
      return -1;
    }
    connection.incoming.insert(connection.incoming.end(), bytes.begin(), bytes.end());
    if (lws_is_final_fragment(socket) == 0 || lws_remaining_packet_payload(socket) != 0) return 0;
    const Bytes whole = std::exchange(connection.incoming, {});
    return server.handler_.on_message(viewer->second, lws_frame_is_binary(socket) != 0, whole) ? 0 : -1;
  }

  static int write(WebServer& server, lws* socket) {
    const auto viewer = server.by_socket_.find(socket);
    if (viewer == server.by_socket_.end() || server.connections_.at(viewer->second).is_closing) return -1;
    bool is_binary = false;
    server.scratch_.assign(LWS_PRE, 0);
    if (!server.handler_.next(viewer->second, is_binary, server.scratch_)) return 0;
    const std::size_t size = server.scratch_.size() - LWS_PRE;
    if (lws_write(socket, server.scratch_.data() + LWS_PRE, size, is_binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT) <
        static_cast<int>(size))
      return -1;
    lws_callback_on_writable(socket);
    return 0;
  }

  static int closed(WebServer& server, lws* socket) {
    const auto viewer = server.by_socket_.find(socket);
    if (viewer == server.by_socket_.end()) return 0;
    const ViewerId gone = viewer->second;
    server.by_socket_.erase(viewer);
    server.connections_.erase(gone);
    server.handler_.on_close(gone);
    return 0;
  }

  static void tick(lws_sorted_usec_list_t* list) {
    auto* const timer = reinterpret_cast<Timer*>(list);
    timer->owner->tick_every(timer->period);  // the next one; the handler may end it
    timer->owner->handler_.on_tick();
  }
};

WebServer::WebServer(Options options, WebHandler& handler)
    : options_(std::move(options)), handler_(handler), timer_(std::make_unique<Timer>()) {
  timer_->owner = this;
}

Result<std::unique_ptr<WebServer>, Problem> WebServer::listen(Options options, WebHandler& handler) {
  // "http" is what a connection speaks until it asks for one of the others.
  static const std::array protocols{
      lws_protocols{"http", &Callbacks::call, 0, 0, 0, nullptr, 0},
      lws_protocols{"foxglove.sdk.v1", &Callbacks::call, 0, 4096, 0, nullptr, 0},
      lws_protocols{"foxglove.websocket.v1", &Callbacks::call, 0, 4096, 0, nullptr, 0},
      lws_protocols{nullptr, nullptr, 0, 0, 0, nullptr, 0},
  };
  std::unique_ptr<WebServer> made{new WebServer{std::move(options), handler}};
  lws_set_log_level(0, nullptr);
  lws_context_creation_info info{};
  info.port = made->options_.port;
  info.iface = made->options_.address.empty() ? nullptr : made->options_.address.c_str();
  info.protocols = protocols.data();
  info.user = made.get();
  info.gid = static_cast<gid_t>(-1);
  info.uid = static_cast<uid_t>(-1);
  info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
  info.fd_limit_per_thread = made->options_.most_viewers + kSpareDescriptors;
  info.timeout_secs = 5;
  info.keepalive_timeout = 5;
  info.retry_and_idle_policy = idle_policy();
  info.vhost_name = "look";
  made->context_ = lws_create_context(&info);
  if (made->context_ != nullptr) {
    if (lws_vhost* const host = lws_get_vhost_by_name(made->context_, "look"); host != nullptr)
      made->port_ = static_cast<std::uint16_t>(std::max(0, lws_get_vhost_listen_port(host)));
  }
  if (made->context_ == nullptr || made->port_ == 0) {
    return err(Problem{
        Place::of_parameter("port"),
        fmt::format("cannot listen on {}, port {}",
                    made->options_.address.empty() ? "all addresses" : made->options_.address, made->options_.port),
        "another program may use the port (`ss -ltnp` shows it), or the address is not one of this machine"});
  }
  return made;
}

WebServer::~WebServer() {
  if (context_ != nullptr) lws_context_destroy(context_);
}

void WebServer::run() {
  for (;;) {
    {
      const LockGuard lock{mutex_};
      if (is_ending_) return;
    }
    if (lws_service(context_, 0) < 0) return;
  }
}

void WebServer::stop() {
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;
  }
  lws_cancel_service(context_);
}

void WebServer::post(std::function<void()> work) {
  {
    const LockGuard lock{mutex_};
    posts_.push_back(std::move(work));
    if (posts_.size() > 1) return;  // the server is awake already
  }
  lws_cancel_service(context_);
}

void WebServer::take_posts() {
  std::vector<std::function<void()>> now;
  {
    const LockGuard lock{mutex_};
    std::swap(now, posts_);
  }
  for (const auto& work : now) work();
}

void WebServer::ask_to_write(ViewerId viewer) {
  if (const auto found = connections_.find(viewer); found != connections_.end())
    lws_callback_on_writable(found->second.socket);
}

void WebServer::close(ViewerId viewer) {
  const auto found = connections_.find(viewer);
  if (found == connections_.end()) return;
  found->second.is_closing = true;
  lws_callback_on_writable(found->second.socket);
  // One that does not read is never writable.
  lws_set_timeout(found->second.socket, PENDING_TIMEOUT_CLOSE_SEND, 1);
}

void WebServer::tick_every(Duration period) {
  timer_->period = period;
  lws_sul_schedule(context_, 0, &timer_->list, &Callbacks::tick,
                   period > Duration::zero() ? std::chrono::duration_cast<std::chrono::microseconds>(period).count()
                                             : LWS_SET_TIMER_USEC_CANCEL);
}

}  // namespace nacelle::look
