#include "export/crease_normals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/notes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::span<const std::uint8_t> stored_sides(const Store& store) {
  for (const AttributeSchema& schema : store.notes().face_attributes())
    if (schema.name == kCreaseSides)
      return store.notes().face_records<std::uint8_t>(std::string(kCreaseSides));
  return {};
}

}  // namespace

CreasePoints::CreasePoints(const Store& store, int level)
    : size_(std::int64_t{1} << relative_to_base(level, store.base_level()).refinements) {
  const std::span<const std::uint8_t> sides = stored_sides(store);
  const auto other = std::ranges::find_if(sides, [](std::uint8_t bits) { return bits > 7; });
  if (other != sides.end())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: face attribute '{}', face {}: expected 0 to 7, a bit for each "
                            "side, found {}",
                            store.path().native(), kCreaseSides, other - sides.begin(), *other));
  if (std::ranges::all_of(sides, [](std::uint8_t bits) { return bits == 0; })) return;
  marks_.assign(sides.begin(), sides.end());
  const Topology mesh = store.base().topology();
  std::vector<bool> on_crease(store.base().vertex_count(), false);
  for (FaceId face = 0; face < marks_.size(); ++face)
    for (int side = 0; side < 3; ++side) {
      if (!is_crease(FaceSide(face, side))) continue;
      const FaceSide beyond = mesh.across(FaceSide(face, side));
      if (beyond.exists()) marks_[beyond.face()] |= static_cast<std::uint8_t>(1u << beyond.side());
      for (const int next : {1, 2})
        on_crease[mesh.faces[face][static_cast<std::size_t>((side + next) % 3)]] = true;
    }
  for (FaceId face = 0; face < marks_.size(); ++face)
    for (int corner = 0; corner < 3; ++corner)
      if (on_crease[mesh.faces[face][static_cast<std::size_t>(corner)]])
        marks_[face] |= static_cast<std::uint8_t>(8u << corner);
}

std::uint64_t CreasePoints::vertex_count(const BaseMesh& base,
                                         std::span<const FaceId> faces) const {
  if (empty()) return 0;
  const Topology mesh = base.topology();
  std::vector<bool> vertices(base.vertex_count(), false), edges(base.edge_count(), false);
  for (const FaceId face : faces)
    for (int at = 0; at < 3; ++at) {
      const auto place = static_cast<std::size_t>(at);
      if (is_crease_corner(face, at)) vertices[mesh.faces[face][place]] = true;
      if (is_crease(FaceSide(face, at))) edges[mesh.face_edges[face][place]] = true;
    }
  const auto count = [](const std::vector<bool>& flags) {
    return static_cast<std::uint64_t>(std::count(flags.begin(), flags.end(), true));
  };
  return count(vertices) + count(edges) * static_cast<std::uint64_t>(size_ - 1);
}

PatchPositions::PatchPositions(const Store& store, int level)
    : reader_(store, {.attributes = {"position"}, .policy = EvictionPolicy::kLayoutOrder}),
      level_(level),
      wide_(store.attributes()[store.attribute("position")].schema.type ==
            ComponentType::kFloat64) {}

void PatchPositions::read(FaceId face) {
  records_.reset();
  patch_.emplace(reader_.read_patch(face, level_));
  records_.emplace(std::as_const(*patch_).records("position"));
}

Vector3<double> PatchPositions::at(std::int64_t i, std::int64_t j) const {
  const std::span<const std::byte> record = records_->at(i, j);
  Vector3<double> position;
  if (wide_) {
    std::memcpy(&position, record.data(), sizeof position);
    return position;
  }
  Vector3<float> narrow;
  std::memcpy(&narrow, record.data(), sizeof narrow);
  return {narrow.x, narrow.y, narrow.z};
}

CreaseNormals::CreaseNormals(const Store& store, int level, const std::function<void()>& go_on)
    : points_(store, level) {
  if (points_.empty()) return;
  const Topology mesh = store.base().topology();
  const auto faces = static_cast<FaceId>(store.base().face_count());
  const std::int64_t size = points_.size();
  // Of the triangle at each corner.
  std::vector<Vector3<double>> areas(3 * std::size_t{faces});
  PatchPositions positions(store, level);
  for (FaceId face = 0; face < faces; ++face) {
    if (go_on) go_on();
    if (!points_.is_crease_corner(face, 0) && !points_.is_crease_corner(face, 1) &&
        !points_.is_crease_corner(face, 2))
      continue;
    positions.read(face);
    const auto area = [&](std::array<std::int64_t, 2> a, std::array<std::int64_t, 2> b,
                          std::array<std::int64_t, 2> c) {
      const Vector3<double> p = positions.at(a[0], a[1]);
      return cross(positions.at(b[0], b[1]) - p, positions.at(c[0], c[1]) - p);
    };
    Vector3<double>* const of_face = areas.data() + 3 * std::size_t{face};
    of_face[0] = area({0, 0}, {1, 0}, {0, 1});
    of_face[1] = area({size, 0}, {size - 1, 1}, {size - 1, 0});
    of_face[2] = area({0, size}, {0, size - 1}, {1, size - 1});
  }
  corner_normals_.resize(areas.size());
  const auto across = [&](FaceSide side) {
    return points_.is_crease(side) ? FaceSide() : mesh.across(side);
  };
  const auto after = [&](FaceSide corner) {
    const FaceSide beyond = across(FaceSide(corner.face(), (corner.side() + 1) % 3));
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
  };
  const auto before = [&](FaceSide corner) {
    const FaceSide beyond = across(FaceSide(corner.face(), (corner.side() + 2) % 3));
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 2) % 3) : FaceSide();
  };
  for (FaceId face = 0; face < faces; ++face)
    for (int corner = 0; corner < 3; ++corner) {
      const FaceSide here(face, corner);
      // The first corner of a side sums for all.
      if (!points_.is_crease_corner(face, corner) || before(here).exists()) continue;
      Vector3<double> sum{};
      for (FaceSide at = here; at.exists(); at = after(at)) sum = sum + areas[at.code];
      const Vector3<double> unit = normalized(sum);
      const Vector3<float> normal = {static_cast<float>(unit.x), static_cast<float>(unit.y),
                                     static_cast<float>(unit.z)};
      for (FaceSide at = here; at.exists(); at = after(at)) corner_normals_[at.code] = normal;
    }
}

PLAIT_END_NAMESPACE
