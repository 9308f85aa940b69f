// A program that has closed its standard streams, as a service does, and writes to them all the
// same: no line of it gets into a store.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "plait/digest.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/in_child.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

constexpr std::string_view kLine = "a line of a log\n";

void write_lines() {
  for (int stream = 0; stream < 3; ++stream)
    static_cast<void>(!::write(stream, kLine.data(), kLine.size()));
}

struct Host {
  const char* report;
  std::function<void()> logs;  ///< again and again, while the library works
};

Store new_store(const std::filesystem::path& path, const char* backend) {
  StoreOptions options;
  options.backend = backend;
  options.block_bytes = 4096;
  options.io_threads = 0;  // the streams change only between calls of this thread
  Store store = Store::create(
      path, lay_out(BaseMesh::build(random_sphere(3, 100)), LayoutKind::kAutomatic).mesh, options,
      default_backends());
  add_base_positions(store);
  return store;
}

void close_streams() {
  for (int stream = 0; stream < 3; ++stream) ::close(stream);
}

/// With `late`, the program closes its streams when it has a store, as it becomes a service.
bool stays_whole(const std::filesystem::path& path, const std::string& backend, const Host& host,
                 bool late) {
  const auto log = [&](const Progress&) {
    host.logs();
    return true;
  };
  Store memory = new_store({}, "memory");
  subdivide(memory, {.levels = 4});
  if (!late) close_streams();
  Store store = new_store(path, backend.c_str());
  if (late) close_streams();
  for (const int levels : {2, 4}) {
    subdivide(store, {.executor = ExecutorKind::kSweep, .levels = levels, .progress = log});
    host.logs();
    store.commit();
    host.logs();
  }
  store.close();
  const Store again = Store::open(path, {.io_threads = 0}, default_backends());
  return verify(again, log).damaged.empty() && digest(again, {.progress = log}) == digest(memory);
}

}  // namespace

#if !defined(__SANITIZE_THREAD__)  // it supports no threads in a forked process
TEST_CASE("Store_OfAProgramThatLogsToClosedStreams_StaysWhole") {
  const std::vector<Host> hosts = {
      {"Mithril-mine/libmdbx#144: a line to the closed stream", write_lines},
      {"monero-project/monero#6147: the lines of a child process",
       [] {
         static int calls = 0;
         if (++calls % 64 == 1) static_cast<void>(std::system("echo a line; echo another >&2"));
       }},
      {"jart/cosmopolitan#513: a log file gets the numbers later", [] {
         const int file = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
         for (int stream = 0; stream < 3; ++stream) ::dup2(file, stream);
         write_lines();
         for (int stream = 0; stream < 3; ++stream) ::close(stream);
         if (file > 2) ::close(file);
       }}};
  for (const std::string& backend : usable_backends())
    for (const Host& host : hosts)
      for (const bool late : {false, true}) {
        if (backend == "memory") continue;
        CAPTURE(backend, host.report, late);
        const TemporaryDirectory here;
        CHECK(in_child([&] { return stays_whole(here.path() / "s", backend, host, late); }));
      }
}
#else
TEST_CASE("Store_OfAProgramThatLogsToClosedStreams_StaysWhole") { SUCCEED(); }
#endif

}  // namespace plait::test
