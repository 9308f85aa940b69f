// Texts of a store, attributes of its base faces, and where its mesh was in the program's own.
#include "plait/notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/detail/face_depths.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "sized.h"

namespace plait::c {
namespace {

const plait_store::Maps& maps_of(const plait_store& store) {
  const std::scoped_lock lock(store.maps_mutex);
  if (!store.maps) {
    auto maps = std::make_unique<plait_store::Maps>();
    maps->input = store.store.base().input_maps();
    maps->turned.assign(maps->input.turned.begin(), maps->input.turned.end());
    store.maps = std::move(maps);
  }
  return *store.maps;
}

[[noreturn]] void refuse_index(const char* what, std::uint32_t index, std::size_t count) {
  throw Error(ErrorCode::kNotFound,
              fmt::format("{} {}: expected a number below {}", what, index, count));
}

/// The points of vertices of a level that is finer than the base level.
void fill_points(const Store& store, int level, std::uint64_t first, std::uint64_t count,
                 plait_point* points) {
  const Topology mesh = store.base().topology();
  const FaceDepths* const depths = store.base().depths();
  const int refinement = relative_to_base(level, store.base_level()).refinements;
  const LevelGeometry slots = StoreAccess::geometry(store, 1, level, 1);  // of one slot each
  for (std::uint64_t at = 0; at < count;) {
    EdgeId edge = slots.first_edge(slots.block_at(first + at));
    while (slots.slot(edge).bytes == 0) ++edge;  // absent slots before the one of the block
    const Slot slot = slots.slot(edge);
    const std::int64_t last = slot_side(refinement) - 1;
    // A half slot is in the frame of the face that it belongs to.
    const bool turned = slot.shape == SlotShape::kHalf && depths != nullptr &&
                        !depths->own_face_has(mesh.edges[edge], slots.level());
    for (std::uint64_t in_slot = first + at - slot.offset; in_slot < slot.bytes && at < count;
         ++in_slot, ++at) {
      auto place = slot_point(refinement, slot.shape, static_cast<std::int64_t>(in_slot));
      if (turned) place = {last - place.row, last - place.column};
      const FaceIndex point = face_index(mesh, {edge, refinement, place.row, place.column});
      points[at] = {point.face, static_cast<std::int32_t>(point.i),
                    static_cast<std::int32_t>(point.j), std::int32_t{1} << refinement};
    }
  }
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_get_input_maps(const plait_store* store, plait_input_maps* maps) {
  return guarded("plait_store_get_input_maps", [&] {
    read_store(store);
    check_result(maps, "maps");
    const plait_store::Maps& all = maps_of(*store);
    plait_input_maps result = PLAIT_INPUT_MAPS_INIT;
    result.input_vertices = all.input.input_vertices.data();
    result.input_faces = all.input.input_faces.data();
    result.turned = all.turned.data();
    result.vertices = all.input.vertices.data();
    result.faces = all.input.faces.data();
    result.vertex_count = all.input.input_vertices.size();
    result.face_count = all.input.input_faces.size();
    result.input_vertex_count = all.input.vertices.size();
    result.input_face_count = all.input.faces.size();
    fill(maps, result);
  });
}

plait_status plait_store_get_points(const plait_store* store, int32_t level, uint64_t first,
                                    uint64_t count, plait_point* points) {
  return guarded("plait_store_get_points", [&] {
    const plait::Store& of = read_store(store);
    check_given(points, "points");
    if (level < of.base_level() || level > plait::kMaxLevel)
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         fmt::format("level: expected {} to {}, found {}", of.base_level(),
                                     plait::kMaxLevel, level));
    const bool is_base = level == of.base_level();
    const std::uint64_t there = is_base ? of.base().vertex_count()
                                        : plait::StoreAccess::geometry(of, 1, level).total_bytes();
    if (first > there || count > there - first)
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         fmt::format("vertices of level {}: expected numbers below {}, found {} "
                                     "from {}",
                                     level, there, count, first));
    if (!is_base) return fill_points(of, level, first, count, points);
    const plait::Topology mesh = of.base().topology();
    for (std::uint64_t at = 0; at < count; ++at) {
      const plait::FaceSide corner = mesh.vertex_corners[first + at];
      const plait::FaceIndex point = plait::corner_point(corner.face(), 0, corner.side());
      points[at] = {point.face, static_cast<std::int32_t>(point.i),
                    static_cast<std::int32_t>(point.j), 1};
    }
  });
}

plait_status plait_store_set_text(plait_store* store, const char* name, const char* text) {
  return guarded("plait_store_set_text", [&] {
    plait::Store& changed = changed_store(store);
    check_given(name, "name");
    changed.notes().set_text(name, text_or(text, ""));
  });
}

plait_status plait_store_get_text(const plait_store* store, const char* name, const char** text) {
  return guarded("plait_store_get_text", [&] {
    const plait::Store& of = read_store(store);
    check_given(name, "name");
    check_given(text, "text");
    const auto found = of.notes().texts().find(std::string_view(name));
    if (found == of.notes().texts().end())
      throw plait::Error(plait::ErrorCode::kNotFound,
                         fmt::format("{}: no text '{}'", of.path().native(), name));
    *text = found->second.c_str();
  });
}

plait_status plait_store_get_text_name(const plait_store* store, uint32_t index,
                                       const char** name) {
  return guarded("plait_store_get_text_name", [&] {
    const plait::Store& of = read_store(store);
    check_given(name, "name");
    if (index >= of.notes().texts().size()) refuse_index("text", index, of.notes().texts().size());
    *name = std::next(of.notes().texts().begin(), index)->first.c_str();
  });
}

plait_status plait_store_add_face_attribute(plait_store* store, const char* name,
                                            plait_component_type type) {
  return guarded("plait_store_add_face_attribute", [&] {
    plait::Store& changed = changed_store(store);
    check_given(name, "name");
    changed.notes().add_face_attribute({name, plait::c::component_type_of(type), 1});
  });
}

plait_status plait_store_remove_face_attribute(plait_store* store, const char* name) {
  return guarded("plait_store_remove_face_attribute", [&] {
    plait::Store& changed = changed_store(store);
    check_given(name, "name");
    changed.notes().remove_face_attribute(name);
  });
}

plait_status plait_store_get_face_attribute(const plait_store* store, uint32_t index,
                                            plait_attribute_info* info) {
  return guarded("plait_store_get_face_attribute", [&] {
    const plait::Store& of = read_store(store);
    check_result(info, "info");
    if (index >= of.notes().face_attributes().size())
      refuse_index("face attribute", index, of.notes().face_attributes().size());
    const plait::AttributeSchema& schema = of.notes().face_attributes()[index];
    plait_attribute_info result = PLAIT_ATTRIBUTE_INFO_INIT;
    result.name = schema.name.c_str();
    result.record_bytes = schema.record_bytes();
    result.type = static_cast<plait_component_type>(schema.type);
    result.components = 1;
    result.finest_level = of.base_level();
    result.index = index;
    fill(info, result);
  });
}

plait_status plait_store_get_face_records(const plait_store* store, const char* name,
                                          const void** records, uint64_t* count) {
  return guarded("plait_store_get_face_records", [&] {
    const plait::Store& of = read_store(store);
    check_given(name, "name");
    const std::span<const std::byte> bytes = of.notes().face_bytes(name);
    if (records != nullptr) *records = bytes.data();
    if (count != nullptr) *count = of.base().face_count();
  });
}

plait_status plait_store_edit_face_records(plait_store* store, const char* name, void** records,
                                           uint64_t* count) {
  return guarded("plait_store_edit_face_records", [&] {
    plait::Store& changed = changed_store(store);
    check_given(name, "name");
    const std::span<std::byte> bytes = changed.notes().face_bytes(name);
    if (records != nullptr) *records = bytes.data();
    if (count != nullptr) *count = changed.base().face_count();
  });
}
