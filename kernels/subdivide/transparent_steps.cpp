#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "butterfly/odd_patches.h"
#include "normals/normal_rules.h"
#include "plait/error.h"
#include "plait/extend/patch.h"
#include "plait/extend/rule_patches.h"
#include "plait/extend/store_access.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Reports progress between faces, but not after every face, because that would be too often.
template <class Real>
BeforeFace reporter(const SubdivisionRun<Real>& run, std::string phase, std::uint64_t vertices) {
  const std::uint64_t faces = run.store.base().face_count();
  return [&run, phase = std::move(phase), vertices, faces](FaceId face) {
    if (face % 256 == 0) run.report(phase, vertices, face, faces);
  };
}

}  // namespace

template <class Rule>
void make_odd_transparent(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level) {
  using Record = Vector3<typename Rule::Real>;
  Store& store = run.store;
  const std::uint64_t vertices = vertices_born(store, level, level);
  const BeforeFace before_face =
      reporter(run, fmt::format("level {}: odd vertices", level), vertices);
  StorePatches<Record> mesh(store, run.position, StoreAccess::pager(store).budget_bytes() / 2,
                            Rule::kRingCount == 2 ? Reach::kRing : Reach::kFaces);
  if constexpr (Rule::kRingCount == 1)
    odd_patches(mesh, level, rule, run.rings, before_face);
  else  // reads the base records, from which blocks may be encoded
    odd_patches(mesh, level, rule, std::as_const(store).template base_records<Record>(run.position),
                run.rings, before_face);
  run.vertices_before += vertices;
}

template <class Real>
void move_even_transparent(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level) {
  using Record = Vector3<Real>;
  Store& store = run.store;
  const std::uint64_t vertices = vertices_born(store, store.base_level() + 1, level - 1);
  StorePatches<Record> mesh(store, run.position, StoreAccess::pager(store).budget_bytes() / 2);
  even_patches(mesh, level, rule,
               reporter(run, fmt::format("level {}: even vertices", level), vertices));
  run.vertices_before += vertices;
}

template <class Rule>
void make_surface_transparent(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level,
                              AttributeId normal, AttributeId limit) {
  using Record = Vector3<typename Rule::Real>;
  Store& store = run.store;
  const Topology topology = store.base().topology();
  const int first = store.base_level() + 1;
  const std::uint64_t vertices = vertices_born(store, first, level);
  const BeforeFace before_face = reporter(run, "normals and limit positions", vertices);
  const std::uint64_t share = StoreAccess::pager(store).budget_bytes() / 4;
  StorePatches<Record> positions(store, run.position, share);
  positions.activate(level, 1, 0);
  std::unique_ptr<StorePatches<Vector3<float>>> normals_mesh;
  std::unique_ptr<StorePatches<Record>> limits_mesh;
  if (normal != kNoId) {
    normals_mesh =
        std::make_unique<StorePatches<Vector3<float>>>(store, normal, share, Reach::kOwn);
    normals_mesh->activate(level, 1, level);
  }
  if (limit != kNoId) {
    limits_mesh = std::make_unique<StorePatches<Record>>(store, limit, share, Reach::kOwn);
    limits_mesh->activate(level, 1, level);
  }
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    before_face(face);
    const auto patch = positions.patch(face);
    const auto normal_patch =
        normals_mesh ? std::optional(normals_mesh->patch(face)) : std::nullopt;
    const auto limit_patch = limits_mesh ? std::optional(limits_mesh->patch(face)) : std::nullopt;
    for (int born = first; born <= level; ++born)
      for_each_owned(
          patch, born, [&](auto side, std::int64_t row, std::int64_t column, bool border) {
            const PatchFrame frame(patch, side, born, row, column, level);
            const Record& v = frame.at(0, 0);
            if (normal_patch)
              PatchFrame(*normal_patch, side, born, row, column, born).at(0, 0) =
                  border ? RegularNormal::border(v, frame.at(-1, 1), frame.at(-1, 0),
                                                 frame.at(0, -1), frame.at(1, -1))
                         : normals::regular(frame.at(1, 0) - frame.at(-1, 0),
                                            frame.at(0, 1) - frame.at(0, -1),
                                            frame.at(-1, 1) - frame.at(1, -1));
            if constexpr (Rule::kRingCount == 1)
              if (limit_patch)
                PatchFrame(*limit_patch, side, born, row, column, born).at(0, 0) =
                    border ? rule.limit_border(v, frame.at(-1, 1), frame.at(1, -1))
                           : rule.limit(
                                 v, ring_sum(frame.at(1, 0), frame.at(0, 1), frame.at(-1, 1),
                                             frame.at(-1, 0), frame.at(0, -1), frame.at(1, -1)));
          });
  }
  run.vertices_before += vertices;
}

template void make_odd_transparent(SubdivisionRun<float>&, const OneRing<float>&, int);
template void make_odd_transparent(SubdivisionRun<double>&, const OneRing<double>&, int);
template void make_odd_transparent(SubdivisionRun<float>&, const Butterfly<float>&, int);
template void make_odd_transparent(SubdivisionRun<double>&, const Butterfly<double>&, int);
template void move_even_transparent(SubdivisionRun<float>&, const OneRing<float>&, int);
template void move_even_transparent(SubdivisionRun<double>&, const OneRing<double>&, int);
template void make_surface_transparent(SubdivisionRun<float>&, const OneRing<float>&, int,
                                       AttributeId, AttributeId);
template void make_surface_transparent(SubdivisionRun<double>&, const OneRing<double>&, int,
                                       AttributeId, AttributeId);
template void make_surface_transparent(SubdivisionRun<float>&, const Butterfly<float>&, int,
                                       AttributeId, AttributeId);
template void make_surface_transparent(SubdivisionRun<double>&, const Butterfly<double>&, int,
                                       AttributeId, AttributeId);

PLAIT_END_NAMESPACE
