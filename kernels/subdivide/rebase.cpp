#include <fmt/format.h>

#include <array>
#include <utility>

#include "butterfly/odd_patches.h"
#include "plait/edge_index.h"
#include "plait/error.h"
#include "plait/in_core_mesh.h"
#include "plait/kernels/rule_patches.h"
#include "plait/kernels/subdivide.h"
#include "plait/vertex_numbering.h"
#include "schemes/table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

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
    odd_patches(mesh, level, rule, rings);
    if constexpr (Rule::kReach == 1)
      if (rule.moves_even()) {
        even_patches(mesh, level, rule);
        move_base_vertices(mesh.topology(), rings, rule, records);
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
  return BaseMesh::build(std::move(refined), "refined base mesh");
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

BaseMesh rebase(const BaseMesh& mesh, int times, Scheme scheme, bool double_precision) {
  check_counts(mesh, times);
  const auto refine = [&](const auto& rule) { return refine_in_core(mesh, times, rule); };
  return double_precision ? with_rule<double>(scheme, refine) : with_rule<float>(scheme, refine);
}

BaseMesh rebase(const BaseMesh& mesh, int times, const OneRingScheme& scheme,
                bool double_precision) {
  check_counts(mesh, times);
  return double_precision ? refine_in_core(mesh, times, scheme.rule<double>())
                          : refine_in_core(mesh, times, scheme.rule<float>());
}

PLAIT_END_NAMESPACE
