#include "serve/http_server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "console.h"
#include "plait/error.h"

namespace plait {
namespace {

constexpr std::size_t kSentAtOnce = 64 << 10;
constexpr std::size_t kThreads = 16;  // a browser opens six connections

/// The part of a file that a request asks for.
struct Wanted {
  std::uint64_t first = 0, count = 0;
};

/// Nothing if the file has no byte of the range. A missing end is -1 (httplib::Request::ranges).
std::optional<Wanted> wanted_of(const httplib::Request& request, std::uint64_t bytes) {
  if (request.ranges.empty()) return Wanted{0, bytes};
  if (request.ranges.size() > 1) return std::nullopt;
  const auto [from, to] = request.ranges.front();
  if (from < 0 && to < 0) return std::nullopt;
  if (from < 0) {
    const std::uint64_t last = std::min(bytes, static_cast<std::uint64_t>(to));
    return last == 0 ? std::nullopt : std::optional(Wanted{bytes - last, last});
  }
  const auto first = static_cast<std::uint64_t>(from);
  if (first >= bytes || (to >= 0 && to < from)) return std::nullopt;
  const std::uint64_t after = to < 0 ? bytes : std::min(bytes, static_cast<std::uint64_t>(to) + 1);
  return Wanted{first, after - first};
}

}  // namespace

bool has_http_server() { return true; }

struct HttpServer::State {
  explicit State(const ServedStore& served) : files(served) {}

  void answer(const httplib::Request& request, httplib::Response& response);

  const ServedStore& files;
  httplib::Server server;
  int port = 0;
  std::atomic<std::uint64_t> requests{0}, bytes{0};
};

void HttpServer::State::answer(const httplib::Request& request, httplib::Response& response) {
  ++requests;
  response.set_header("Accept-Ranges", "bytes");
  // Pages of other servers, a notebook for example, may show the store too.
  response.set_header("Access-Control-Allow-Origin", "*");
  response.set_header("Access-Control-Expose-Headers", "Content-Range, ETag");
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Cache-Control", "no-cache");
  response.set_header("ETag", '"' + files.tag() + '"');
  const ServedStore::File* const file = files.find(request.path);
  if (file == nullptr) {
    response.status = 404;
    response.set_content("plait serve: there is no such file\n", "text/plain");
    return;
  }
  const std::optional<Wanted> wanted = wanted_of(request, file->bytes);
  if (!wanted) {
    response.status = 416;
    response.set_header("Content-Range", fmt::format("bytes */{}", file->bytes));
    return;
  }
  // cpp-httplib 0.11 takes the range of its own request from here, and does not cut it at the
  // file's end. The object is not const: the library gives handlers a const reference to it.
  if (!request.ranges.empty())
    const_cast<httplib::Request&>(request).ranges.front() = {
        static_cast<ssize_t>(wanted->first),
        static_cast<ssize_t>(wanted->first + wanted->count - 1)};
  if (request.method == "HEAD") {
    response.set_content_provider(
        file->bytes, file->content_type,
        [](std::size_t, std::size_t, httplib::DataSink&) { return false; });
    return;
  }
  bytes += wanted->count;
  response.set_content_provider(
      file->bytes, file->content_type,
      [this, file](std::size_t offset, std::size_t count, httplib::DataSink& sink) {
        std::array<std::byte, kSentAtOnce> buffer;
        const std::span<std::byte> part = std::span(buffer).first(std::min(count, kSentAtOnce));
        if (offset + part.size() > file->bytes) return false;
        try {
          files.read(*file, offset, part);
        } catch (const std::exception& error) {
          report_warning(error.what());
          return false;  // the connection ends early, so that the reader sees that bytes are
                         // missing
        }
        sink.write(reinterpret_cast<const char*>(part.data()), part.size());
        return true;
      });
}

HttpServer::HttpServer(const ServedStore& files, const ServerAddress& address)
    : state_(std::make_unique<State>(files)) {
  httplib::Server& server = state_->server;
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_tcp_nodelay(true);
  server.set_payload_max_length(0);
  server.set_keep_alive_max_count(1'000'000);
  // Another process must not share the port, as httplib's own options would allow.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  server.Get(".*",
             [state = state_.get()](const httplib::Request& request, httplib::Response& response) {
               state->answer(request, response);
             });
  // What a browser asks before a page of another server reads ranges.
  server.Options(".*", [](const httplib::Request&, httplib::Response& response) {
    response.status = 204;
    response.set_header("Access-Control-Allow-Origin", "*");
    response.set_header("Access-Control-Allow-Headers", "Range");
    response.set_header("Access-Control-Allow-Methods", "GET, HEAD");
  });
  errno = 0;
  bool bound = false;
  if (address.port == 0) {
    state_->port = server.bind_to_any_port(address.host);
    bound = state_->port > 0;
  } else {
    state_->port = address.port;
    bound = server.bind_to_port(address.host, address.port);
  }
  if (!bound) {
    const int reason = errno;
    throw Error(
        reason == EADDRINUSE ? ErrorCode::kBusy : ErrorCode::kInvalidArgument,
        fmt::format("serve on {}:{}: {}", address.host, address.port,
                    reason == 0 ? "this machine has no such address" : std::strerror(reason)));
  }
}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return state_->port; }
std::uint64_t HttpServer::requests() const { return state_->requests; }
std::uint64_t HttpServer::bytes() const { return state_->bytes; }

void HttpServer::run(const std::function<bool()>& stop) {
  std::atomic<bool> ended{false};
  std::thread listener([&] {
    state_->server.listen_after_bind();
    ended = true;
  });
  while (!ended && !stop()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const bool gave_up = ended;
  state_->server.stop();
  listener.join();
  if (gave_up) throw Error(ErrorCode::kIo, "serve: the system gives no more connections");
}

}  // namespace plait
