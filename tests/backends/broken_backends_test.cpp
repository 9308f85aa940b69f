// The conformance suite finds what is broken: backends with one mistake each, and the promise that
// each of them breaks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "conformance/suite.h"
#include "durability/faults.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "support/counting_backend.h"
#include "support/forwarding_backend.h"

namespace plait::test {
namespace {

/// What a broken backend does otherwise than the one that it forwards to.
struct Mistake {
  bool ignores_errors = false;     ///< of read() and write()
  bool keeps_unwritten = false;    ///< a block that was never written is left as it is
  bool loses_third_block = false;  ///< write() does nothing for block 3
  bool keeps_old_content = false;  ///< write() of a block that was written does nothing
  bool advice_clears = false;      ///< kDontNeed fills the blocks with zeros
  bool ends_twice = false;         ///< the listener is called twice
  bool creates_missing = false;    ///< a file that is opened for reading is made
  bool long_messages = false;      ///< a message has two lines
  bool needs_itself = false;       ///< a block needs itself
  bool moves = false;              ///< address() differs from call to call
  bool begins_at_zero = false;     ///< a level in a shared file
};

class BrokenBackend final : public ForwardingBackend {
 public:
  BrokenBackend(std::unique_ptr<Backend> inner, const LevelSpec& level, const Mistake& mistake)
      : ForwardingBackend(std::move(inner)),
        table_(level.table),
        geometry_(level.geometry),
        mistake_(mistake) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    const bool unwritten = blocks.count == 1 && blocks.first < table_.size() &&
                           table_[blocks.first].encoding == BlockEncoding::kNeverWritten;
    if (mistake_.keeps_unwritten && (unwritten || into.size() == geometry_.total_bytes())) return;
    guarded([&] { inner().read(blocks, into); });
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (mistake_.loses_third_block && blocks.first == 3) return;
    if (mistake_.keeps_old_content && blocks.first < table_.size() &&
        table_[blocks.first].encoding != BlockEncoding::kNeverWritten)
      return;
    guarded([&] { inner().write(blocks, from); });
  }
  void start(Transfer& transfer) noexcept override {
    TransferListener& listener = *transfer.listener;
    ForwardingBackend::start(transfer);
    if (mistake_.ends_twice) listener.finished(transfer, nullptr);
  }
  void advise(BlockRange blocks, Advice advice) noexcept override {
    if (mistake_.advice_clears && advice == Advice::kDontNeed && blocks.count == 1 &&
        blocks.first < table_.size())
      inner().write(blocks, std::vector<std::byte>(geometry_.block_bytes(blocks.first)));
    inner().advise(blocks, advice);
  }
  std::byte* address(std::uint64_t block) override {
    std::byte* const first = inner().address(block);
    return first != nullptr && mistake_.moves ? first + ++calls_ : first;
  }
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    if (!mistake_.needs_itself) return 0;
    blocks[0] = {table_.attribute(), table_.level(), block};
    return 1;
  }

 private:
  template <class Call>
  void guarded(const Call& call) const {
    try {
      call();
    } catch (const Error& error) {
      if (mistake_.ignores_errors) return;
      if (mistake_.long_messages) throw Error(error.code(), std::string("first\n") + error.what());
      throw;
    }
  }

  BlockTable& table_;
  const LevelGeometry& geometry_;
  const Mistake& mistake_;
  std::ptrdiff_t calls_ = 0;
};

RegisteredBackend broken(const char* name, const Mistake& mistake) {
  RegisteredBackend entry = default_backends().find(name);
  entry.open = wrapped_volume(entry.open, [&mistake](Volume& inner, const LevelSpec& level) {
    if (mistake.creates_missing && level.mode == OpenMode::kRead &&
        !level.directory.contains(level.name))
      File(level.directory, level.name, OpenMode::kCreate);
    LevelSpec opened = level;
    if (mistake.begins_at_zero) opened.first_byte = 0;
    return std::make_unique<BrokenBackend>(inner.open_level(opened), level, mistake);
  });
  return entry;
}

/// The names of the promises that the backend breaks.
std::vector<std::string> broken_promises(const RegisteredBackend& entry) {
  std::vector<std::string> names;
  const conformance::Subject subject{"broken", entry};
  for (const conformance::Promise& promise : conformance::promises())
    if (promise.concerns(entry.traits)) {
      const NoWaiting no_waiting;
      if (!conformance::check(promise, subject).held()) names.emplace_back(promise.name);
    }
  return names;
}

bool has(const std::vector<std::string>& names, const char* name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

TEST_CASE("Conformance_BackendWithOneMistake_NamesThePromiseThatItBreaks") {
  struct Case {
    Mistake mistake;
    const char* backend;
    std::vector<const char*> promises;
  };
  const std::vector<Case> cases = {
      {{.ignores_errors = true},
       "pread",
       {"request-in-bounds", "read-only-level", "flipped-bit", "swapped-blocks",
        "transfer-of-damaged-block", "file-cut-while-open", "failed-write"}},
      {{.ignores_errors = true}, "mmap", {"address-mapped"}},
      {{.keeps_unwritten = true}, "memory", {"read-never-written"}},
      {{.loses_third_block = true},
       "pread",
       {"read-what-was-written", "transfers-end-once", "write-over-old-content"}},
      {{.keeps_old_content = true}, "pread", {"write-over-old-content", "reopened-level"}},
      {{.advice_clears = true}, "pread", {"advice-changes-nothing"}},
      {{.ends_twice = true}, "pread", {"transfers-end-once", "transfer-of-damaged-block"}},
      {{.creates_missing = true}, "pread", {"open-modes"}},
      {{.long_messages = true}, "pread", {"request-in-bounds"}},
      {{.needs_itself = true}, "memory", {"context-is-stable"}},
      {{.moves = true}, "memory", {"address-in-memory"}},
      {{.begins_at_zero = true}, "pread", {"shared-file"}}};
  for (const Case& one : cases) {
    const std::vector<std::string> found = broken_promises(broken(one.backend, one.mistake));
    CAPTURE(one.backend, one.promises, found);
    for (const char* const promise : one.promises) CHECK(has(found, promise));
    CHECK(found.size() < conformance::promises().size());
  }
}

TEST_CASE("Conformance_EntryThatSaysOtherwise_BreaksEntryAgrees") {
  RegisteredBackend entry = default_backends().find("pread");
  entry.traits.overwrites_in_place = false;
  CHECK(has(broken_promises(entry), "entry-agrees"));
  entry = default_backends().find("memory");
  entry.traits.in_memory = false;
  CHECK(has(broken_promises(entry), "entry-agrees"));
}

TEST_CASE("Conformance_BackendThatThrowsAnything_IsAFinding") {
  RegisteredBackend entry = default_backends().find("pread");
  entry.open = [](const VolumeSpec&) -> std::unique_ptr<Volume> { throw 7; };
  CHECK(broken_promises(entry).size() > 15);
}

TEST_CASE("CheckLog_ManyOfThem_AreCountedAndTheFirstAreKept") {
  conformance::CheckLog log;
  for (int count = 0; count < 1000; ++count) {
    log.at("number " + std::to_string(count / 4));
    log.expect(count % 2 == 0, "it is even");
  }
  CHECK_FALSE(log.held());
  CHECK(log.broken_count() == 500);
  REQUIRE(log.broken().size() == 10);
  CHECK(log.broken()[0] == "it is even (number 0)");
  CHECK(log.broken()[1] == "it is even (number 1)");
}

}  // namespace plait::test
