// The store of a script, its readers, views and second opens, and what the model says of them. A
// call is in the source that its kind names: opening, reading, changes, passes, subdivision.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "acceptance/random_calls/script.h"
#include "acceptance/random_calls/store_model.h"
#include "plait/error.h"
#include "plait/progress.h"
#include "plait/reader.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"

namespace plait::test {

/// The finest level that a call makes.
constexpr int kFinestOfScripts = 3;
/// Up to this budget a call may be refused because it has no room.
constexpr std::uint64_t kSmallBudget = 256 << 10;

/// What is wrong.
struct Wrong : std::runtime_error {
  using std::runtime_error::runtime_error;
};
inline void require(bool right, const std::string& what) {
  if (!right) throw Wrong(what);
}
/// Each is thrown by a callback of the test.
struct Thrown : std::runtime_error {
  Thrown() : std::runtime_error("thrown by a callback") {}
};

/// Runs the calls of one script. Throws Wrong if the store does not do what the model says.
class Machine {
 public:
  explicit Machine(const Script& script, Outcomes* outcomes);

  void run(const Call& call);
  /// Compares all that is open with the model.
  void check();

 private:
  struct Seen {
    PatchView view;
    std::vector<std::pair<std::string, Bytes>> patches;
  };
  struct Kept {
    std::optional<Reader> reader;
    std::vector<Seen> views;
    const Content* content = nullptr;  ///< of the reader's store while it is open
    bool of_main = false;              ///< of the store that is open now
    bool holds_lock = false;           ///< of a writer that was dropped
  };
  struct Guest {
    Store store;
    Content content;
  };
  struct Kind {
    std::string backend, pipeline;
  };
  /// What a store has told: no event comes when the store, its readers and views are gone.
  struct Heard {
    std::atomic<std::uint64_t> opened = 0, committed = 0, last_version = 0;
    std::atomic<bool> is_over = false, was_late = false;
  };
  static const std::vector<Kind>& kinds();

  bool on_disk() const { return kind_.backend != "memory"; }
  std::filesystem::path path() const { return directory_.path() / "s.plait"; }
  void compare(const Store& store, const Content& content, const char* whose);
  /// Whom a store that is opened now tells what it does.
  StoreEvents listener();
  static void check_view(const Seen& seen);
  void count(bool done);
  std::uint64_t readers() const;
  /// These errors, and those that a small budget or levels that others are encoded from may give.
  std::set<ErrorCode> with_budget(std::set<ErrorCode> codes) const;

  /// The code of the call's error; nothing if it succeeds. The message is in message_.
  template <class F>
  std::optional<ErrorCode> code_of_call(F&& call);
  /// A call that changes the store. Returns whether it succeeded; it must, unless the state of the
  /// store forbids it, or its error is one of `also`.
  template <class F>
  bool change(F&& call, const std::set<ErrorCode>& also = {});

  // opening.cpp
  void create();
  bool is_locked() const;
  void open(std::uint32_t how);
  void forget_main(bool dropped);
  void close();
  /// The destructor with readers and views, which keep what they need.
  void drop();
  void guest();
  void leave(std::uint32_t a);
  void second_writer();
  /// A store that was moved from refuses each call, and can be assigned to.
  void gone();

  // reading.cpp
  void check_reader(const Reader& reader);
  void reader();
  void view(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void release(std::uint32_t a);
  /// A walk over patches: while it has a patch pinned, the store refuses to take what is pinned,
  /// and other calls move nothing.
  void walk(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void call_beside_pins(AttributeId pinned, std::uint32_t which);
  void compare_digest();
  void check_blocks();

  // changes.cpp
  void append_level(Content::Attribute& attribute) const;
  std::optional<AttributeId> any_attribute(std::uint32_t a) const;
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void add_level(std::uint32_t a);
  void remove(std::uint32_t a);
  void replace(std::uint32_t a, std::uint32_t b);
  void write_base(std::uint32_t a, std::uint32_t b);
  void face(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void text(std::uint32_t a, std::uint32_t b);
  void recode(std::uint32_t a, std::uint32_t b);
  void commit();
  void roll_back();

  // passes.cpp
  /// A callback that calls back: what would take the ground of the pass refuses, the rest works.
  void call_back(std::uint32_t which);
  /// A callback for progress that ends the work as `how` says: 0 lets it run, 1 cancels, 2 throws,
  /// 3 calls back. `after` calls.
  ProgressCallback watcher(std::uint32_t how, std::uint32_t after);
  void sweep_over(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Every vertex of an attribute; the kernel throws at a level, at the base vertices, or never.
  void visit(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// A PatchWriter that is finished, or ends with some patches written or none.
  void write_patches(std::uint32_t a, std::uint32_t b, std::uint32_t c);

  // subdivision.cpp
  void refine(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  static void check_others_kept(const Content& before, const Content& after);
  static void check_made(Content& after, Content& expected);
  std::optional<Content> expected_of(SubdivideOptions plain, bool commits_levels,
                                     std::set<ErrorCode>& also);
  void take_over_commit();

  TemporaryDirectory directory_{Medium::kMemory};
  const BaseMesh& base_;
  Kind kind_;
  std::uint64_t budget_;
  ParallelFor pool_;               ///< of the test's own threads; empty in half of the scripts
  std::optional<int> io_threads_;  ///< 0 or the default
  std::shared_ptr<Heard> heard_;   ///< of the store that is open now
  std::vector<std::shared_ptr<Heard>> all_heard_;
  Outcomes* outcomes_;
  bool coded_ = false;  ///< some levels are encoded from others, so they may refuse changes

  std::optional<Store> store_;
  bool writable_ = true;
  Content now_, committed_;
  std::uint64_t sequence_ = 0;
  bool unknown_commit_ = false;
  std::vector<Guest> guests_;
  std::vector<Kept> kept_;
  std::uint32_t pokes_ = 0;
  std::string message_, current_;
};

template <class F>
std::optional<ErrorCode> Machine::code_of_call(F&& call) {
  try {
    call();
  } catch (const Error& error) {
    message_ = error.what();
    require(!message_.empty() && message_.find('\n') == std::string::npos,
            "a message of several lines: " + message_);
    count(false);
    return error.code();
  } catch (const Thrown&) {
    message_ = "Thrown";
    count(false);
    return ErrorCode::kCancelled;  // what a callback throws comes out as it is
  }
  count(true);
  return std::nullopt;
}

template <class F>
bool Machine::change(F&& call, const std::set<ErrorCode>& also) {
  const std::optional<ErrorCode> code = code_of_call(call);
  const bool may_not = !writable_ || readers() > 0;
  if (!code) {
    require(!may_not, "a change succeeded although the store is read-only or has readers");
    return true;
  }
  const ErrorCode state = !writable_ ? ErrorCode::kBadState : ErrorCode::kBusy;
  require((may_not && *code == state) || also.contains(*code),
          "unexpected " + std::string(to_string(*code)) + ": " + message_);
  return false;
}

}  // namespace plait::test
