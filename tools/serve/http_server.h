// serve/http_server.h: answers GET and HEAD for the files of a ServedStore. This header does not
// include cpp-httplib, which takes seconds to parse.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "publish/served_store.h"

namespace plait {

struct ServerAddress {
  std::string host = "127.0.0.1";
  int port = 0;  ///< 0: any free one
};

/// Whether the program was built with cpp-httplib.
bool has_http_server();

class HttpServer {
 public:
  /// Binds to the address, but answers nothing yet. Errors: kNotSupported without cpp-httplib;
  /// kBusy for a port that another program has; kInvalidArgument for an address that is not this
  /// machine's. The files must outlive this object.
  HttpServer(const ServedStore& files, const ServerAddress& address);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  /// Answers requests until `stop` says true; asks ten times a second. Errors: kIo if the system
  /// ends it.
  void run(const std::function<bool()>& stop);
  /// Requests answered, and bytes of their bodies.
  std::uint64_t requests() const;
  std::uint64_t bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plait
