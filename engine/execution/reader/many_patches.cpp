// Many patches in one call: their records, and the numbers of the vertices that they share.
#include <fmt/format.h>

#include <limits>
#include <unordered_map>

#include "execution/reader/reader_state.h"
#include "io/huge_pages.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint32_t kNotYet = std::numeric_limits<std::uint32_t>::max();

/// The place in row order of the point `step` steps along side `side`, which runs from corner side
/// + 1 to corner side + 2.
std::size_t place_on_side(std::int64_t size, int side, std::int64_t step) {
  const std::int64_t from = size - step;
  const auto [i, j] = side == 0   ? std::pair{from, step}
                      : side == 1 ? std::pair{std::int64_t{0}, from}
                                  : std::pair{step, std::int64_t{0}};
  return static_cast<std::size_t>(patch_vertex(size, i, j));
}

/// Numbers the points of one patch after another.
class Welder {
 public:
  Welder(const Topology& mesh, std::int64_t size, std::span<std::uint32_t> numbers)
      : mesh_(mesh), size_(size), points_(patch_vertex_count(size)), numbers_(numbers) {}

  void add(FaceId face) {
    if (!patch_of_.emplace(face, patches_).second)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("weld patches: face {} is named twice", face));
    const std::span<std::uint32_t> own = patch(patches_++);
    std::ranges::fill(own, kNotYet);
    for (int side = 0; side < 3; ++side) take_side(face, side, own);
    for (int corner = 0; corner < 3; ++corner)
      if (const auto known = corners_.find(vertex_at(face, corner)); known != corners_.end())
        own[place_of_corner(corner)] = known->second;
    for (std::uint32_t& number : own)
      if (number == kNotYet) number = vertex_count_++;
    for (int corner = 0; corner < 3; ++corner)
      corners_.emplace(vertex_at(face, corner), own[place_of_corner(corner)]);
  }
  std::uint64_t vertex_count() const { return vertex_count_; }

 private:
  std::span<std::uint32_t> patch(std::size_t number) const {
    return numbers_.subspan(number * points_, points_);
  }
  VertexId vertex_at(FaceId face, int corner) const {
    return mesh_.faces[face][static_cast<std::size_t>(corner)];
  }
  /// A side begins at the corner after the one that it is opposite.
  std::size_t place_of_corner(int corner) const {
    return place_on_side(size_, (corner + 2) % 3, 0);
  }
  /// The numbers that the patch across a side has, if it was there before.
  void take_side(FaceId face, int side, std::span<std::uint32_t> own) const {
    const FaceSide beyond = mesh_.across(FaceSide(face, side));
    if (!beyond.exists()) return;
    const auto known = patch_of_.find(beyond.face());
    if (known == patch_of_.end() || known->second + 1 == patches_) return;
    const std::span<const std::uint32_t> other = patch(known->second);
    for (std::int64_t step = 0; step <= size_; ++step)
      own[place_on_side(size_, side, step)] =
          other[place_on_side(size_, beyond.side(), size_ - step)];
  }

  const Topology& mesh_;
  std::int64_t size_;
  std::size_t points_, patches_ = 0;
  std::span<std::uint32_t> numbers_;
  std::uint32_t vertex_count_ = 0;
  std::unordered_map<FaceId, std::size_t> patch_of_;
  std::unordered_map<VertexId, std::uint32_t> corners_;
};

}  // namespace

void Reader::copy_patches(std::string_view attribute, std::span<const FaceId> faces, int level,
                          std::span<std::byte> to) const {
  const State::Attribute& of = state_->attributes[state_->number_of(attribute)];
  state_->check_level(of, level);
  const std::int64_t size = std::int64_t{1}
                            << relative_to_base(level, state_->base_level).refinements;
  const std::uint64_t patch_bytes = patch_vertex_count(size) * of.schema.record_bytes();
  if (to.size() % patch_bytes != 0 || to.size() / patch_bytes != faces.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("copy {} patches of '{}': expected {} bytes for each, found {} bytes",
                            faces.size(), attribute, patch_bytes, to.size()));
  for_each_patch(faces, level, [&, at = std::size_t{0}](const PatchView& patch) mutable {
    touch_huge_pages(to, at, patch_bytes);
    patch.records(attribute).copy_to(to.subspan(at, patch_bytes));
    at += patch_bytes;
  });
}

std::uint64_t Reader::weld_patches(std::span<const FaceId> faces, int level,
                                   std::span<std::uint32_t> numbers) const try {
  state_->check_usable();
  const int refinements = relative_to_base(level, state_->base_level).refinements;
  constexpr int kMost = 15;  // as patch_indices()
  if (refinements < 0 || refinements > kMost)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("weld patches at level {}: expected {} to {}", level,
                            state_->base_level, state_->base_level + kMost));
  const std::int64_t size = std::int64_t{1} << refinements;
  const std::uint64_t points = patch_vertex_count(size);
  if (numbers.size() / points != faces.size() || numbers.size() % points != 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("weld {} patches: expected room for {} numbers for each, found {}",
                            faces.size(), points, numbers.size()));
  if (numbers.size() > kNotYet)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("weld patches: {} points, expected {} at most: take fewer faces or a "
                            "coarser level",
                            numbers.size(), kNotYet));
  const Topology mesh = state_->store->base.topology();
  Welder welder(mesh, size, numbers);
  for (const FaceId face : faces) {
    if (face >= mesh.faces.size())
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("weld patches: expected a face below {}, found {}", mesh.faces.size(), face));
    state_->check_depth(face, level);
    welder.add(face);
  }
  return welder.vertex_count();
} catch (const std::bad_alloc&) {
  throw out_of_memory("weld patches");
}

PLAIT_END_NAMESPACE
