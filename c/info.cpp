// What a store contains.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "export/numbered_triangles.h"
#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "plait/store_info.h"
#include "sized.h"
#include "statistics.h"

namespace plait::c {
namespace {

static_assert(sizeof(Vector3<double>) == 3 * sizeof(double));
static_assert(sizeof(std::array<VertexId, 3>) == 3 * sizeof(std::uint32_t));

plait_store_info info_of(const plait_store& handle) {
  const Store& store = handle.store;
  const StoreOptions& options = store.options();
  plait_store_info info = PLAIT_STORE_INFO_INIT;
  info.path = store.path().c_str();
  info.backend = options.backend.c_str();
  info.pipeline = handle.pipeline.c_str();
  info.layout = store.provenance().layout.c_str();
  info.scheme = store.provenance().scheme.c_str();
  info.program = store.provenance().program.c_str();
  info.sequence = store.sequence();
  const plait::StoreInfo figures = store.info();
  info.stored_bytes = figures.stored_bytes;
  info.block_bytes = options.block_bytes;
  info.budget_bytes = options.budget_bytes;
  info.vertex_count = store.base().vertex_count();
  info.edge_count = store.base().edge_count();
  info.face_count = store.base().face_count();
  info.border_edge_count = store.base().border_edge_count();
  static_assert(sizeof(info.uuid) == sizeof(StoreUuid));
  std::memcpy(info.uuid, figures.uuid.data(), sizeof(info.uuid));
  info.attribute_count = static_cast<std::uint32_t>(store.attributes().size());
  info.base_level = store.base_level();
  info.finest_level = store.finest_level();
  info.writable = handle.writable ? 1 : 0;
  info.limit = store.provenance().limit ? 1 : 0;
  info.notices = handle.notices.c_str();
  info.precision = static_cast<plait_component_type>(store.provenance().precision);
  return info;
}

plait_attribute_info info_of(const Store& store, AttributeId attribute) {
  const AttributeInfo& known = store.attributes()[attribute];
  plait_attribute_info info = PLAIT_ATTRIBUTE_INFO_INIT;
  info.name = known.schema.name.c_str();
  info.record_bytes = known.schema.record_bytes();
  info.type = static_cast<plait_component_type>(known.schema.type);
  info.components = known.schema.components;
  info.finest_level = known.finest_level;
  info.index = attribute;
  return info;
}

}  // namespace

AttributeId attribute_named(const Store& store, const char* name) {
  check_given(name, "name");
  return store.attribute(name);
}

plait_paging_statistics statistics_of(const PagingStatistics& counted) {
  plait_paging_statistics statistics = PLAIT_PAGING_STATISTICS_INIT;
  statistics.blocks_read = counted.blocks_read;
  statistics.bytes_read = counted.bytes_read;
  statistics.blocks_written = counted.blocks_written;
  statistics.bytes_written = counted.bytes_written;
  statistics.blocks_prefetched = counted.blocks_prefetched;
  statistics.blocks_evicted = counted.blocks_evicted;
  statistics.read_waits = counted.read_waits;
  statistics.read_wait_ns = counted.read_wait_ns;
  statistics.write_waits = counted.write_waits;
  statistics.write_wait_ns = counted.write_wait_ns;
  statistics.peak_frame_bytes = counted.peak_frame_bytes;
  return statistics;
}

}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_get_info(const plait_store* store, plait_store_info* info) {
  return guarded("plait_store_get_info", [&] {
    read_store(store);
    check_result(info, "info");
    fill(info, info_of(*store));
  });
}

plait_status plait_store_get_attribute(const plait_store* store, uint32_t index,
                                       plait_attribute_info* info) {
  return guarded("plait_store_get_attribute", [&] {
    const plait::Store& of = read_store(store);
    check_result(info, "info");
    if (index >= of.attributes().size())
      throw plait::Error(plait::ErrorCode::kNotFound, "attribute " + std::to_string(index) +
                                                          ": expected a number below " +
                                                          std::to_string(of.attributes().size()));
    fill(info, info_of(of, index));
  });
}

plait_status plait_store_find_attribute(const plait_store* store, const char* name,
                                        plait_attribute_info* info) {
  return guarded("plait_store_find_attribute", [&] {
    const plait::Store& of = read_store(store);
    check_result(info, "info");
    fill(info, info_of(of, attribute_named(of, name)));
  });
}

plait_status plait_store_get_counts(const plait_store* store, int32_t level, uint64_t* vertices,
                                    uint64_t* edges, uint64_t* faces) {
  return guarded("plait_store_get_counts", [&] {
    const plait::Store& of = read_store(store);
    if (level < of.base_level() || level > plait::kMaxLevel)
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         "level " + std::to_string(level) + ": expected " +
                             std::to_string(of.base_level()) + " to " +
                             std::to_string(plait::kMaxLevel));
    const plait::LevelCounts counts = plait::counts_at_level(
        of.base(), plait::relative_to_base(level, of.base_level()).refinements);
    if (vertices != nullptr) *vertices = counts.vertices;
    if (edges != nullptr) *edges = counts.edges;
    if (faces != nullptr) *faces = counts.faces;
  });
}

plait_status plait_store_get_depths(const plait_store* store, int32_t* depths, uint64_t count) {
  return guarded("plait_store_get_depths", [&] {
    const plait::Store& of = read_store(store);
    check_given(depths, "depths");
    if (count != of.base().face_count())
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         "count: expected " + std::to_string(of.base().face_count()) +
                             ", one for each face, found " + std::to_string(count));
    for (plait::FaceId face = 0; face < count; ++face) depths[face] = of.depth(face);
  });
}

plait_status plait_store_get_triangles(const plait_store* store, int32_t level, uint32_t* triangles,
                                       uint64_t capacity, uint64_t* count) {
  return guarded("plait_store_get_triangles", [&] {
    const plait::Store& of = read_store(store);
    check_given(triangles, "triangles");
    if (level < of.base_level() || level > of.finest_level())
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         fmt::format("level: expected {} to {}, found {}", of.base_level(),
                                     of.finest_level(), level));
    const int refinements = level - of.base_level();
    const plait::LevelCounts counts = plait::counts_at_level(of.base(), refinements);
    if (counts.vertices > UINT32_MAX)
      throw plait::Error(
          plait::ErrorCode::kInvalidArgument,
          fmt::format("level {}: {} vertices, expected fewer than 2^32", level, counts.vertices));
    if (capacity < counts.faces)
      throw plait::Error(
          plait::ErrorCode::kInvalidArgument,
          fmt::format("capacity: expected {} triangles or more, found {}", counts.faces, capacity));
    const plait::PatchSelection patches(of.base(), refinements, plait::all_faces(of.base()));
    plait::for_each_numbered_triangle(
        patches,
        [&](plait::FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          for (const std::uint64_t corner : {a, b, c})
            *triangles++ = static_cast<std::uint32_t>(corner);
        },
        [](std::uint64_t) {});
    if (count != nullptr) *count = counts.faces;
  });
}

plait_status plait_store_get_faces(const plait_store* store, const uint32_t** triangles,
                                   uint64_t* face_count) {
  return guarded("plait_store_get_faces", [&] {
    const auto faces = read_store(store).base().faces();
    check_given(triangles, "triangles");
    check_given(face_count, "face_count");
    *triangles = faces.front().data();  // a store has at least one face
    *face_count = faces.size();
  });
}

plait_status plait_store_get_base_positions(const plait_store* store, const double** positions,
                                            uint64_t* vertex_count) {
  return guarded("plait_store_get_base_positions", [&] {
    const auto vertices = read_store(store).base().positions();
    check_given(positions, "positions");
    check_given(vertex_count, "vertex_count");
    *positions = &vertices.front().x;
    *vertex_count = vertices.size();
  });
}

plait_status plait_store_get_statistics(const plait_store* store,
                                        plait_paging_statistics* statistics) {
  return guarded("plait_store_get_statistics", [&] {
    const plait::Store& of = read_store(store);
    check_result(statistics, "statistics");
    fill(statistics, statistics_of(plait::StoreAccess::pager(of).statistics()));
  });
}
