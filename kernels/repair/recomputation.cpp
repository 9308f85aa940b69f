#include "repair/recomputation.h"

#include <fmt/format.h>

#include <algorithm>

#include "plait/error.h"
#include "plait/fused.h"

namespace plait {
namespace {

const AttributeInfo* find(const StoreStructure& structure, std::string_view name) {
  const auto found = std::ranges::find_if(structure.attributes, [&](const AttributeInfo& info) {
    return info.schema.name == name && info.schema.components == 3;
  });
  return found == structure.attributes.end() ? nullptr : &*found;
}

bool is_base_damaged(const StoreStructure& structure) {
  return std::ranges::any_of(
      structure.damaged, [](const DamagedFile& file) { return file.kind == StoreFile::kBaseMesh; });
}

/// The built-in one, or whichever a program has put in its place.
std::optional<std::string> memory_backend(const BackendRegistry& backends) {
  for (const std::string& name : backends.names())
    if (const BackendTraits& traits = backends.find(name).traits; traits.in_memory) return name;
  return std::nullopt;
}

}  // namespace

Recomputation::Recomputation(const StoreStructure& structure, const RepairOptions& options,
                             const BackendRegistry& backends, PartialDirectory& scratch)
    : structure_(structure), options_(options), backends_(backends), scratch_(scratch) {
  const AttributeInfo* const position = find(structure, "position");
  if (is_base_damaged(structure)) {
    refusal_ = "base.mesh, from which it would be computed, is damaged";
  } else if (position == nullptr || (position->schema.type != ComponentType::kFloat32 &&
                                     position->schema.type != ComponentType::kFloat64)) {
    refusal_ = "the store has no positions of a refinement";
  } else {
    const Provenance& provenance = structure.provenance;
    try {
      subdivide_.scheme = scheme_from_name(provenance.scheme);
      subdivide_.limit = provenance.limit;
    } catch (const Error&) {
      refusal_ = provenance.scheme.empty()
                     ? "the manifest does not say what made the levels"
                     : fmt::format("the manifest's scheme '{}' is none that can be repeated",
                                   provenance.scheme);
    }
  }
  if (!refusal_.empty()) return;
  const int levels =
      relative_to_base(position->finest_level, structure.options.base_level).refinements;
  const bool fused = levels >= 1 && levels <= kMostFusedLevels;
  subdivide_.executor = fused ? ExecutorKind::kFused : ExecutorKind::kSweep;
  subdivide_.levels = position->finest_level;
  subdivide_.threads = options.threads;
  double_precision_ = position->schema.type == ComponentType::kFloat64;
  const AttributeInfo* const normal = find(structure, "normal");
  subdivide_.normals = normal != nullptr && normal->schema.type == ComponentType::kFloat32 &&
                       normal->finest_level == position->finest_level;
  if (options.proceed)
    subdivide_.proceed = [&options](const SubdivideProgress& now) {
      return options.proceed("compute anew", now.vertices_done, now.vertices_total);
    };
}

std::string Recomputation::refusal(std::string_view attribute) const {
  if (attribute != "position" && !(attribute == "normal" && subdivide_.normals))
    return fmt::format("attribute '{}' does not follow from the base mesh", attribute);
  return refusal_;
}

std::uint64_t Recomputation::level_bytes() const {
  const std::size_t position = 3 * (double_precision_ ? sizeof(double) : sizeof(float));
  // The sweep has limit positions beside the positions until it is done.
  const std::size_t records =
      position + (subdivide_.normals ? 3 * sizeof(float) : 0) +
      (subdivide_.limit && subdivide_.executor == ExecutorKind::kSweep ? position : 0);
  std::uint64_t bytes = 0;
  const BaseRelativeLevel finest =
      relative_to_base(subdivide_.levels, structure_.options.base_level);
  for (int level = 1; level <= finest.refinements; ++level)
    bytes += LevelGeometry(structure_.base.slot_shapes(), BaseRelativeLevel(level), records,
                           structure_.options.block_bytes)
                 .total_bytes();
  return bytes;
}

Store& Recomputation::made() {
  if (made_) return *made_;
  StoreOptions store = structure_.options;
  store.pipeline.clear();  // whatever keeps the levels here
  store.durability = Durability::kNone;
  store.budget_bytes = options_.budget_bytes / 2;
  const std::optional<std::string> memory = memory_backend(backends_);
  const bool in_memory = memory && level_bytes() <= store.budget_bytes;
  // On disk by the store's own backend: the one that is known to work here.
  if (in_memory) store.backend = *memory;
  Store made =
      Store::create(in_memory ? std::filesystem::path() : scratch_.directory().path() / "levels",
                    structure_.base, store, backends_);
  add_base_positions(made, double_precision_);
  subdivide(made, subdivide_);
  made_.emplace(std::move(made));
  return *made_;
}

}  // namespace plait
