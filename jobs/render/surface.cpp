#include "render/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "export/crease_normals.h"
#include "export/vertex_stream.h"
#include "plait/error.h"
#include "plait/extend/patch.h"
#include "plait/extend/store_access.h"
#include "render/drawn_surface.h"
#include "render/patch_normal.h"
#include "store/base_positions.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kMaxFittedVertices = 4'000'000;

using NormalPatches = StorePatches<Vector3<float>>;

bool is_double(const Store& store, AttributeId position) {
  return store.attributes()[position].schema.type == ComponentType::kFloat64;
}

AttributeId checked_position(const Store& store, int level) {
  const AttributeId position = position_of(store, "render");
  const int finest = store.attributes()[position].finest_level;
  if (level < store.base_level() || level > finest)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("render {}: level {}, expected {} to {}", store.path().native(), level,
                            store.base_level(), finest));
  return position;
}

template <class Visit>
void for_each_position(Store& store, AttributeId position, int level, Visit visit) {
  const bool wide = is_double(store, position);
  stream_vertices(store, std::span(&position, 1), level, [&](auto records, std::size_t count) {
    for (std::size_t vertex = 0; vertex < count; ++vertex) {
      if (wide) {
        Vector3<double> point;
        std::memcpy(&point, records[0].data() + vertex * sizeof(point), sizeof(point));
        visit(point);
      } else {
        Vector3<float> point;
        std::memcpy(&point, records[0].data() + vertex * sizeof(point), sizeof(point));
        visit(Vector3<double>{point.x, point.y, point.z});
      }
    }
  });
}

/// Gives the normals of a patch row by row, from the attribute or computed from positions.
template <class Real>
class NormalSource {
 public:
  using PositionPatch = typename StorePatches<Vector3<Real>>::Patch;

  NormalSource(Store& store, AttributeId position, int level, std::uint64_t share_bytes)
      : level_(level),
        size_(std::int64_t{1} << relative_to_base(level, store.base_level()).refinements),
        topology_(store.base().topology()),
        creases_(store, level) {
    const bool stored = store.has_attribute("normal") &&
                        store.attributes()[store.attribute("normal")].finest_level >= level;
    if (stored) {
      patches_.emplace(store, store.attribute("normal"), share_bytes);
      patches_->activate(level_, 1, 0);
    } else {
      base_normals_ = base_vertex_normals<Real>(
          topology_, std::as_const(store).template base_records<Vector3<Real>>(position));
    }
  }

  void enter(const PositionPatch& patch) {
    if (patches_) current_.emplace(patches_->patch(patch.face()));
    sides_.clear();
    const auto position = [&](std::int64_t i, std::int64_t j) {
      const Vector3<Real>& p = patch.at(level_, i, j);
      return Vector3<double>{p.x, p.y, p.z};
    };
    creases_.for_each(patch.face(), position,
                      [&](std::int64_t i, std::int64_t j, const Vector3<float>& normal) {
                        if (dot(normal, normal) > 0) sides_[patch_vertex(size_, i, j)] = normal;
                      });
  }
  Vector3<float> at(const PositionPatch& patch, std::int64_t i, std::int64_t j) const {
    if (!sides_.empty() && (i == 0 || j == 0 || i + j == size_))
      if (const auto side = sides_.find(patch_vertex(size_, i, j)); side != sides_.end())
        return side->second;
    if (current_) return current_->at(level_, i, j);
    if (is_corner(level_, i, j))
      return base_normals_[topology_
                               .faces[patch.face()][static_cast<std::size_t>(corner_of(i, j))]];
    return patch_normal(patch, level_, size_, i, j);
  }

 private:
  int level_;
  std::int64_t size_;
  Topology topology_;
  CreaseNormals creases_;
  std::unordered_map<std::int64_t, Vector3<float>> sides_;  ///< of the present face, at creases
  std::optional<NormalPatches> patches_;
  std::optional<NormalPatches::Patch> current_;
  std::vector<Vector3<float>> base_normals_;
};

template <class Real>
void draw_patches(Store& store, AttributeId position, int level, const Camera& camera,
                  const ColorBy& color_by, SampleBuffer& samples,
                  const ProgressCallback& progress) {
  // A share of the budget is for pins of positions, one for normals, one for the numbers of
  // colours.
  const std::uint64_t share_bytes = StoreAccess::pager(store).budget_bytes() / 4;
  NormalSource<Real> normals(store, position, level, share_bytes);
  StorePatches<Vector3<Real>> patches(store, position, share_bytes);
  patches.activate(level, 1, 0);
  const std::unique_ptr<ScalarPatches> colors =
      color_by.attribute.empty() ? nullptr
                                 : open_scalar(store, color_by.attribute, level, share_bytes);
  const std::int64_t size = std::int64_t{1}
                            << relative_to_base(level, store.base_level()).refinements;
  std::vector<RasterVertex> lower(static_cast<std::size_t>(size) + 1), upper = lower;
  const auto faces = static_cast<FaceId>(store.base().face_count());
  for (FaceId face = 0; face < faces; ++face) {
    const auto patch = patches.patch(face);
    normals.enter(patch);
    if (colors) colors->enter(face);
    const auto fetch = [&](std::vector<RasterVertex>& row, std::int64_t j) {
      for (std::int64_t i = 0; i <= size - j; ++i) {
        const Vector3<Real>& point = patch.at(level, i, j);
        RasterVertex& vertex = row[static_cast<std::size_t>(i)] = raster_vertex(
            camera.project({point.x, point.y, point.z}), camera.rotate(normals.at(patch, i, j)));
        if (colors) vertex.share = color_by.share(colors->at(i, j));
      }
    };
    fetch(lower, 0);
    for (std::int64_t j = 0; j < size; ++j) {
      fetch(upper, j + 1);
      const auto count = static_cast<std::size_t>(size - j);
      for (std::size_t i = 0; i < count; ++i) {
        samples.draw(lower[i], lower[i + 1], upper[i]);
        if (i + 1 < count) samples.draw(lower[i + 1], upper[i + 1], upper[i]);
      }
      lower.swap(upper);
    }
    if (progress && !progress({"render", face + 1, faces}))
      throw Error(ErrorCode::kCancelled, "render: cancelled");
  }
}

}  // namespace

Camera fitting_camera(Store& store, int level, const ViewAngles& view, UpAxis up, int width,
                      int height) {
  const AttributeId position = checked_position(store, level);
  int fitted = store.base_level();
  while (fitted < level &&
         counts_at_level(store.base(), relative_to_base(fitted + 1, store.base_level()).refinements)
                 .vertices <= kMaxFittedVertices)
    ++fitted;
  Bounds bounds;
  for_each_position(store, position, fitted, [&](const auto& point) { bounds.add(point); });
  Camera camera(bounds, view, up);
  Bounds screen;
  for_each_position(store, position, fitted, [&](const auto& point) {
    const ScreenPoint at = camera.project(point);
    screen.add({at.x, at.y, 0});
  });
  camera.fit(screen.low.x, screen.high.x, screen.low.y, screen.high.y, width, height);
  return camera;
}

void draw_surface(Store& store, int level, const Camera& camera, SampleBuffer& samples,
                  const ProgressCallback& progress, const ColorBy& color_by) {
  const AttributeId position = checked_position(store, level);
  if (store.has_depths())
    draw_drawn_surface(store, position, level, camera, samples, progress, color_by);
  else if (is_double(store, position))
    draw_patches<double>(store, position, level, camera, color_by, samples, progress);
  else
    draw_patches<float>(store, position, level, camera, color_by, samples, progress);
}

PLAIT_END_NAMESPACE
