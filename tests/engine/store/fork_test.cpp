// A process that was forked from one that has stores open: every call refuses there, and nothing
// that it does or leaves disturbs its parent.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "engine/store/sample_store.h"
#include "plait/digest.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/error_of.h"
#include "support/eventually.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

/// The allocator of the address sanitizer has locks that fork() does not take: what another thread
/// holds at that instant stays locked in the child for ever. A thread that sleeps holds none.
void let_other_threads_fall_asleep() { REQUIRE(eventually(other_threads_sleep)); }

/// Forks now, and lets the child run `body` at run() or at the end.
class Child {
 public:
  explicit Child(const std::function<bool()>& body) {
    REQUIRE(::pipe2(pipe_, O_CLOEXEC) == 0);
    let_other_threads_fall_asleep();
    child_ = ::fork();
    REQUIRE(child_ >= 0);
    if (child_ != 0) return;
    ::close(pipe_[1]);
    bool good = false;
    try {
      char start = 0;
      static_cast<void>(!::read(pipe_[0], &start, 1));
      ::alarm(120);  // a call that waits for a thread of the parent would wait for ever
      good = body();
    } catch (...) {
    }
    ::_exit(good ? 0 : 1);
  }
  ~Child() {
    if (child_ > 0) run();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Whether `body` returned true.
  bool run() {
    ::close(pipe_[1]);
    ::close(pipe_[0]);
    int status = 0;
    REQUIRE(::waitpid(std::exchange(child_, -1), &status, 0) >= 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  int pipe_[2];
  pid_t child_ = -1;
};

bool refuses(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code() == ErrorCode::kBadState &&
           std::string_view(error.what()).find("forked") != std::string_view::npos;
  }
  return false;
}

StoreOptions options_of(const std::string& backend) {
  StoreOptions options = sample_options(backend);
  options.budget_bytes = 1 << 20;
  options.io_threads = 2;
  return options;
}

/// A path for the backend: none if it has only memory.
std::filesystem::path place(const TemporaryDirectory& directory, const std::string& backend) {
  return default_backends().find(backend).traits.in_memory ? std::filesystem::path()
                                                           : directory.path() / "s.plait";
}

}  // namespace

TEST_CASE("Store_InAForkedProcess_RefusesEveryCallAndDisturbsNobody") {
  for (const std::string& backend : usable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory directory;
    std::optional<Store> store =
        Store::create(place(directory, backend), BaseMesh::build(random_sheet(5, 40)),
                      options_of(backend), default_backends());
    const AttributeId id = add_sample(*store, sample_schemas()[0], 3);
    const auto reader = std::make_unique<Reader>(std::as_const(*store));
    auto view = std::make_unique<PatchView>(reader->read_patch(0, 3));
    auto session = std::make_unique<Session>(StoreAccess::open_session(*store));
    LevelFile& level = StoreAccess::level_file(*store, id, 1);
    Child child([&] {
      bool good =
          refuses([&] { store->base(); }) && refuses([&] { store->options(); }) &&
          refuses([&] { store->attribute("position"); }) &&
          refuses([&] { store->add_level(id); }) && refuses([&] { store->commit(); }) &&
          refuses([&] { store->close(); }) && refuses([&] { store->info(); }) &&
          refuses([&] { reader->read_patch(1, 2); }) &&
          refuses([&] { reader->read_patch(1, 0); }) && refuses([&] { reader->statistics(); }) &&
          refuses([&] { Reader another(*store); }) && refuses([&] { digest(*store); }) &&
          refuses([&] { session->pin(level, 0, Access::kUpdate); }) && !session->prefetch(level, 0);
      // What a view shows is memory of this process too.
      good = good && view->records(store ? "position" : "").at(0, 0).size() == 12;
      session.reset();
      view.reset();
      return good;
    });
    CHECK(child.run());
    view.reset();
    CHECK(holds_sample(*store, id));
  }
}

TEST_CASE("StoreDestructor_InAForkedProcess_RemovesNothingAndEnds") {
  for (const std::string& backend : usable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory directory;
    const std::filesystem::path path = place(directory, backend);
    std::optional<Store> store = Store::create(path, BaseMesh::build(random_sheet(5, 40)),
                                               options_of(backend), default_backends());
    add_sample(*store, sample_schemas()[0], 3);
    std::optional<Reader> reader(std::in_place, std::as_const(*store));
    std::optional<PatchView> view = reader->read_patch(0, 3);
    Child child([&] {
      store.reset();
      reader.reset();
      view.reset();
      return true;
    });
    CHECK(child.run());
    view.reset();
    reader.reset();
    store->commit();
    if (path.empty()) continue;
    store.reset();
    Store again = Store::open(path, {.io_threads = 0}, default_backends());
    CHECK(holds_sample(again, again.attribute("position")));
  }
}

TEST_CASE("Locks_AreNotInheritedByAForkedProcess") {
  for (const bool writable : {false, true}) {
    CAPTURE(writable);
    const TemporaryDirectory directory;
    const std::filesystem::path path = directory.path() / "s.plait";
    {
      Store made = Store::create(path, BaseMesh::build(tetrahedron()), options_of("pread"),
                                 default_backends());
      made.commit();
    }
    const OpenOptions options{.writable = writable};
    std::optional<Store> store = Store::open(path, options, default_backends());
    Child child([&] { return refuses([&] { store->base(); }); });
    // The child still lives.
    store.reset();
    CHECK_NOTHROW(Store::open(path, {.writable = true}, default_backends()));
    CHECK(child.run());
  }
}

#if !defined(__SANITIZE_THREAD__)  // it supports no threads in a forked process
TEST_CASE("Store_OfAForkedProcessItself_ReadsWhatItsParentHasOpen") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory directory;
    const std::filesystem::path path = directory.path() / "s.plait";
    Store store = Store::create(path, BaseMesh::build(random_sheet(5, 40)), options_of(backend),
                                default_backends());
    const AttributeId id = add_sample(store, sample_schemas()[0], 3);
    store.commit();
    Child child([&] {
      Store own = Store::open(path, {.budget_bytes = 1 << 20, .io_threads = 1}, default_backends());
      return holds_sample(own, own.attribute("position"));
    });
    CHECK(child.run());
    CHECK(holds_sample(store, id));
  }
}
#endif
