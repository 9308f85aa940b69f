// What stands for serve/http_server.cpp where cpp-httplib is not installed.
#include "plait/error.h"
#include "serve/http_server.h"

namespace plait {

bool has_http_server() { return false; }

struct HttpServer::State {};

HttpServer::HttpServer(const ServedStore& /*files*/, const ServerAddress& /*address*/) {
  throw Error(ErrorCode::kNotSupported,
              "serve: this program was built without cpp-httplib; any web server shows what `plait "
              "publish --page` makes");
}
HttpServer::~HttpServer() = default;
int HttpServer::port() const { return 0; }
std::uint64_t HttpServer::requests() const { return 0; }
std::uint64_t HttpServer::bytes() const { return 0; }
void HttpServer::run(const std::function<bool()>& /*stop*/) {}

}  // namespace plait
