#include <fmt/format.h>

#include <array>
#include <utility>

#include "base/default_arithmetic.h"
#include "butterfly/odd_patches.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/in_core_mesh.h"
#include "plait/extend/rule_patches.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/subdivide.h"
#include "schemes/table.h"
#include "store/base_positions.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// VertexNumbering begins with the vertices of the base mesh, and the parts of a face follow each
/// other.
InputMaps maps_of_refined(InputMaps maps, std::uint64_t vertex_count, int times) {
  maps.input_vertices.resize(vertex_count, kNoId);
  InputMaps refined;
  refined.input_vertices = std::move(maps.input_vertices);
  refined.input_vertex_count = maps.input_vertex_count;
  for (std::size_t face = 0; face < maps.input_faces.size(); ++face) {
    const std::size_t parts = std::size_t{1} << (2 * times);
    refined.input_faces.insert(refined.input_faces.end(), parts, maps.input_faces[face]);
    refined.turned.insert(refined.turned.end(), parts, maps.turned[face]);
  }
  return refined;
}

template <class Rule>
BaseMesh refine_in_core(const BaseMesh& base, int times, const Rule& rule) {
  using Real = typename Rule::Real;
  using Record = Vector3<Real>;
  InCoreMesh<Record> mesh(base, times);
  const std::span<Record> records = mesh.base_records();
  for (std::size_t vertex = 0; vertex < records.size(); ++vertex)
    records[vertex] = narrow<Real>(base.positions()[vertex]);
  RingTable<Record> rings(base.edge_count());
  rings.set_from_base(mesh.topology(), records);
  for (int level = 1; level <= times; ++level) {
    if constexpr (Rule::kRingCount == 1) {
      odd_patches(mesh, level, rule, rings);
      if (rule.moves_even()) {
        even_patches(mesh, level, rule);
        move_base_vertices(mesh.topology(), rings, rule, records);
      }
    } else {
      odd_patches(mesh, level, rule, records, rings);
    }
  }

  const VertexNumbering numbering(base.topology(), times);
  IndexedMesh refined;
  refined.positions.resize(numbering.vertex_count());
  refined.faces.reserve(base.face_count() << (2 * times));
  const std::int64_t size = std::int64_t{1} << times;
  for (FaceId face = 0; face < base.face_count(); ++face) {
    const auto patch = mesh.patch(face);
    const auto number = [&](std::int64_t i, std::int64_t j) {
      return static_cast<VertexId>(numbering.number({face, times, i, j}));
    };
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i)
        refined.positions[number(i, j)] = widen(patch.at(times, i, j));
    for_each_triangle(times, [&](const std::array<FacePoint, 3>& corners) {
      refined.faces.push_back({number(corners[0].i, corners[0].j),
                               number(corners[1].i, corners[1].j),
                               number(corners[2].i, corners[2].j)});
    });
  }
  return BaseMesh::build(std::move(refined), "refined base mesh")
      .with_input_maps(maps_of_refined(base.input_maps(), numbering.vertex_count(), times));
}

void check_counts(const BaseMesh& mesh, int times) {
  const LevelCounts counts = counts_at_level(mesh, times);
  if (counts.vertices >= kNoId || counts.faces >= kNoId / 3)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "refine the base mesh {} times: the result would have {} faces, which is too many",
            times, counts.faces));
}

}  // namespace

int rebase_levels(int levels, std::uint64_t record_bytes, std::uint64_t max_slot_bytes) {
  if (levels < 1) return 0;
  int refined_levels = levels;
  while (refined_levels > 1 && slot_records(refined_levels) * record_bytes > max_slot_bytes)
    --refined_levels;
  return levels - refined_levels;
}

BaseMesh rebase(const BaseMesh& mesh, int times, const Scheme& scheme,
                ComponentType precision) try {
  const DefaultArithmetic arithmetic;
  check_positions(mesh, precision);
  check_counts(mesh, times);
  const auto refine = [&](const auto& rule) { return refine_in_core(mesh, times, rule); };
  return precision == ComponentType::kFloat64 ? with_rule<double>(scheme, refine)
                                              : with_rule<float>(scheme, refine);
} catch (const std::bad_alloc&) {
  throw out_of_memory("refine the base mesh");
}

PLAIT_END_NAMESPACE
