
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "base/threads.h"
#include "layout/spans.h"
#include "plait/error.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct Candidate {
  LayoutKind kind = LayoutKind::kGiven;
  std::vector<FaceId> order;
  std::uint64_t span = 0;
};

Candidate try_layout(const BaseMesh& mesh, LayoutKind kind) {
  Candidate candidate{kind, face_order(mesh, kind)};
  candidate.span = layout::measure_loop_span(mesh, layout::number_edges(mesh, candidate.order));
  return candidate;
}

/// The candidates do not depend on each other. Among equal spans the first candidate wins, so the
/// choice does not depend on which thread finishes first.
Candidate best_layout(const BaseMesh& mesh) {
  std::array<Candidate, 3> candidates;
  constexpr std::array kKinds{LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm};
  // The longest first: the calling thread computes it, and it is the one that can be interrupted.
  each_on_workers(std::size_t{0}, kKinds.size(), [&](std::size_t turn) {
    const std::size_t i = kKinds.size() - 1 - turn;
    candidates[i] = try_layout(mesh, kKinds[i]);
  });
  std::size_t best = 0;
  for (std::size_t i = 1; i < candidates.size(); ++i)
    if (candidates[i].span < candidates[best].span) best = i;
  return std::move(candidates[best]);
}

}  // namespace

LaidOutMesh lay_out(const BaseMesh& mesh, LayoutKind kind) try {
  if (kind == LayoutKind::kGiven) return {mesh, kind, measure_spans(mesh)};
  const Candidate chosen =
      kind == LayoutKind::kAutomatic ? best_layout(mesh) : Candidate{kind, face_order(mesh, kind)};
  LaidOutMesh result{mesh.with_face_order(chosen.order), chosen.kind, {}};
  result.spans = measure_spans(result.mesh);
  return result;
} catch (const std::bad_alloc&) {
  throw out_of_memory("lay out the mesh");
}

PLAIT_END_NAMESPACE
