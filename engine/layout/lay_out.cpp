#include <tbb/parallel_for.h>

#include <array>
#include <cstddef>
#include <utility>

#include "layout/spans.h"
#include "plait/layout.h"

namespace plait {
namespace {

struct Candidate {
  LayoutKind kind = LayoutKind::kGiven;
  std::vector<FaceId> order;
  LayoutSpans spans;
};

Candidate try_layout(const BaseMesh& mesh, LayoutKind kind) {
  Candidate candidate{kind, face_order(mesh, kind), {}};
  candidate.spans = layout::measure_spans(mesh, layout::number_edges(mesh, candidate.order));
  return candidate;
}

/// The candidates do not depend on each other; among equals the first one wins, so the choice does
/// not depend on who is ready first.
Candidate best_layout(const BaseMesh& mesh) {
  std::array<Candidate, 3> candidates;
  constexpr std::array kKinds{LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm};
  tbb::parallel_for(std::size_t{0}, kKinds.size(),
                    [&](std::size_t i) { candidates[i] = try_layout(mesh, kKinds[i]); });
  std::size_t best = 0;
  for (std::size_t i = 1; i < candidates.size(); ++i)
    if (candidates[i].spans.loop.span < candidates[best].spans.loop.span) best = i;
  return std::move(candidates[best]);
}

}  // namespace

LaidOutMesh lay_out(const BaseMesh& mesh, LayoutKind kind) {
  if (kind == LayoutKind::kGiven) return {mesh, kind, measure_spans(mesh)};
  const Candidate chosen =
      kind == LayoutKind::kAutomatic ? best_layout(mesh) : try_layout(mesh, kind);
  return {mesh.with_face_order(chosen.order), chosen.kind, chosen.spans};
}

}  // namespace plait
