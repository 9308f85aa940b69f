// What a store knows of the passes, readers and processes that use it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/error.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/store_access.h"
#include "store/parts/part_store.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool has(const Store::Implementation& state, StorePass::Kind kind) {
  return state.pass_counts[static_cast<std::size_t>(kind)] > 0;
}

LevelPipelines pipelines_of_new(const Store::Implementation& state,
                                const StoreAccess::NewLevels& levels) {
  if (levels.id != kNoId) return state.attributes[levels.id].named_pipelines();
  return state.options.pipeline_of ? state.options.pipeline_of(levels.schema)
                                   : *state.options.pipeline;
}

}  // namespace

const std::string& Store::Implementation::name() const {
  static const std::string in_memory = "a store in memory";
  return on_disk() ? path.native() : in_memory;
}

std::shared_ptr<Store::Implementation> Store::Implementation::own(
    std::unique_ptr<Implementation> state) {
  return {state.release(), [](Implementation* owned) {
            if (owned->process.is_current()) {
              delete owned;
              return;
            }
            // The threads of the pager are missing here, and the files belong to the other process.
            owned->base = BaseMesh();
            for (Attribute& attribute : owned->attributes) attribute.base_bytes = {};
            static std::vector<Implementation*> kept;  // for tools that look for lost memory
            kept.push_back(owned);
          }};
}

Store::Implementation& Store::state() const {
  if (!implementation_)
    throw Error(ErrorCode::kBadState,
                "use a store: it is closed, or its content was moved to another object");
  implementation_->process.check(implementation_->name());
  return *implementation_;
}

void check_undisturbed(const Store::Implementation& state, Change change, std::string_view verb) {
  const bool disturbs = has(state, StorePass::Kind::kPass) ||
                        (change != Change::kCommit && has(state, StorePass::Kind::kPause)) ||
                        (change == Change::kRemove && has(state, StorePass::Kind::kWalk));
  if (disturbs)
    throw Error(ErrorCode::kBadState,
                fmt::format("{} {}: a pass over the store is under way; wait until it has ended",
                            verb, state.name()));
  const std::uint64_t readers = state.reader_count, views = state.view_count;
  if (readers == 0 && views == 0) return;
  throw Error(ErrorCode::kBusy,
              fmt::format("{} {}: expected no reader of this store, found {} reader{} and {} open "
                          "view{}: end them first",
                          verb, state.name(), readers, readers == 1 ? "" : "s", views,
                          views == 1 ? "" : "s"));
}

void check_change(const Store::Implementation& state, Change change, std::string_view verb) {
  if (!state.writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("{} {}: the store was opened for reading; open it for writing", verb,
                            state.name()))
        .about(state.path);
  check_undisturbed(state, change, verb);
}

void begin_change(Store::Implementation& state, Change change, std::string_view verb) {
  check_change(state, change, verb);
  if (change != Change::kRecords) state.changed = true;  // records tell of themselves
}

std::string why_unfinished(const WrittenRecords& records) {
  return records.first_missing_face == kNoId
             ? "a pass that writes to it was cancelled, failed or has not ended"
             : fmt::format("a PatchWriter was not given face {}", records.first_missing_face);
}

void refuse_unfinished(const Store::Implementation& state, std::string_view attribute,
                       const WrittenRecords& records, int level) {
  throw Error(
      ErrorCode::kBadState,
      fmt::format("read level {} of '{}' in {}: it is unfinished: {}; run a pass again that "
                  "overwrites it, or take Store::roll_back()",
                  level, attribute, state.name(), why_unfinished(records)));
}

StorePass::StorePass(const Store& store, Kind kind) : kind_(kind) {
  store.state();
  store_ = store.implementation_;
  ++store_->pass_counts[static_cast<std::size_t>(kind_)];
}

StorePass::StorePass(Store& store, std::string_view verb) : kind_(Kind::kPass) {
  begin_change(store.state(), Change::kRecords, verb);
  store_ = store.implementation_;
  ++store_->pass_counts[static_cast<std::size_t>(kind_)];
}

StorePass::~StorePass() { --store_->pass_counts[static_cast<std::size_t>(kind_)]; }

void StoreAccess::check_readable(const Store& store, AttributeId attribute, int level,
                                 bool within_work) {
  const Store::Implementation& state = store.state();
  const WrittenRecords& records = written_records_of(state, attribute, level);
  if (records.is_finished()) return;
  if (within_work && !records.left_unfinished && !has(state, StorePass::Kind::kPass)) return;
  refuse_unfinished(state, state.infos[attribute].schema.name, records, level);
}

void StoreAccess::check_changeable(const Store& store, std::string_view verb) {
  check_change(store.state(), Change::kRemove, verb);
}

WrittenRecords& StoreAccess::base_records_of(Store& store, AttributeId attribute) {
  return *attribute_of(store.state(), attribute).base_written;
}

std::uint64_t StoreAccess::frame_budget_with(const Store& store, std::span<const NewLevels> levels,
                                             const Provenance* planned) {
  const Store::Implementation& state = store.state();
  const LevelSurroundings around = state.surroundings();
  std::vector<FutureLevel> future;
  std::uint32_t number = state.next_number;
  for (const NewLevels& made : levels) {
    const bool is_new = made.id == kNoId;
    const LevelPipelines last = pipelines_of_new(state, made);
    LevelPipelines pipelines = last;
    if (planned)
      pipelines = state.backend.planned(std::move(pipelines),
                                        {made.schema, *planned, made.last_level, false});
    const std::uint32_t own = is_new ? number++ : state.attributes[made.id].record.number;
    for (int level = made.first_level; level <= made.last_level; ++level) {
      const Pipeline pipeline =
          state.backend.first_pipeline(last.of(level), pipelines.of(level), made.schema);
      future.push_back(
          {state.whole_geometry(made.schema.record_bytes(), level,
                                block_bytes_of_level(pipeline, level - store.base_level(),
                                                     state.options.block_bytes)),
           made.schema, pipeline, own, level, &around});
    }
  }
  const std::uint64_t now = state.volume->scratch_bytes(),
                      then = std::max(now, state.volume->scratch_bytes_with(future)),
                      frames = state.pager->budget_bytes();
  return frames + now - std::min(frames + now, then);
}

Store StoreAccess::store_of(std::unique_ptr<Store::Implementation> state) {
  return Store(std::move(state));
}

void StoreAccess::set_block_filled(Store& store, BlockFilled filled) {
  store.state().block_filled = std::move(filled);
}

const StoreAccess::BlockFilled& StoreAccess::block_filled(const Store& store) {
  return store.state().block_filled;
}

std::string StoreAccess::final_name(const Store& store, AttributeId attribute) {
  return store.state().final_schema(attribute).name;
}

bool StoreAccess::takes_pieces(const Store& store) {
  const BaseMesh& base = store.base();
  return base.piece_bytes() != 0 && base.depths() == nullptr && !store.state().is_part();
}

EdgeRange StoreAccess::edges(const Store& store) {
  const Store::Implementation& state = store.state();
  if (!state.is_part()) return {0, static_cast<EdgeId>(state.base.edge_count())};
  return {state.shards.first_edge(state.only_shard), state.shards.edge_after(state.only_shard)};
}

std::optional<std::vector<VertexId>> StoreAccess::own_vertices(const Store& store) {
  const Store::Implementation& state = store.state();
  if (!state.is_part()) return std::nullopt;
  return owned_vertices(state.base, state.shards, state.only_shard);
}

bool StorePass::is_under_way(const Store& store) { return has(store.state(), Kind::kPass); }

PLAIT_END_NAMESPACE
