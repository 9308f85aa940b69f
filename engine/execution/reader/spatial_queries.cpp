// Which faces of a store are in a box or along a ray; and the file that has their bounds.
#include <fmt/format.h>

#include <optional>
#include <utility>

#include "execution/reader/face_bounds.h"
#include "execution/reader/reader_state.h"
#include "format/bounds_file.h"
#include "format/checksum.h"
#include "plait/bounds.h"
#include "plait/error.h"
#include "store/base_positions.h"
#include "store/lock.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The key of an attribute as the newest version on the disk has it; nothing if the version does
/// not have the attribute.
std::optional<std::uint64_t> committed_key(const Store::Implementation& state,
                                           std::uint32_t number) {
  const StoredVersion version(state.directory, open_newest_version(state.directory));
  std::vector<StoredLevel> levels = version.levels(state.base);
  version.read_tables_into(levels);
  for (const AttributeRecord& attribute : version.description().attributes) {
    if (attribute.number != number) continue;
    std::vector<const BlockTable*> tables;
    for (const StoredLevel& level : levels)
      if (level.number == number) tables.push_back(&level.table);
    // The file may be packed.
    const ZeroedArray<std::byte> records = version.read_base_records(attribute, state.base);
    return bounds_key(state.uuid, number, checksum_of(records), tables);
  }
  return std::nullopt;
}

}  // namespace

std::uint64_t Reader::State::bounds_key(const Attribute& attribute) const {
  std::vector<const BlockTable*> tables;
  for (const LevelFile* const level : attribute.levels) tables.push_back(&level->table);
  return plait::bounds_key(store->uuid, store->attributes[attribute.id].record.number,
                           checksum_of(attribute.base_bytes), tables);
}

std::vector<FaceBounds> Reader::State::compute_bounds(const Attribute& attribute,
                                                      const ProgressCallback& progress) const {
  check_points(attribute.schema, fmt::format("bounds of {}", store->name()));
  for (int level = base_level; level <= attribute.finest_level; ++level)
    check_finished(attribute, level);
  return compute_face_bounds(store->base, attribute.schema, attribute.base_bytes, attribute.levels,
                             session, progress);
}

std::shared_ptr<const BoundsTree> Reader::State::bounds_tree(std::size_t number) const {
  check_usable();
  const std::lock_guard lock(trees_mutex);
  std::shared_ptr<const BoundsTree>& tree = trees[number];
  if (tree) return tree;
  const Attribute& attribute = attributes[number];
  std::optional<std::vector<FaceBounds>> faces;
  // A writer's block tables do not tell of changes that are not written yet.
  if (store->on_disk() && !store->writable)
    faces = read_bounds_file(store->directory, store->attributes[attribute.id].record.number,
                             mesh.faces.size(), bounds_key(attribute));
  tree = std::make_shared<const BoundsTree>(faces ? std::move(*faces) : compute_bounds(attribute));
  return tree;
}

std::vector<FaceId> Reader::faces_in_box(const Box& box, std::string_view attribute) const {
  return state_->bounds_tree(number_of(attribute))->in_box(box);
}

std::vector<FaceOnRay> Reader::faces_along_ray(Vector3<double> origin, Vector3<double> direction,
                                               std::string_view attribute) const {
  return state_->bounds_tree(number_of(attribute))->along_ray(origin, direction);
}

void write_bounds(const Store& store, std::string_view attribute,
                  const ProgressCallback& progress) try {
  const Reader reader(
      store, {.attributes = {std::string(attribute)}, .policy = EvictionPolicy::kLayoutOrder});
  const Reader::State& state = *reader.state_;
  const Store::Implementation& of = *state.store;
  const std::string verb =
      fmt::format("write the bounds of '{}' of {}", attribute, of.path.native());
  if (!of.on_disk())
    throw Error(ErrorCode::kNotSupported, fmt::format("{}: the store is only in memory", verb));
  if (of.writable) of.pager->flush();  // then the block tables are those of the frames
  const std::uint32_t number = of.attributes[state.attributes[0].id].record.number;
  const std::uint64_t key = state.bounds_key(state.attributes[0]);
  if (of.writable && committed_key(of, number) != key)
    throw Error(ErrorCode::kBadState,
                fmt::format("{}: it has changes that are not committed", verb));
  const std::vector<FaceBounds> faces = state.compute_bounds(state.attributes[0], progress);
  StoreLock lock;
  if (!of.writable) lock = StoreLock(of.directory, LockFor::kWriting);
  write_bounds_file(of.directory, number, faces, key);
} catch (const std::bad_alloc&) {
  throw out_of_memory("write the bounds of " + store.path().native());
}

PLAIT_END_NAMESPACE
