#include "fused/base_rings.h"

#include <algorithm>

#include "butterfly/rings.h"
#include "fused/patch_lattice.h"
#include "mesh/mesh_region.h"
#include "plait/detail/one_ring.h"
#include "schemes/butterfly.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Writes one point to its lane.
template <class Real>
void put_point(Real* first, std::size_t point, const Vector3<Real>& v) {
  lattice_points::put(first + point * kPointNumbers, 0, v);
}

std::uint32_t count_faces(const Topology& mesh, VertexId vertex) {
  const FaceSide first = mesh.vertex_corners[vertex];
  std::uint32_t faces = 1;
  for (FaceSide at = mesh.next_corner(first); at.exists() && at != first; at = mesh.next_corner(at))
    ++faces;
  return faces;
}

}  // namespace

template <class Rule>
void BaseRings<Rule>::evaluate(std::span<const FaceId> faces) {
  clear();
  find(faces);
  finish();
}

template <class Rule>
std::vector<VertexId> BaseRings<Rule>::find_hubs(const Topology& mesh,
                                                 std::span<const VertexId> vertices) {
  std::vector<VertexId> hubs;
  for (const VertexId vertex : vertices)
    if (count_faces(mesh, vertex) >= kHubValence) hubs.push_back(vertex);
  return hubs;
}

template <class Rule>
std::vector<VertexId> BaseRings<Rule>::find_hubs(const BaseMesh& mesh) {
  const Topology topology = mesh.topology();
  if (mesh.region() != nullptr) return find_hubs(topology, mesh.region()->vertices);
  std::vector<VertexId> hubs;
  // Of a whole mesh, counting is faster than walks.
  std::vector<std::uint32_t> faces_at(topology.vertex_corners.size());
  for (const auto& corners : topology.faces)
    for (const VertexId vertex : corners) ++faces_at[vertex];
  for (VertexId vertex = 0; vertex < faces_at.size(); ++vertex)
    if (faces_at[vertex] >= kHubValence) hubs.push_back(vertex);
  return hubs;
}

template <class Rule>
void BaseRings<Rule>::evaluate_hubs(std::span<const VertexId> hubs) {
  clear();
  hub_corners_.clear();
  for (const VertexId vertex : hubs) {
    const auto number = static_cast<std::uint32_t>(vertices_.size());
    add(vertex, [&](FaceSide corner, int spoke) {
      hub_corners_.push_back({corner, {number, spoke}});
      return spoke_at(corner);
    });
  }
  std::ranges::sort(hub_corners_, {}, [](const HubCorner& hub) { return hub.corner.code; });
  finish();
}

template <class Rule>
std::uint64_t BaseRings<Rule>::hub_bytes(const BaseMesh& mesh, int levels) {
  std::uint64_t bytes = 0;
  for (const VertexId hub : find_hubs(mesh)) {
    const std::uint32_t faces = count_faces(mesh.topology(), hub);
    const RingShape at_most{static_cast<int>(faces) + 1, true, Rule::kRingCount};
    bytes +=
        at_most.points() * kPointNumbers * sizeof(Real) * static_cast<std::uint64_t>(levels + 1) +
        faces * sizeof(HubCorner);
  }
  return bytes;
}

template <class Rule>
void BaseRings<Rule>::clear() {
  vertices_.clear();
  rings_.clear();
  neighbour_count_ = 0;
}

/// Finds the vertices of the run, and the vertex of each corner of its faces.
template <class Rule>
void BaseRings<Rule>::find(std::span<const FaceId> faces) {
  faces_ = faces;
  one_by_one_ = faces.front() - faces.back() == faces.size() - 1;
  first_corner_ = 3 * faces.back();
  corners_.assign(3 * faces.size(), {kNoId, 0});
  hub_numbers_.assign(source_.hubs ? source_.hubs->vertices_.size() : 0, kNoId);
  find_spokes();
  for (std::size_t at = 0; at < faces.size(); ++at) {
    const std::size_t first = 3 * (one_by_one_ ? faces.size() - 1 - at : at);
    for (std::size_t side = 0; side < 3; ++side) {
      Corner& corner = corners_[first + side];
      if (corner.number != kNoId) continue;  // a walk around the vertex has come here
      const VertexId vertex = source_.mesh.faces[faces[at]][side];
      const auto number = static_cast<std::uint32_t>(vertices_.size());
      if (const Corner* const hub =
              source_.hubs ? source_.hubs->hub_at(FaceSide(faces[at], static_cast<int>(side)))
                           : nullptr) {
        std::uint32_t& hub_number = hub_numbers_[hub->number];
        if (hub_number == kNoId) {
          hub_number = number;
          vertices_.push_back(vertex);
          rings_.push_back(source_.hubs->rings_[hub->number]);
        }
        corner = {hub_number, hub->spoke};
        continue;
      }
      add(vertex, [&](FaceSide here, int spoke) {
        const std::uint32_t place = place_of(here);
        if (place >= corners_.size()) return spoke_at(here);
        corners_[place] = {number, spoke};
        return spokes_[place];
      });
    }
  }
}

/// Fills spokes_ before the walks around vertices, because in a walk each look-up would wait for
/// the one before. What the walks read is prefetched at the same time.
template <class Rule>
void BaseRings<Rule>::find_spokes() {
  constexpr std::size_t kFacesAhead = 16;
  const Topology& mesh = source_.mesh;
  const std::size_t count = faces_.size();
  const auto face_at = [&](std::size_t place) {
    return faces_[one_by_one_ ? count - 1 - place : place];
  };
  const auto prefetch = [&](std::size_t place) {
    if (place >= count) return;
    for (const EdgeId edge : mesh.face_edges[face_at(place)]) __builtin_prefetch(&mesh.edges[edge]);
    for (const VertexId vertex : mesh.faces[face_at(place)]) {
      __builtin_prefetch(&mesh.vertex_corners[vertex]);
      source_.prefetch(vertex);
    }
  };
  spokes_.resize(corners_.size());
  for (std::size_t place = 0; place < kFacesAhead; ++place) prefetch(place);
  for (std::size_t place = 0; place < count; ++place) {
    prefetch(place + kFacesAhead);
    for (std::uint32_t side = 0; side < 3; ++side)
      spokes_[3 * place + side] = spoke_at(face_at(place), side);
  }
}

/// Finds the next corner as Topology::next_corner() does, with one division.
template <class Rule>
auto BaseRings<Rule>::spoke_at(FaceId face, std::uint32_t corner) const -> Spoke {
  const std::uint32_t side = corner == 2 ? 0 : corner + 1;
  const Edge& edge = source_.mesh.edges[source_.mesh.face_edges[face][side]];
  Spoke spoke{{}, source_.mesh.faces[face][side]};
  spoke.next.code = edge.own.code ^ edge.other.code ^ (3 * face + side);
  if (spoke.next.exists()) spoke.next.code += spoke.next.code % 3 == 2 ? ~std::uint32_t{1} : 1;
  return spoke;
}

template <class Rule>
std::uint32_t BaseRings<Rule>::place_among(FaceSide corner) const {
  const auto found = std::ranges::lower_bound(faces_, corner.face(), std::ranges::greater());
  if (found == faces_.end() || *found != corner.face()) return kNoId;
  return 3 * static_cast<std::uint32_t>(found - faces_.begin()) +
         static_cast<std::uint32_t>(corner.side());
}

/// Returns nullptr if the vertex of the corner is not a hub.
template <class Rule>
auto BaseRings<Rule>::hub_at(FaceSide corner) const -> const Corner* {
  const auto found = std::ranges::lower_bound(hub_corners_, corner.code, {},
                                              [](const HubCorner& hub) { return hub.corner.code; });
  return found != hub_corners_.end() && found->corner == corner ? &found->at : nullptr;
}

/// Walks around a vertex once and collects its neighbours. Calls visit(FaceSide, spoke) for each
/// corner at the vertex; visit returns the Spoke of the corner.
template <class Rule>
template <class Visit>
void BaseRings<Rule>::add(VertexId vertex, Visit visit) {
  vertices_.push_back(vertex);
  const std::size_t ring = neighbour_count_;
  const auto add_neighbour = [&](VertexId neighbour) {
    if (neighbour_count_ == neighbours_.size()) neighbours_.resize(2 * neighbour_count_ + 64);
    neighbours_[neighbour_count_++] = neighbour;
  };
  const FaceSide first = source_.mesh.vertex_corners[vertex];
  bool border = false;
  int number = 0;
  for (FaceSide corner = first; number == 0 || corner != first; ++number) {
    const Spoke spoke = visit(corner, number);
    add_neighbour(spoke.neighbour);
    if (!spoke.next.exists()) {
      add_neighbour(
          source_.mesh.faces[corner.face()][static_cast<std::size_t>((corner.side() + 2) % 3)]);
      border = true;
      break;
    }
    corner = spoke.next;
  }
  rings_.push_back(
      {nullptr, ring, {static_cast<int>(neighbour_count_ - ring), border, Rule::kRingCount}});
}

/// Computes all levels of the vertices that add() has added.
template <class Rule>
void BaseRings<Rule>::finish() {
  place();
  fill_first_level();
  for (const Batch& batch : batches_) {
    const std::size_t level_numbers = batch.shape.points() * kPointNumbers;
    Real* from = points_.data() + batch.first;
    for (int level = source_.first_level(); level < source_.levels; ++level, from += level_numbers)
      source_.rule.ring_step({from, from + level_numbers, batch.shape.valence, batch.shape.border});
  }
}

/// Assigns batches and lanes. Vertices of one kind share batches. The results of unused lanes are
/// ignored.
template <class Rule>
void BaseRings<Rule>::place() {
  placed_.clear();
  batches_.clear();
  starts_.resize(rings_.size());
  const auto levels = static_cast<std::size_t>(source_.levels) -
                      static_cast<std::size_t>(source_.first_level()) + 1;
  std::size_t end = 0;
  for (std::uint32_t number = 0; number < rings_.size(); ++number) {
    const RingShape& shape = rings_[number].shape;
    if (rings_[number].first) continue;
    const auto kind = 2 * static_cast<std::size_t>(shape.valence) + (shape.border ? 1 : 0);
    if (kind >= lanes_.size()) lanes_.resize(kind + 1);
    Lanes& lanes = lanes_[kind];
    if (lanes.left == 0) {
      batches_.push_back({end, shape});
      lanes = {end, kPatchLanes};
      end += shape.points() * kPointNumbers * levels;
    }
    starts_[number] = lanes.next++;
    --lanes.left;
    placed_.push_back(number);
  }
  for (const Batch& batch : batches_)
    lanes_[2 * static_cast<std::size_t>(batch.shape.valence) + (batch.shape.border ? 1 : 0)] = {};
  if (const auto points = static_cast<std::int64_t>(end / kPointNumbers); points_.points() < points)
    points_ = LatticeBuffer<Real>(points);
  for (const std::uint32_t number : placed_)
    rings_[number].first = points_.data() + starts_[number];
}

template <class Rule>
void BaseRings<Rule>::fill_first_level() {
  for (const std::uint32_t number : placed_) {
    Real* const to = points_.data() + starts_[number];
    const RingShape& shape = rings_[number].shape;
    put_point(to, 0, source_.vertex(vertices_[number]));
    if constexpr (Rule::kRingCount > 1) {
      fill_two_rings(number, to);
      continue;
    }
    for (int spoke = 0; spoke < shape.valence; ++spoke)
      put_point(
          to, shape.first_neighbour() + static_cast<std::size_t>(spoke),
          source_.vertex(neighbours_[rings_[number].neighbours + static_cast<std::size_t>(spoke)]));
  }
  if constexpr (Rule::kRingCount == 1) return;
  for (const Batch& batch : batches_)
    if (batch.shape.border)
      butterfly::continue_ring(batch.shape.valence, points_.data() + batch.first);
}

/// Fills the two rings at level 1: the middles of the spokes, the other ends of the spokes, and the
/// middles of the edges between these ends.
template <class Rule>
void BaseRings<Rule>::fill_two_rings(std::uint32_t number, Real* to) {
  using enum RingPart;
  const std::size_t ring = rings_[number].neighbours;
  const RingShape& shape = rings_[number].shape;
  FaceSide corner = source_.mesh.vertex_corners[vertices_[number]];
  for (int spoke = 0; spoke < shape.valence; ++spoke) {
    put_point(to, shape.point(kFar, spoke),
              source_.vertex(neighbours_[ring + static_cast<std::size_t>(spoke)]));
    const bool last_of_border = shape.border && spoke == shape.valence - 1;
    const auto& edges = source_.mesh.face_edges[corner.face()];
    const auto side = static_cast<std::size_t>(corner.side());
    put_point(to, shape.point(kNear, spoke),
              source_.middles[edges[(side + (last_of_border ? 1 : 2)) % 3]]);
    if (last_of_border) return;
    put_point(to, shape.point(kBetween, spoke), source_.middles[edges[side]]);
    const FaceSide next = source_.mesh.next_corner(corner);
    if (next.exists()) corner = next;
  }
}

template <class Rule>
typename BaseRings<Rule>::View BaseRings<Rule>::view(std::uint32_t number, int level) const {
  const Rings& rings = rings_[number];
  const int levels_before = level - source_.first_level();
  return {
      rings.first + static_cast<std::size_t>(levels_before) * rings.shape.points() * kPointNumbers,
      rings.shape};
}

template class BaseRings<OneRing<float>>;
template class BaseRings<OneRing<double>>;
template class BaseRings<Butterfly<float>>;
template class BaseRings<Butterfly<double>>;

PLAIT_END_NAMESPACE
