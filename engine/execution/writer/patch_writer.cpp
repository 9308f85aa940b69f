#include "plait/patch_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <utility>

#include "base/contention.h"
#include "execution/writer/patch_records.h"
#include "execution/writer/shared_vertices.h"
#include "execution/writer/written_attribute.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The records of edited positions are no longer those that a scheme makes.
void forget_how_made(Store& store, AttributeId id) {
  if (StoreAccess::rounding(store, id)) StoreAccess::set_rounding(store, id, {});
  if (store.attributes()[id].schema.name != "position" || store.provenance().scheme.empty()) return;
  Provenance provenance = store.provenance();
  provenance.scheme.clear();
  provenance.limit = false;
  StoreAccess::set_provenance(store, provenance);
}

}  // namespace

struct PatchWriter::State {
  State(Store& store, const PatchWriterOptions& options);
  ~State();

  WrittenAttribute& find(const Target& target);
  void check_patch(const WrittenAttribute& attribute, FaceId face, int level,
                   std::size_t bytes) const;
  int number(int refinements) const {
    return level_number(BaseRelativeLevel(refinements), base_level);
  }

  using Lock = std::unique_lock<std::mutex>;
  void begin(Lock& lock, WrittenAttribute& attribute, FaceId face, int from, int to,
             FilledBlocks& blocks);
  bool make_room(std::uint64_t needed_bytes, std::uint64_t most_bytes);
  void end(WrittenAttribute& attribute, const FilledBlocks& blocks) noexcept;

  std::optional<StorePass> under_way;  ///< keeps the store's files and memory
  UnfinishedLevels unfinished;
  Topology mesh;
  int base_level;
  bool compares;
  bool finished = false;
  std::uint64_t share_bytes;
  Session session;  ///< not open after finish()
  PagingStatistics statistics_at_end;

  mutable std::mutex mutex;  ///< for the following
  std::condition_variable call_ended;
  std::uint64_t calls = 0;  ///< that fill blocks now
  std::vector<WrittenAttribute> attributes;
  std::vector<SharedVertices> shared;  ///< [attribute] empty unless `compares`
};

PatchWriter::State::State(Store& store, const PatchWriterOptions& options)
    : mesh(store.base().topology()), base_level(store.base_level()), compares(options.compare) {
  const std::string_view verb = "write patches of";
  { const StorePass allowed(store, verb); }
  std::vector<AttributeId> ids;
  for (const std::string& name : options.attributes) ids.push_back(store.attribute(name));
  if (options.attributes.empty())
    for (AttributeId id = 0; id < store.attributes().size(); ++id) ids.push_back(id);
  attributes.reserve(ids.size());
  std::vector<std::pair<int, int>> ranges;
  for (const AttributeId id : ids) {
    const AttributeInfo& info = store.attributes()[id];
    const int first = options.first_level.value_or(base_level),
              last = options.last_level.value_or(info.finest_level);
    if (first < base_level || last < first || last > info.finest_level)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("write levels {} to {} of '{}': expected levels from {} to {}", first,
                              last, info.schema.name, base_level, info.finest_level));
    StoreAccess::refuse_depths(store, verb, last);
    if (std::ranges::count(ids, id) > 1)
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("write patches of '{}': the attribute is named twice", info.schema.name));
    for (int level = std::max(first, base_level + 1); level <= last; ++level) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      check_not_fixed(file);
      if (needs_other_blocks(file))
        throw Error(ErrorCode::kNotSupported,
                    fmt::format("write patches of '{}': level {} is encoded from other blocks "
                                "(pipeline {}) since the last commit: write to new levels, in an "
                                "attribute that replaces this one",
                                info.schema.name, level, file.pipeline.to_text()));
    }
    ranges.push_back({first - base_level, last - base_level});
  }
  // From here on nothing is refused: a PinnedLevel that an exception ends leaves its level
  // unfinished.
  for (std::size_t at = 0; at < ids.size(); ++at) {
    attributes.emplace_back(store, ids[at], ranges[at].first, ranges[at].second);
    if (compares) shared.emplace_back(attributes.back(), mesh, base_level);
  }
  for (const AttributeId id : ids) forget_how_made(store, id);

  under_way.emplace(store, verb);
  for (WrittenAttribute& attribute : attributes) {
    if (attribute.first() == 0) unfinished.add_base(attribute.base_written(), Access::kOverwrite);
    for (int level = std::max(attribute.first(), 1); level <= attribute.last(); ++level)
      unfinished.add(attribute.file(level), Access::kOverwrite);
  }
  // Blocks that are being written to the disk need frames too.
  share_bytes = StoreAccess::backend_traits(store).in_memory
                    ? std::numeric_limits<std::uint64_t>::max()
                : options.share_bytes != 0 ? options.share_bytes
                                           : StoreAccess::pager(store).budget_bytes() / 4 * 3;
  session = StoreAccess::open_session(store, {.only_writes = true});
}

PatchWriter::State::~State() {
  if (finished) return;
  for (const WrittenAttribute& attribute : attributes)
    for (int level = attribute.first(); level <= attribute.last(); ++level) {
      WrittenRecords& records = level == 0 ? attribute.base_written() : attribute.file(level);
      if (attribute.missing_faces(level) > 0)
        records.first_missing_face = attribute.first_missing(level);
    }
}

WrittenAttribute& PatchWriter::State::find(const Target& target) {
  const auto found = std::ranges::find(
      attributes, target.name,
      [](const WrittenAttribute& each) -> std::string_view { return each.schema().name; });
  if (found == attributes.end())
    throw Error(ErrorCode::kNotFound,
                fmt::format("write a patch: the writer fills no attribute '{}'", target.name));
  const AttributeSchema& schema = found->schema();
  if (target.components != 0 &&
      (schema.type != target.type || schema.components != target.components))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("write a patch: attribute '{}' holds {} x {}, found records of {} x {}",
                            schema.name, to_string(schema.type), schema.components,
                            to_string(target.type), target.components));
  return *found;
}

void PatchWriter::State::check_patch(const WrittenAttribute& attribute, FaceId face, int level,
                                     std::size_t bytes) const {
  const AttributeSchema& schema = attribute.schema();
  if (face >= mesh.faces.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("write face {} of '{}': expected a face below {}", face, schema.name,
                            mesh.faces.size()));
  if (level < number(attribute.first()) || level > number(attribute.last()))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("write face {} of '{}' at level {}: the writer fills levels {} to {}", face,
                    schema.name, level, number(attribute.first()), number(attribute.last())));
  const std::uint64_t records =
      patch_vertex_count(std::int64_t{1} << relative_to_base(level, base_level).refinements);
  if (bytes != records * schema.record_bytes())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("write face {} of '{}' at level {}: expected {} records of {} bytes, "
                            "found {} bytes",
                            face, schema.name, level, records, schema.record_bytes(), bytes));
}

/// Lists and pins the blocks of the face's slots, and releases others if there is no room.
void PatchWriter::State::begin(Lock& lock, WrittenAttribute& attribute, FaceId face, int from,
                               int to, FilledBlocks& blocks) {
  while (true) {
    for (WrittenAttribute& each : attributes) each.begin_step();
    const std::uint64_t missing = attribute.need(face, from, to, blocks);
    if (missing > 0) make_room(missing, share_bytes);
    try {
      attribute.use(session, blocks);
      ++calls;
      return;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBudget) throw;
      if (make_room(missing, 0)) continue;
      if (calls == 0) throw;
    }
    call_ended.wait(lock);
  }
}

/// Releases the blocks that no patch has needed for the longest time, until `needed_bytes` more fit
/// into `most_bytes`. Returns whether it released any.
bool PatchWriter::State::make_room(std::uint64_t needed_bytes, std::uint64_t most_bytes) {
  std::uint64_t held_bytes = 0;
  for (const WrittenAttribute& attribute : attributes)
    for (const PinnedLevel& level : attribute.held()) held_bytes += level.pinned_bytes();
  bool released = false;
  while (held_bytes > most_bytes || needed_bytes > most_bytes - held_bytes) {
    PinnedLevel* oldest = nullptr;
    for (WrittenAttribute& attribute : attributes)
      if (PinnedLevel* const level = attribute.oldest_idle();
          level && (!oldest || level->oldest_step() < oldest->oldest_step()))
        oldest = level;
    if (!oldest) break;
    oldest->release_oldest();
    held_bytes -= oldest->frame_bytes();
    released = true;
  }
  return released;
}

void PatchWriter::State::end(WrittenAttribute& attribute, const FilledBlocks& blocks) noexcept {
  attribute.end_use(blocks);
  --calls;
  call_ended.notify_all();
}

PatchWriter::PatchWriter(Store& store, const PatchWriterOptions& options) {
  with_memory_errors("write patches", [&] { state_ = std::make_unique<State>(store, options); });
}
PatchWriter::~PatchWriter() = default;
PatchWriter::PatchWriter(PatchWriter&&) noexcept = default;

void PatchWriter::write(const Target& target, FaceId face, Levels levels, int level,
                        std::span<const std::byte> records) try {
  State& state = *state_;
  if (state.finished) throw Error(ErrorCode::kBadState, "write a patch: the writer has finished");
  WrittenAttribute& attribute = state.find(target);
  state.check_patch(attribute, face, level, records.size());
  const int to = relative_to_base(level, state.base_level).refinements;
  const int from = levels == Levels::kOnly ? to : attribute.first();
  const PatchRecords patch{records.data(), attribute.schema().record_bytes(), to};

  patch.prefetch(records.size());
  FilledBlocks blocks;
  State::Lock lock = lock_soon(state.mutex);
  state.begin(lock, attribute, face, from, to, blocks);
  lock.unlock();
  const FaceSlots slots = attribute.slots(face, from, to);
  std::array<bool, 3> with_edge{};
  for (int side = 0; side < 3 && !state.compares; ++side)
    with_edge[static_cast<std::size_t>(side)] = state.mesh.is_own(face, side);
  copy_inside(patch, std::max(from, 1), with_edge, slots);
  if (from == 0 && !state.compares) copy_own_corners(patch, state.mesh, face, slots);

  lock = lock_soon(state.mutex);
  try {
    if (state.compares)
      state.shared[static_cast<std::size_t>(&attribute - state.attributes.data())].write(
          patch, face, from, slots);
  } catch (...) {
    state.end(attribute, blocks);
    throw;
  }
  attribute.note_written(face, from, to, blocks);
  state.end(attribute, blocks);
} catch (const std::bad_alloc&) {
  throw out_of_memory("write a patch");
}

void PatchWriter::finish() {
  State& state = *state_;
  if (state.finished)
    throw Error(ErrorCode::kBadState, "finish writing patches: the writer has finished");
  for (const WrittenAttribute& attribute : state.attributes)
    for (int level = attribute.first(); level <= attribute.last(); ++level)
      if (const std::uint64_t missing = attribute.missing_faces(level); missing > 0)
        throw Error(ErrorCode::kBadState,
                    fmt::format("finish writing '{}': face {} was not written at level {}; {} of "
                                "{} faces are missing there",
                                attribute.schema().name, attribute.first_missing(level),
                                state.number(level), missing, state.mesh.faces.size()));
  for (WrittenAttribute& attribute : state.attributes) attribute.release_all();
  state.unfinished.finish();
  state.statistics_at_end = state.session.statistics();
  state.session = Session();
  state.finished = true;
  state.under_way.reset();
}

PagingStatistics PatchWriter::statistics() const {
  return state_->finished ? state_->statistics_at_end : state_->session.statistics();
}

PLAIT_END_NAMESPACE
