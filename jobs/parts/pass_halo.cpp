#include "parts/pass_halo.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "mesh/face_rings.h"
#include "parts/pass_result.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "store/part_halo.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// With more, nearly all of what a part computes would be what other parts compute too.
constexpr std::size_t kMostRings = 16;

/// The rings of all iterations but the last, widest first.
std::vector<std::size_t> rings_of_all(const Pass& pass, const PassIterations& iterations) {
  std::vector<std::size_t> rings;
  for (std::uint32_t left = iterations.count - 1; left > 0; --left)
    rings.push_back(iterations.rings(pass, left));
  return rings;
}

/// The faces at these edges.
std::uint64_t face_count_at(const Topology& mesh, const std::vector<EdgeId>& edges) {
  std::vector<FaceId> faces;
  for (const EdgeId edge : edges)
    for (const FaceSide side : {mesh.edges[edge].own, mesh.edges[edge].other})
      if (side.exists()) faces.push_back(side.face());
  std::ranges::sort(faces);
  return static_cast<std::uint64_t>(std::unique(faces.begin(), faces.end()) - faces.begin());
}

}  // namespace

std::size_t PassIterations::rings(const Pass& pass, std::uint32_t left) const {
  const std::uint64_t reach = pass.name == "noise" ? 0 : left;
  const std::uint64_t steps = std::uint64_t{1} << refinements;
  return static_cast<std::size_t>((reach + steps - 1) / steps);
}

void check_iterations(const Pass& pass, const PassIterations& iterations) {
  const auto refuse = [&](const std::string& reason) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("pass '{}': {} iterations in one plan: {}",
                                                         pass.name, iterations.count, reason));
  };
  if (iterations.count < 1 || iterations.count > kMostIterations)
    refuse(fmt::format("expected 1 to {}", kMostIterations));
  if (iterations.count == 1) return;
  if (pass.name == "normals")
    refuse("normals are made of positions, so each iteration would make the same; one is enough");
  if (pass.name == "noise" && !pass.diagonal)
    refuse("each one would measure the diagonal of what the one before made; give the diagonal");
  if (const std::size_t rings = iterations.rings(pass, iterations.count - 1); rings > kMostRings)
    refuse(
        fmt::format("they read {} rings of base faces around a part, expected at most {}: plan "
                    "at most {} at once",
                    rings, kMostRings, (kMostRings << iterations.refinements) + 1));
}

void add_iterations(std::vector<PlannedPart>& parts, const Topology& mesh, const PartCost& cost,
                    const Pass& pass, const PassIterations& iterations) {
  const std::vector<std::size_t> rings = rings_of_all(pass, iterations);
  if (rings.empty()) return;
  FaceRings around(mesh);
  for (PlannedPart& part : parts) {
    const std::uint64_t own = part.faces - part.ghosts, touched = part.faces;
    around.begin(part.first_edge, part.edge_after);
    while (around.rings() < rings.front() && around.grow()) {
    }
    for (std::size_t at = 0; at < rings.size();) {
      const std::size_t ring = rings[at];
      const std::size_t first = at;
      while (at < rings.size() && rings[at] == ring) ++at;
      std::uint64_t records = part.records, faces = touched;
      if (ring > 0) {
        const std::vector<EdgeId> edges = around.edges(ring);
        faces = face_count_at(mesh, edges);
        records = 0;
        for (const EdgeId edge : edges) records += cost.records(mesh.edges[edge]);
      }
      part.faces = std::max(part.faces, faces);
      part.seconds += 1e-9 * static_cast<double>(at - first) *
                      (cost.ns_per_record * static_cast<double>(records) +
                       cost.of_face() * static_cast<double>(faces));
    }
    part.ghosts = part.faces - own;
  }
}

AttributeId make_iterations(Store& store, const Pass& pass, const PassIterations& iterations,
                            const VisitOptions& options) {
  std::string phase;
  VisitOptions how = options;
  if (options.progress && iterations.count > 1)
    how.progress = [&](Progress now) {
      now.phase = phase;
      return options.progress(now);
    };
  const auto make = [&](std::uint32_t number) {
    phase = fmt::format("{} {}/{}", pass.name, number, iterations.count);
    return make_result(store, pass, how);
  };
  const std::vector<std::size_t> rings = rings_of_all(pass, iterations);
  if (rings.empty()) return make(1);
  const EdgeRange range = StoreAccess::edges(store);
  HaloRegion own;
  own.edges.resize(range.after - range.first);
  std::iota(own.edges.begin(), own.edges.end(), range.first);
  own.vertices = *StoreAccess::own_vertices(store);
  FaceRings around(store.base().topology());
  around.begin(range.first, range.after);
  while (around.rings() < rings.front() && around.grow()) {
  }
  AttributeId result = store.attribute(pass.result.name);
  for (std::size_t at = 0; at < rings.size(); ++at) {
    const std::size_t ring = rings[at];
    begin_halo(store, result,
               ring == 0 ? own : HaloRegion{around.edges(ring), around.vertices(ring)});
    result = make(static_cast<std::uint32_t>(at + 1));
  }
  end_halo(store);
  return make(iterations.count);
}

PLAIT_END_NAMESPACE
