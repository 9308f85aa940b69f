#include "acceptance/random_calls.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "acceptance/store_model.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

constexpr int kFinest = 3;
constexpr std::uint64_t kBudgets[] = {64 << 10, 256 << 10, 16 << 20};
/// Each is thrown by a callback of the test.
struct Thrown : std::runtime_error {
  Thrown() : std::runtime_error("thrown by a callback") {}
};
/// What is wrong.
struct Wrong : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void require(bool right, const std::string& what) {
  if (!right) throw Wrong(what);
}

struct Kind {
  std::string backend, pipeline;
};
const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = [] {
    std::vector<Kind> found;
    for (const std::string& backend : usable_backends())
      if (backend == "compressed")
        for (const char* pipeline :
             {"shuffle,lz4", "zstd:1", "hierarchy,zstd:1", "predicted,zstd:1"})
          found.push_back({backend, pipeline});
      else
        found.push_back({backend, "none"});
    return found;
  }();
  return all;
}

const BaseMesh& mesh_number(std::uint32_t number) {
  static const std::array<BaseMesh, 3> meshes = {BaseMesh::build(sheet(6, 5)),
                                                 BaseMesh::build(random_torus(2, 20)),
                                                 BaseMesh::build(tetrahedron())};
  return meshes[number % meshes.size()];
}

const std::vector<AttributeSchema>& schemas() {
  static const std::vector<AttributeSchema> all = {{"", ComponentType::kUint8, 5},
                                                   {"", ComponentType::kFloat32, 3},
                                                   {"", ComponentType::kUint16, 1}};
  return all;
}

constexpr std::array kNames = {"add",    "level",     "remove",    "replace", "sweep",  "sweep",
                               "sweep",  "subdivide", "subdivide", "commit",  "commit", "roll_back",
                               "close",  "drop",      "open",      "open",    "guest",  "leave",
                               "reader", "view",      "release",   "base",    "face",   "text",
                               "digest", "verify",    "recode",    "busy",    "gone"};

class Machine {
 public:
  explicit Machine(const Script& script, Outcomes* outcomes)
      : base_(mesh_number(script.begin.mesh)),
        kind_(kinds()[script.begin.backend % kinds().size()]),
        budget_(kBudgets[script.begin.budget % std::size(kBudgets)]),
        outcomes_(outcomes) {
    coded_ = kind_.pipeline.starts_with("hierarchy") || kind_.pipeline.starts_with("predicted");
    create();
  }

  void run(const Call& call) {
    const std::string& name = call.name;
    const auto a = call.a, b = call.b, c = call.c;
    if (name == "open") return open(a);
    if (name == "guest") return guest();
    if (name == "leave") return leave(a);
    if (name == "release") return release(a);
    if (name == "view") return view(a, b, c);
    if (name == "gone") return gone();
    if (!store_) return;
    if (name == "add") add(a, b, c);
    if (name == "level") add_level(a);
    if (name == "remove") remove(a);
    if (name == "replace") replace(a, b);
    if (name == "sweep") sweep_over(a, b, c);
    if (name == "subdivide") refine(a, b, c);
    if (name == "commit") commit();
    if (name == "roll_back") roll_back();
    if (name == "close") close();
    if (name == "drop") drop();
    if (name == "reader") reader(a);
    if (name == "base") write_base(a, b);
    if (name == "face") face(a, b, c);
    if (name == "text") text(a, b);
    if (name == "digest") compare_digest();
    if (name == "verify") check_blocks();
    if (name == "recode") recode(a, b);
    if (name == "busy") second_writer();
  }

  void check() {
    if (store_) compare(*store_, now_, "the store");
    for (const Guest& guest : guests_) compare(guest.store, guest.content, "a guest");
    for (const Kept& kept : kept_)
      for (const Seen& seen : kept.views) check_view(seen);
  }

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

  bool on_disk() const { return kind_.backend != "memory"; }
  std::filesystem::path path() const { return directory_.path() / "s.plait"; }

  void compare(const Store& store, const Content& content, const char* whose) {
    std::string wrong;
    try {
      wrong = difference(store, content);
    } catch (const Error& error) {
      wrong = error.what();
    }
    // The smallest budgets may have no room beside views.
    if (budget_ <= kBudgets[1] && wrong.find("available") != std::string::npos) return;
    require(wrong.empty(), fmt::format("{}: {}", whose, wrong));
  }

  void check_view(const Seen& seen) {
    for (const auto& [name, expected] : seen.patches) {
      Bytes found(expected.size());
      seen.view.records(name).copy_to(found);
      require(found == expected, fmt::format("a view of '{}' shows other records", name));
    }
  }

  // Errors ----------------------------------------------------------------------------------------

  template <class F>
  std::optional<ErrorCode> code_of_call(F&& call) {
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

  void count(bool done) {
    if (outcomes_ == nullptr) return;
    ++(done ? outcomes_->of(current_).done : outcomes_->of(current_).refused);
  }

  std::uint64_t readers() const {
    return static_cast<std::uint64_t>(
        std::ranges::count_if(kept_, [](const Kept& kept) { return kept.of_main; }));
  }

  /// A call that changes the store. Returns whether it succeeded; it must, unless the state of the
  /// store forbids it, or its error is one of `also`.
  template <class F>
  bool change(F&& call, const std::set<ErrorCode>& also = {}) {
    const std::optional<ErrorCode> code = code_of_call(call);
    const bool may_not = !writable_ || readers() > 0;
    if (!code) {
      require(!may_not, "a change succeeded although the store is read-only or has readers");
      return true;
    }
    const ErrorCode state = !writable_ ? ErrorCode::kBadState : ErrorCode::kBusy;
    require((may_not && *code == state) || also.contains(*code),
            fmt::format("unexpected {}: {}", to_string(*code), message_));
    return false;
  }

  std::set<ErrorCode> with_budget(std::set<ErrorCode> codes) const {
    if (budget_ <= kBudgets[1]) codes.insert(ErrorCode::kBudget);
    if (coded_) codes.insert(ErrorCode::kBadState);
    return codes;
  }

  // Opening and closing ---------------------------------------------------------------------------

  void create() {
    StoreOptions options;
    options.backend = kind_.backend;
    options.pipeline = kind_.pipeline;
    options.block_bytes = 4096;
    options.budget_bytes = budget_;
    options.durability = Durability::kNone;
    store_ = Store::create(on_disk() ? path() : std::filesystem::path(), base_, options,
                           default_backends());
    writable_ = true;
    add_base_positions(*store_);
    now_ = content_of(*store_);
    committed_ = {};
    committed_.provenance = now_.provenance;
    sequence_ = 0;
    pure_ = true;
    restart_from_.reset();
  }

  bool is_locked() const {
    return std::ranges::any_of(kept_, [](const Kept& kept) { return kept.holds_lock; });
  }

  void open(std::uint32_t how) {
    if (store_) return;
    if (!on_disk() || sequence_ == 0) {
      if (on_disk() && !kept_.empty()) return;
      guests_.clear();
      if (!on_disk()) kept_.clear();
      return create();
    }
    OpenOptions options;
    options.writable = how % 4 != 0;
    options.budget_bytes = budget_;
    options.durability = Durability::kNone;
    std::optional<Store> opened;
    const auto code =
        code_of_call([&] { opened = Store::open(path(), options, default_backends()); });
    if (code) {
      require(options.writable && is_locked() && *code == ErrorCode::kBusy, message_);
      return;
    }
    require(!(options.writable && is_locked()), "two writers have the store open");
    store_ = std::move(opened);
    writable_ = options.writable;
    now_ = committed_;
    now_.provenance = store_->provenance();
    pure_ = false;
    restart_from_.reset();
  }

  void forget_main(bool dropped) {
    for (Kept& kept : kept_) {
      if (!kept.of_main) continue;
      kept.of_main = false;
      kept.content = nullptr;
      kept.holds_lock = dropped && writable_;
    }
  }

  void close() {
    const auto code = code_of_call([&] { store_->close(); });
    require(readers() > 0 ? code == ErrorCode::kBusy : !code, "close: " + message_);
    if (code) return;
    require(code_of_call([&] { store_->commit(); }) == ErrorCode::kBadState,
            "a closed store commits");
    require(code_of_call([&] { Reader reader(*store_); }) == ErrorCode::kBadState,
            "a closed store has a reader");
    require(!code_of_call([&] { store_->close(); }), "a second close fails");
    store_.reset();
  }

  /// The destructor with readers and views, which keep what they need.
  void drop() {
    if (on_disk() && sequence_ == 0 && readers() > 0) return;
    for (const Kept& kept : kept_)
      if (kept.of_main && kept.reader) check_reader(*kept.reader);
    store_.reset();
    forget_main(true);
  }

  void guest() {
    if (!on_disk() || sequence_ == 0 || guests_.size() >= 2) return;
    Store opened = Store::open(path(), {}, default_backends());
    compare(opened, committed_, "a second open");
    guests_.push_back({std::move(opened), committed_});
  }

  void leave(std::uint32_t a) {
    if (guests_.empty()) return;
    guests_.erase(guests_.begin() + static_cast<std::ptrdiff_t>(a % guests_.size()));
  }

  void second_writer() {
    if (!on_disk() || sequence_ == 0 || !writable_) return;
    const auto code = code_of_call([&] {
      Store::open(path(), {.writable = true, .durability = Durability::kNone}, default_backends());
    });
    require(code == ErrorCode::kBusy, "a second writer: " + message_);
  }

  /// A store that was moved from refuses each call, and can be assigned to.
  void gone() {
    if (!store_) return;
    Store elsewhere = std::move(*store_);
    const auto refuses = [&](const auto& call) {
      require(code_of_call(call) == ErrorCode::kBadState, "a store that was moved from works");
    };
    refuses([&] { store_->attributes(); });
    refuses([&] { store_->commit(); });
    refuses([&] { store_->statistics(); });
    refuses([&] { digest(*store_); });
    *store_ = std::move(elsewhere);
  }

  // Readers and views -----------------------------------------------------------------------------

  void check_reader(const Reader& reader) {
    if (!now_.attributes.empty() && now_.is_finished())
      code_of_call([&] { reader.read_patch(0, 0); });
  }

  void reader(std::uint32_t) {
    if (kept_.size() >= 3) return;
    Kept kept;
    kept.reader.emplace(*store_);
    kept.content = &now_;
    kept.of_main = true;
    kept_.push_back(std::move(kept));
  }

  void view(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (kept_.empty()) return;
    Kept& kept = kept_[a % kept_.size()];
    if (!kept.reader || !kept.content || kept.views.size() >= 3) return;
    const Content& content = *kept.content;
    if (content.attributes.empty()) return;
    const auto face = static_cast<FaceId>(b % base_.face_count());
    int finest = kFinest + 1;
    for (const auto& attribute : content.attributes) finest = std::min(finest, attribute.finest());
    const int level = static_cast<int>(c % static_cast<std::uint32_t>(finest + 1));
    bool finished = true;
    for (const auto& attribute : content.attributes)
      for (int at = 0; at < level; ++at)
        finished = finished && attribute.levels[static_cast<std::size_t>(at)].finished;
    if (c % 5 == 0) {
      kept.reader->prefetch(std::array{face, FaceId{0}}, level);
      if (c % 2 == 0) kept.reader->end_prefetch();
    }
    std::optional<PatchView> patch;
    const auto code = code_of_call([&] { patch = kept.reader->read_patch(face, level); });
    if (code) {
      require((!finished && *code == ErrorCode::kBadState) || with_budget({}).contains(*code),
              "read a patch: " + message_);
      return;
    }
    require(finished, "a view shows an unfinished level");
    Seen seen{std::move(*patch), {}};
    for (const auto& attribute : content.attributes)
      seen.patches.emplace_back(attribute.schema.name, patch_of(base_, attribute, face, level));
    check_view(seen);
    kept.views.push_back(std::move(seen));
  }

  void release(std::uint32_t a) {
    if (kept_.empty()) return;
    const auto at = kept_.begin() + static_cast<std::ptrdiff_t>(a % kept_.size());
    if (a % 2 == 0 && !at->views.empty()) {
      at->reader.reset();  // the views stay
      at->views.pop_back();
      if (!at->views.empty()) return;
    }
    kept_.erase(at);
  }

  // Changes ---------------------------------------------------------------------------------------

  void touched(std::string_view attribute = {}) {
    if (attribute == "position") pure_ = false;
    restart_from_.reset();
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    AttributeSchema schema = schemas()[b % schemas().size()];
    schema.name = fmt::format("n{}", a % 4);
    const int finest = static_cast<int>(c % 3);
    const bool taken = now_.find(schema.name) != nullptr;
    std::set<ErrorCode> also;
    if (taken) also.insert(ErrorCode::kInvalidArgument);
    // The filter takes floats only.
    if (kind_.pipeline.starts_with("hierarchy") && schema.type != ComponentType::kFloat32)
      also.insert(ErrorCode::kNotSupported);
    if (!change([&] { store_->add_attribute(schema, finest); }, also)) return;
    require(!taken, "two attributes of one name");
    Content::Attribute attribute;
    attribute.schema = schema;
    attribute.base.resize(base_.vertex_count() * schema.record_bytes());
    now_.attributes.push_back(std::move(attribute));
    for (int level = 1; level <= finest; ++level) append_level(now_.attributes.back());
    touched();
  }

  void append_level(Content::Attribute& attribute) {
    const auto bytes = base_
                           .geometry(relative_to_base(attribute.finest() + 1, 0),
                                     attribute.schema.record_bytes(), 4096)
                           .total_bytes();
    attribute.levels.push_back({Bytes(bytes), true});
  }

  std::optional<AttributeId> any_attribute(std::uint32_t a) const {
    if (now_.attributes.empty()) return std::nullopt;
    return static_cast<AttributeId>(a % now_.attributes.size());
  }

  void add_level(std::uint32_t a) {
    const auto id = any_attribute(a);
    if (!id || now_.attributes[*id].finest() >= kFinest) return;
    if (!change([&] { store_->add_level(*id); })) return;
    append_level(now_.attributes[*id]);
    touched(now_.attributes[*id].schema.name);
  }

  void remove(std::uint32_t a) {
    const auto id = any_attribute(a);
    if (!id || (a % 8 != 0 && now_.attributes[*id].schema.name == "position")) return;
    if (!change([&] { store_->remove_attribute(*id); }, with_budget({}))) return;
    touched(now_.attributes[*id].schema.name);
    now_.attributes.erase(now_.attributes.begin() + *id);
  }

  void replace(std::uint32_t a, std::uint32_t b) {
    const auto old = any_attribute(a), by = any_attribute(b);
    if (!old || !by) return;
    const bool same_type = now_.attributes[*old].schema.type == now_.attributes[*by].schema.type;
    std::set<ErrorCode> also = with_budget({});
    const bool of_scheme =
        now_.attributes[*old].schema.name == "position" && !store_->provenance().scheme.empty();
    if (*old == *by || (of_scheme && !same_type)) also.insert(ErrorCode::kInvalidArgument);
    if (!change([&] { store_->replace_attribute(*old, *by); }, also)) return;
    require(*old != *by && !(of_scheme && !same_type), "a wrong replacement");
    touched("position");
    std::string name = now_.attributes[*old].schema.name;
    now_.attributes[*old] = now_.attributes[*by];
    now_.attributes[*old].schema.name = std::move(name);
    now_.attributes.erase(now_.attributes.begin() + *by);
  }

  void write_base(std::uint32_t a, std::uint32_t b) {
    const auto id = any_attribute(a);
    if (!id) return;
    Content::Attribute& attribute = now_.attributes[*id];
    Bytes bytes(attribute.base.size());
    fill_pattern(attribute.schema, b, 0, bytes);
    if (!change([&] { std::ranges::copy(bytes, store_->base_bytes(*id).begin()); },
                with_budget({})))
      return;
    if (attribute.finest() > 0) touched(attribute.schema.name);
    restart_from_.reset();
    attribute.base = std::move(bytes);
  }

  void face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::string name = fmt::format("f{}", a % 2);
    const auto found = std::ranges::find_if(
        now_.face_attributes, [&](const auto& each) { return each.schema.name == name; });
    if (found == now_.face_attributes.end()) {
      const AttributeSchema schema{name,
                                   b % 2 == 0 ? ComponentType::kUint8 : ComponentType::kUint32, 1};
      if (!change([&] { store_->add_face_attribute(schema); })) return;
      now_.face_attributes.push_back({schema, Bytes(base_.face_count() * schema.record_bytes())});
    } else if (c % 3 == 0) {
      if (!change([&] { store_->remove_face_attribute(name); })) return;
      now_.face_attributes.erase(found);
    } else {
      Bytes numbers(found->numbers.size());
      fill_pattern(found->schema, b, 0, numbers);
      if (!change([&] { std::ranges::copy(numbers, store_->face_bytes(name).begin()); })) return;
      found->numbers = std::move(numbers);
    }
    restart_from_.reset();
  }

  void text(std::uint32_t a, std::uint32_t b) {
    const std::string name = fmt::format("t{}", a % 3), text(b % 5, 'x');
    if (!change([&] { store_->set_text(name, text); })) return;
    now_.texts.erase(name);
    if (!text.empty()) now_.texts[name] = text;
    restart_from_.reset();
  }

  void recode(std::uint32_t a, std::uint32_t b) {
    const auto id = any_attribute(a);
    if (!id || kind_.backend != "compressed") return;
    static constexpr std::array kPipelines = {"lz4", "shuffle,zstd:1", "hierarchy,lz4"};
    std::set<ErrorCode> also = with_budget({});
    also.insert(ErrorCode::kBadState);
    const AttributeSchema& schema = now_.attributes[*id].schema;
    if (schema.type != ComponentType::kFloat32)
      also.insert({ErrorCode::kInvalidArgument, ErrorCode::kNotSupported});
    const char* const pipeline = kPipelines[b % kPipelines.size()];
    if (!change([&] { recode_attribute(*store_, *id, LevelPipelines(pipeline)); }, also)) return;
    coded_ = coded_ || pipeline[0] == 'h';
    restart_from_.reset();
    require(now_.attributes[*id].is_finished(), "recode read an unfinished level");
  }

  // Passes ----------------------------------------------------------------------------------------

  /// A callback that calls back: what would take the ground of the pass refuses, the rest works.
  void call_back(std::uint32_t which) {
    Store& store = *store_;
    const auto refuses = [&](const std::string& what, const auto& call) {
      try {
        call();
      } catch (const Error& error) {
        // What subdivide() is asked for is checked first.
        require(error.code() == ErrorCode::kBadState || error.code() == ErrorCode::kBusy ||
                    what == "subdivide",
                fmt::format("{} in a callback: {}", what, error.what()));
        return;
      }
      throw Wrong(fmt::format("{} works in a callback", what));
    };
    switch (which % 10) {
      case 0:
        return refuses("close", [&] { store.close(); });
      case 1:
        return refuses("roll_back", [&] { store.roll_back(); });
      case 2:
        return refuses("commit", [&] { store.commit(); });
      case 3:
        return refuses("remove_attribute", [&] { store.remove_attribute(0); });
      case 4:
        return refuses("add_attribute", [&] {
          store.add_attribute({"callback", ComponentType::kUint8, 1});
        });
      case 5:
        return refuses("base_bytes", [&] { store.base_bytes(0); });
      case 6:
        return refuses("subdivide", [&] { subdivide(store, {.levels = kFinest}); });
      case 7:
        return refuses("set_text", [&] { store.set_text("t", "x"); });
      case 8:
        std::as_const(store).base_bytes(0);
        store.attributes();
        store.statistics();
        return;
      default:
        // Levels of which the pass makes none can be read.
        try {
          const Reader reader(store);
          reader.read_patch(0, 0);
        } catch (const Error& error) {
          require(error.code() == ErrorCode::kBudget || error.code() == ErrorCode::kBadState,
                  error.what());
        }
    }
  }

  /// A callback for progress that ends the work as `how` says: 0 lets it run, 1 cancels, 2 throws,
  /// 3 calls back. `after` calls.
  ProgressCallback watcher(std::uint32_t how, std::uint32_t after) {
    return [this, how, left = after](const Progress&) mutable {
      if (left > 0) {
        --left;
        return true;
      }
      if (how == 1) return false;
      if (how == 2) throw Thrown();
      if (how == 3) call_back(pokes_++);
      return true;
    };
  }

  void sweep_over(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto id = any_attribute(a);
    if (!id || now_.attributes[*id].levels.empty()) return;
    Content::Attribute& attribute = now_.attributes[*id];
    const int level = 1 + static_cast<int>(b % attribute.levels.size());
    Content::Level& of = attribute.levels[static_cast<std::size_t>(level - 1)];
    const bool overwrites = c % 2 == 0;
    const std::uint32_t how = c / 2 % 4;
    const std::size_t record_bytes = attribute.schema.record_bytes();
    const LevelGeometry geometry = base_.geometry(relative_to_base(level, 0), record_bytes, 4096);
    SweepPass pass{
        "random",
        {{*id, level, level, overwrites ? Access::kOverwrite : Access::kUpdate, Reach::kOwn}},
        [&](const SweepView& view, EdgeId edge, int) {
          const std::span<std::byte> bytes = view.slot(0, level, edge).bytes;
          if (overwrites)
            fill_pattern(attribute.schema, b, geometry.slot(edge).offset, bytes);
          else
            change_pattern(attribute.schema, bytes);
        }};
    SweepOptions options;
    options.threads = 1 + static_cast<int>(c / 8 % 2);
    options.progress = watcher(how, c / 16 % 2);
    std::set<ErrorCode> also = with_budget({});
    if (!overwrites && !of.finished) also.insert(ErrorCode::kBadState);
    if (how == 1) also.insert(ErrorCode::kCancelled);
    if (how == 2) also.insert(ErrorCode::kCancelled);
    const bool done = change([&] { sweep(*store_, pass, options); }, also);
    if (done || message_ == "Thrown" || message_.find("cancelled") != std::string::npos)
      touched(attribute.schema.name);
    if (done) {
      require(overwrites || of.finished, "an update of an unfinished level succeeded");
      if (overwrites)
        fill_pattern(attribute.schema, b, 0, of.bytes);
      else
        change_pattern(attribute.schema, of.bytes);
      of.finished = true;
    } else if (!StoreAccess::level_file(std::as_const(*store_), *id, level).is_finished()) {
      of.finished = false;
    }
    if (done && how == 2) require(c / 16 % 2 > 0, "what a callback throws does not come out");
  }

  void refine(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (now_.find("position") == nullptr) return;
    SubdivideOptions what;
    what.levels = static_cast<int>(a % (kFinest + 1));
    what.normals = b % 2 == 0;
    what.limit = b / 2 % 4 == 0;
    what.executor = static_cast<ExecutorKind>(b / 8 % 4);
    what.scheme =
        std::array<Scheme, 3>{Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint}[a / 4 % 3];
    what.threads = 1 + static_cast<int>(a / 16 % 2);
    const std::uint32_t how = c % 5;  // 4: commits each level
    bool committed = false;
    SubdivideOptions watched = what;
    if (how < 4) watched.progress = watcher(how, c / 5 % 6);
    if (how == 4)
      watched.level_done = [&](int) {
        // Other attributes may be unfinished; then nothing is committed.
        try {
          store_->commit();
          committed = true;
        } catch (const Error& error) {
          require(error.code() == ErrorCode::kBadState, error.what());
        }
      };

    // What the same call does to a store in memory with the same content. After a cancelled call,
    // that of before it.
    std::optional<Content> expected;
    std::set<ErrorCode> also = with_budget({ErrorCode::kBadState});
    const Content from = restart_from_.value_or(now_);
    if (from.is_finished() && (pure_ || !restart_from_)) {
      Store reference = loaded(base_, from);
      SubdivideOptions plain = what;
      if (how == 4 && plain.executor == ExecutorKind::kAuto) plain.executor = ExecutorKind::kSweep;
      try {
        subdivide(reference, plain);
        expected = content_of(reference);
      } catch (const Error& error) {
        also.insert(error.code());
      }
    } else {
      also.insert({ErrorCode::kInvalidArgument, ErrorCode::kNotSupported});
    }
    // The fused executor does not go on from levels. An unfinished start has none.
    also.insert(ErrorCode::kNotSupported);
    // Normals that a cancelled call has left do not fit, and are not made anew.
    if (now_.find("normal") != nullptr && !what.normals) also.insert(ErrorCode::kInvalidArgument);
    if (how == 1) also.insert(ErrorCode::kCancelled);
    if (how == 2) also.insert(ErrorCode::kCancelled);
    const Content before = now_;
    const bool done = change([&] { subdivide(*store_, watched); }, also);
    const std::string message = message_;
    if (committed) {
      sequence_ = store_->sequence();
      const std::uint64_t at = sequence_;
      require(at > 0, "a commit without a version");
    }
    Content after = content_of(*store_);
    for (const Content::Attribute& attribute : before.attributes) {
      if (attribute.schema.name == "position" || attribute.schema.name == "normal") continue;
      if (!attribute.is_finished()) continue;
      const Content::Attribute* const same = after.find(attribute.schema.name);
      require(same != nullptr && same->levels.size() == attribute.levels.size() &&
                  same->base == attribute.base,
              fmt::format("subdivide has changed '{}'", attribute.schema.name));
      for (std::size_t level = 0; level < attribute.levels.size(); ++level)
        require(same->levels[level].bytes == attribute.levels[level].bytes,
                fmt::format("subdivide has changed '{}'", attribute.schema.name));
    }
    if (done) {
      for (const Content::Attribute& attribute : after.attributes)
        require(attribute.is_finished() ||
                    (attribute.schema.name != "position" && attribute.schema.name != "normal") ||
                    !before.is_finished(),
                "subdivide has left a level unfinished: " + attribute.schema.name);
      if (expected) {
        for (const char* name : {"position", "normal"}) {
          const Content::Attribute *found = after.find(name), *right = expected->find(name);
          require((found == nullptr) == (right == nullptr),
                  fmt::format("subdivide: attribute '{}'", name));
          if (found == nullptr) continue;
          require(found->base == right->base && found->levels.size() == right->levels.size(),
                  fmt::format("subdivide: base records or levels of '{}'", name));
          for (std::size_t level = 0; level < right->levels.size(); ++level)
            require(found->levels[level].bytes == right->levels[level].bytes,
                    fmt::format("subdivide: level {} of '{}'", level + 1, name));
        }
      }
      restart_from_.reset();
      if (what.limit) pure_ = false;
    } else if (after == before && !committed) {
      // Refused before its first change.
    } else {
      require(message == "Thrown" || message.find("cancelled") != std::string::npos ||
                  with_budget({}).size() > 0 || committed,
              "a refused subdivide has changed the store: " + message);
      if (!restart_from_ && before.is_finished() && pure_ && !committed) restart_from_ = before;
      if (committed) pure_ = false;
    }
    now_ = std::move(after);
    if (committed) {
      // What exactly was committed is known only to the callback: the store says it.
      if (on_disk()) {
        Store seen = Store::open(path(), {}, default_backends());
        committed_ = content_of(seen);
      } else {
        unknown_commit_ = true;
      }
    }
  }

  // Commits ---------------------------------------------------------------------------------------

  void commit() {
    const bool finished = now_.is_finished();
    if (!change([&] { store_->commit(); },
                finished ? std::set<ErrorCode>{} : std::set{ErrorCode::kBadState}))
      return;
    require(finished, "an unfinished level was committed");
    const bool differs = sequence_ == 0 || !(now_ == committed_);
    const std::uint64_t found = store_->sequence();
    require(found == sequence_ + 1 || (found == sequence_ && !differs),
            fmt::format("version {} after version {}", found, sequence_));
    sequence_ = found;
    committed_ = now_;
    unknown_commit_ = false;
  }

  void roll_back() {
    if (!change([&] { store_->roll_back(); })) return;
    restart_from_.reset();
    pure_ = false;
    if (unknown_commit_) {
      now_ = content_of(*store_);
      require(now_.is_finished(), "rolled back to an unfinished level");
      committed_ = now_;
      unknown_commit_ = false;
      return;
    }
    const Provenance provenance = store_->provenance();
    now_ = sequence_ > 0 ? committed_ : Content();
    now_.provenance = provenance;
  }

  void compare_digest() {
    const bool finished = now_.is_finished();
    std::optional<Digest> found;
    const auto code = code_of_call([&] { found = digest(std::as_const(*store_), {.threads = 2}); });
    if (code) {
      require((!finished && *code == ErrorCode::kBadState) || with_budget({}).contains(*code),
              "digest: " + message_);
      return;
    }
    require(finished, "a digest of an unfinished level");
    require(*found == digest(loaded(base_, now_)), "another digest");
  }

  void check_blocks() {
    const auto code = code_of_call([&] {
      require(verify(std::as_const(*store_)).damaged_count == 0, "verify finds damaged blocks");
    });
    require(!code || with_budget({}).contains(*code), "verify: " + message_);
  }

  TemporaryDirectory directory_{Medium::kMemory};
  const BaseMesh& base_;
  Kind kind_;
  std::uint64_t budget_;
  Outcomes* outcomes_;
  bool coded_ = false;  ///< some levels are encoded from others, so they may refuse changes

  std::optional<Store> store_;
  bool writable_ = true;
  Content now_, committed_;
  std::uint64_t sequence_ = 0;
  bool unknown_commit_ = false;
  bool pure_ = true;  ///< the scheme alone has made the levels of "position" from its base records
  std::optional<Content> restart_from_;  ///< before a subdivision that did not end
  std::vector<Guest> guests_;
  std::vector<Kept> kept_;
  std::uint32_t pokes_ = 0;
  std::string message_;

 public:
  std::string current_;
};

}  // namespace

Outcomes::Counts& Outcomes::of(const std::string& name) {
  const auto found = std::ranges::find(calls, name, &std::pair<std::string, Counts>::first);
  if (found != calls.end()) return found->second;
  return calls.emplace_back(name, Counts()).second;
}

std::string to_text(const Script& script) {
  std::string text =
      fmt::format("begin {} {} {}", script.begin.backend, script.begin.budget, script.begin.mesh);
  for (const Call& call : script.calls)
    text += fmt::format("; {} {} {} {}", call.name, call.a, call.b, call.c);
  return text;
}

Script script_from(const std::string& text) {
  Script script;
  std::istringstream words(text);
  std::string separated;
  while (std::getline(words, separated, ';')) {
    std::istringstream call(separated);
    Call read;
    call >> read.name >> read.a >> read.b >> read.c;
    if (read.name == "begin")
      script.begin = {read.a, read.b, read.c};
    else if (!read.name.empty())
      script.calls.push_back(std::move(read));
  }
  return script;
}

Script random_script(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto any = [&] { return static_cast<std::uint32_t>(random() % 1000); };
  Script script;
  script.begin = {any(), any(), any()};
  const std::size_t length = 5 + random() % 40;
  for (std::size_t i = 0; i < length; ++i)
    script.calls.push_back({kNames[random() % kNames.size()], any(), any(), any()});
  return script;
}

std::optional<std::string> run_script(const Script& script, Outcomes* outcomes) {
  std::size_t at = 0;
  try {
    Machine machine(script, outcomes);
    for (; at < script.calls.size(); ++at) {
      machine.current_ = script.calls[at].name;
      machine.run(script.calls[at]);
      machine.check();
    }
    return std::nullopt;
  } catch (const std::exception& error) {
    return fmt::format("call {}, {}: {}", at + 1,
                       at < script.calls.size() ? script.calls[at].name : "end", error.what());
  }
}

Script shrunk(Script script) {
  for (std::size_t part = std::max<std::size_t>(script.calls.size() / 2, 1); part > 0;) {
    bool shorter = false;
    for (std::size_t first = 0; first < script.calls.size();) {
      Script without = script;
      const auto from = without.calls.begin() + static_cast<std::ptrdiff_t>(first);
      without.calls.erase(
          from, from + static_cast<std::ptrdiff_t>(std::min(part, script.calls.size() - first)));
      if (run_script(without)) {
        script = std::move(without);
        shorter = true;
      } else {
        first += part;
      }
    }
    if (!shorter) part /= 2;
  }
  return script;
}

}  // namespace plait::test
