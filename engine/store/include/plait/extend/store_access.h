// plait/extend/store_access.h: what kernels, executors and copies need of a store beside the
// interface of plait/store.h. Most programs need visit_vertices() or a Reader instead.
//
// Threads: functions that take a const store may be called from several threads at the same time.
// While a thread calls another one, no other thread may use the store (docs/threads.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/level_file.h"
#include "plait/detail/namespace.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/pager.h"
#include "plait/extend/rounding.h"
#include "plait/extend/session.h"
#include "plait/extend/topology.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Tells a store that a pass over its levels is under way. A callback of the pass then gets
/// kBadState if it calls a function of the store that would disturb the pass. Reading and
/// statistics work. The object keeps the store's files and memory. Threads: one (docs/threads.md).
class StorePass {
 public:
  enum class Kind : std::uint8_t {
    kPass,   ///< nothing may change, and nothing may be committed
    kPause,  ///< a callback between two passes of a longer work: it may commit, and no more
    kWalk,   ///< a program's own walk over patches: it may not remove what it walks over
  };
  /// For a pass that only reads, or for the other kinds.
  explicit StorePass(const Store& store, Kind kind = Kind::kPass);
  /// For a pass that writes. `verb` begins messages: "sweep 'smooth' of". Errors: kBadState for a
  /// store that was opened for reading, and while another pass is under way; kBusy while the store
  /// has readers or views.
  StorePass(Store& store, std::string_view verb);
  ~StorePass();
  StorePass(const StorePass&) = delete;
  StorePass& operator=(const StorePass&) = delete;

  /// Whether there is an object of kind kPass.
  static bool is_under_way(const Store& store);

 private:
  std::shared_ptr<Store::Implementation> store_;
  Kind kind_;
};

/// The edges from `first` on, before `after`.
struct EdgeRange {
  EdgeId first = 0, after = 0;
};

/// The parts of a store that work on levels and blocks. All functions are static.
class StoreAccess {
 public:
  /// The open file of a level. Errors: kInvalidArgument unless base_level() < level <= finest level
  /// of the attribute.
  static LevelFile& level_file(Store& store, AttributeId attribute, int level);
  static const LevelFile& level_file(const Store& store, AttributeId attribute, int level);

  /// Where the slots and blocks of a level are, for records of `record_bytes`, in blocks near
  /// `block_bytes` (0: as options() says), whether the store has such a level or not. With records
  /// of one byte, offsets and sizes count vertices. A level file has this geometry, but blocks that
  /// are made again from another attribute are smaller. Errors: kInvalidArgument for a level or a
  /// size that a store cannot have.
  static LevelGeometry geometry(const Store& store, std::size_t record_bytes, int level,
                                std::uint64_t block_bytes = 0);

  /// Store::add_level() for a work that writes coarser levels first, and base records before them:
  /// the level has its own pipeline at once.
  static void add_final_level(Store& store, AttributeId attribute) {
    store.add_level(attribute, true);
  }

  /// Throws kBadState if the level is unfinished (plait/detail/level_file.h): its records are those
  /// of no moment. Level base_level() are the base records. A pass may read levels that the work
  /// around it has begun, unless another pass is under way (`within_work`); readers may not.
  static void check_readable(const Store& store, AttributeId attribute, int level,
                             bool within_work = false);

  /// Throws kNotSupported if the store has depths (Store::has_depths()) and a face that does not
  /// have `level`. `verb` begins the message: "subdivide".
  static void refuse_depths(const Store& store, std::string_view verb, int level);

  /// Errors: those that a call has which removes or adds attributes and levels. Changes nothing.
  static void check_changeable(const Store& store, std::string_view verb);
  /// Whether the base records of the attribute are finished, for UnfinishedLevels::add_base().
  static WrittenRecords& base_records_of(Store& store, AttributeId attribute);
  /// The base records for a pass that writes them: Store::base_bytes(), which with kOverwrite are
  /// also given if they are unfinished.
  /// The pass writes to them before the next commit only.
  static std::span<std::byte> base_bytes(Store& store, AttributeId attribute, Access access);
  template <class Record>
  static std::span<Record> base_records(Store& store, AttributeId attribute) {
    store.check_type(attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents);
    const std::span<std::byte> bytes = base_bytes(store, attribute, Access::kUpdate);
    return {reinterpret_cast<Record*>(bytes.data()), bytes.size() / sizeof(Record)};
  }
  /// The checks of base_bytes() alone, before the calls of put_base_records() by a work or a pass.
  static void begin_base_change(Store& store, AttributeId attribute, Access access);
  /// Writes records of base vertices that ascend, one after another, and reads bytes of all records
  /// from `first` on. Of a store whose base mesh is taken in pieces, these take memory for such
  /// records alone; base_bytes() reads all. Errors: kIo, kNoSpace.
  static void put_base_records(Store& store, AttributeId attribute,
                               std::span<const VertexId> vertices,
                               std::span<const std::byte> records);
  static void read_base_records(const Store& store, AttributeId attribute, std::uint64_t first,
                                std::span<std::byte> into);
  /// A program writes to base records when it likes, also after a commit: each commit compares
  /// them.
  static void lend_base_records(Store& store, AttributeId attribute);

  /// The levels of an attribute that a work will make: of attribute `id`, or of one that it adds
  /// (kNoId).
  struct NewLevels {
    AttributeSchema schema;
    AttributeId id;
    int first_level, last_level;
  };
  /// The part of the budget that is for frames at any time while these levels are added: the rest
  /// is what the backend keeps for itself. `planned`: plan_levels() is called before, with this
  /// provenance.
  static std::uint64_t frame_budget_with(const Store& store, std::span<const NewLevels> levels,
                                         const Provenance* planned = nullptr);

  /// Adds an attribute that gets its name only in the end, by name_replacement(). Until then it has
  /// a name that no program can give, and its levels are made as those of the name that it gets.
  /// Errors: as Store::add_attribute(), but the name may be taken.
  static AttributeId add_replacement(Store& store, AttributeSchema schema);
  /// Gives the replacement its name, and removes the attribute that has it. Errors: as
  /// Store::replace_attribute().
  static void name_replacement(Store& store, AttributeId replacement);
  /// The name that the replacement for `name` has until then.
  static std::string name_until_named(std::string_view name);

  /// Throws kInvalidArgument if the attribute has another type. The message names both types.
  static void check_type(const Store& store, AttributeId attribute, ComponentType type,
                         std::uint32_t components);

  /// Opens a session for one reader, sweep or walk. Several sessions may be open at once, in
  /// several threads. Errors: kOutOfMemory.
  static Session open_session(const Store& store, const SessionOptions& options = {});
  /// Called with each block of a level that a fused pass has filled, before the pager gets it: by
  /// the pass's threads, several at once.
  using BlockFilled =
      std::function<void(AttributeId, int level, std::uint64_t block, std::span<const std::byte>)>;
  /// For the passes from now on; nothing: none. REQUIRES: no pass is under way. Errors: none.
  static void set_block_filled(Store& store, BlockFilled filled);
  static const BlockFilled& block_filled(const Store& store);
  /// The name that the attribute has when the work under way is done: a replacement has another
  /// one until then.
  static std::string final_name(const Store& store, AttributeId attribute);

  /// Whether passes may take the base mesh in pieces (BaseMesh::in_pieces()).
  static bool takes_pieces(const Store& store);
  /// The edges whose slots a pass makes: all, but in the store of one part.
  static EdgeRange edges(const Store& store);
  /// The base vertices whose records a pass makes, ascending; nothing for all, as in every store
  /// but that of one part.
  static std::optional<std::vector<VertexId>> own_vertices(const Store& store);

  static Pager& pager(Store& store);
  static const Pager& pager(const Store& store);

  static const BackendTraits& backend_traits(const Store& store);
  static const std::optional<Rounding>& rounding(const Store& store, AttributeId attribute);

  /// Sets Store::provenance(). The store keeps its own `layout` and `base_level`. Errors:
  /// kInvalidArgument for a name that is too long or not printable.
  static void set_provenance(Store& store, const Provenance& provenance);

  /// Tells the store that levels up to `finest_level` will be added, and that they are what
  /// provenance() says. If the attribute's pipeline has the stage `predicted`, blocks that the
  /// scheme makes again are then stored in no bytes (plait/extend/block_maker.h). Blocks with other
  /// content are stored as always. If nothing can make such levels, the pipeline loses the stage.
  /// `others_are_complete`: the earlier attributes of the store are, so that blocks can be made
  /// from them too.
  static void plan_levels(Store& store, AttributeId attribute, int finest_level,
                          bool others_are_complete = false);

  /// Sets rounding(); the next commit records it. copy_attribute() calls it; a pass that
  /// gives the records other values sets it to nothing. Errors: kInvalidArgument for an error or a
  /// step that is negative or not finite.
  static void set_rounding(Store& store, AttributeId attribute,
                           const std::optional<Rounding>& rounding);

  // For the store's own sources.
  static Store store_of(std::unique_ptr<Store::Implementation> state);
  static Store::Implementation& state(Store& store) { return store.state(); }
  static const Store::Implementation& state(const Store& store) { return store.state(); }
};

PLAIT_END_NAMESPACE
