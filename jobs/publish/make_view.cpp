#include "publish/make_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "export/drawn_patch.h"
#include "format/file_names.h"
#include "format/view_file.h"
#include "plait/detail/drawn_triangles.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/patch.h"
#include "plait/extend/store_access.h"
#include "store/base_positions.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The square of how far a new vertex is from the middle of the two between which it was born.
template <class Real>
double squared_step(const Vector3<Real>& from, const Vector3<Real>& at, const Vector3<Real>& to) {
  double squares = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double off = static_cast<double>(at[axis]) -
                       0.5 * (static_cast<double>(from[axis]) + static_cast<double>(to[axis]));
    squares += off * off;
  }
  return squares;
}

/// The largest squared_step() of the vertices that a patch gets at a depth; at(i, j) gives those of
/// its grid.
template <class At>
double largest_step(int depth, At at) {
  const std::int64_t size = std::int64_t{1} << depth;
  double most = 0;
  const auto look = [&](std::int64_t i, std::int64_t j, std::int64_t di, std::int64_t dj) {
    most = std::max(
        most, squared_step(at(i - di, j - dj), at(i, j), at(i + di, j + dj)));  // not for a NaN
  };
  for (std::int64_t j = 0; j <= size; ++j)
    for (std::int64_t i = j % 2 == 0 ? 1 : 0; i <= size - j; i += j % 2 == 0 ? 2 : 1)
      if (j % 2 == 0)
        look(i, j, 1, 0);
      else if (i % 2 == 0)
        look(i, j, 0, 1);
      else
        look(i, j, 1, -1);
  return most;
}

/// The steps of the vertices that each level adds to a face, the largest ones: [refinement - 1].
template <class Real>
class Steps {
 public:
  Steps(Store& store, AttributeId position)
      : patches_(store, position, StoreAccess::pager(store).budget_bytes() / 2),
        base_level_(store.base_level()),
        levels_(store.attributes()[position].finest_level - base_level_) {
    if (levels_ > 0) patches_.activate(base_level_ + levels_, 1, 0);
  }

  std::vector<double> of(FaceId face) {
    std::vector<double> steps(static_cast<std::size_t>(levels_));
    const auto patch = patches_.patch(face);
    for (int depth = 1; depth <= levels_; ++depth)
      steps[static_cast<std::size_t>(depth - 1)] = std::sqrt(largest_step(
          depth, [&](std::int64_t i, std::int64_t j) -> const auto& {
            return patch.at(base_level_ + depth, i, j);
          }));
    return steps;
  }

 private:
  StorePatches<Vector3<Real>> patches_;
  int base_level_, levels_;
};

/// The same where faces have depths of their own. The vertices that only a deeper neighbour has on
/// a side count for both faces.
template <class Real>
class StepsOfDepths {
 public:
  StepsOfDepths(Store& store, AttributeId position)
      : patch_(store, "position"),
        base_(store.base()),
        mesh_(base_.topology()),
        levels_(store.attributes()[position].finest_level - store.base_level()) {}

  std::vector<double> of(FaceId face) {
    std::vector<double> steps(static_cast<std::size_t>(levels_));
    const DrawnDepths drawn = drawn_depths(
        mesh_, face, [&](FaceId each) { return std::min(levels_, base_.depths()->of(each)); });
    patch_.read(face, drawn);
    for (int depth = 1; depth <= drawn.grid(); ++depth) {
      const int shift = drawn.grid() - depth;
      const auto at = [&](std::int64_t i, std::int64_t j) -> const Vector3<Real>& {
        return patch_.template at<Vector3<Real>>({i << shift, j << shift});
      };
      steps[static_cast<std::size_t>(depth - 1)] =
          std::sqrt(depth <= drawn.face ? largest_step(depth, at) : on_sides(drawn, depth, at));
    }
    return steps;
  }

 private:
  template <class At>
  static double on_sides(const DrawnDepths& drawn, int depth, At at) {
    const std::int64_t size = std::int64_t{1} << depth;
    double most = 0;
    for (std::int64_t k = 1; k < size; k += 2) {
      const std::int64_t rest = size - k;
      if (drawn.sides[0] >= depth)
        most = std::max(most, squared_step(at(rest + 1, k - 1), at(rest, k), at(rest - 1, k + 1)));
      if (drawn.sides[1] >= depth)
        most = std::max(most, squared_step(at(0, k - 1), at(0, k), at(0, k + 1)));
      if (drawn.sides[2] >= depth)
        most = std::max(most, squared_step(at(k - 1, 0), at(k, 0), at(k + 1, 0)));
    }
    return most;
  }

  DrawnPatch patch_;
  BaseMesh base_;
  Topology mesh_;
  int levels_;
};

/// A patch that is drawn with its coarser levels is not farther from the finest one than the steps
/// of the levels that it lacks are long together: each level adds to the one before a piecewise
/// linear function that is largest at the new vertices.
template <class Steps>
void fill_errors(Store& store, AttributeId position, View& view, const ProgressCallback& progress) {
  Steps steps(store, position);
  const std::size_t faces = store.base().face_count();
  const auto levels =
      static_cast<std::size_t>(store.attributes()[position].finest_level - store.base_level());
  view.errors.resize(levels * faces);
  for (std::size_t face = 0; face < faces; ++face) {
    const std::vector<double> of_face = steps.of(static_cast<FaceId>(face));
    double sum = 0;
    for (std::size_t depth = levels; depth-- > 0;) {
      sum += of_face[depth];
      // Rounded up, as the format promises that nothing is farther away.
      view.errors[depth * faces + face] =
          std::nextafter(static_cast<float>(sum), std::numeric_limits<float>::max());
      if (sum == 0) view.errors[depth * faces + face] = 0;
    }
    if ((face % 256 == 0 || face + 1 == faces) && progress && !progress({"view", face + 1, faces}))
      throw Error(ErrorCode::kCancelled, "view: cancelled");
  }
}

template <class Real>
void fill(Store& store, AttributeId position, View& view, std::vector<Vector3<double>>& base,
          const ProgressCallback& progress) {
  for (const Vector3<Real>& at :
       std::as_const(store).template base_records<Vector3<Real>>(position))
    base.push_back(
        {static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)});
  if (store.has_depths())
    fill_errors<StepsOfDepths<Real>>(store, position, view, progress);
  else
    fill_errors<Steps<Real>>(store, position, view, progress);
}

std::span<const std::uint8_t> depths_of(const Store& store) {
  const FaceDepths* const depths = store.base().depths();
  if (depths == nullptr) return {};
  return depths->of_faces();
}

}  // namespace

std::vector<ViewedFile> viewed_files(const Store& store) {
  const Store::Implementation& state = StoreAccess::state(store);
  std::vector<ViewedFile> files;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const std::uint32_t number = state.attributes[id].record.number;
    files.push_back({base_file_name(number, store.sequence()), id, store.base_level(),
                     store.base_bytes(id).size()});
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level;
         ++level) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      files.push_back({level_file_name(number, level, file.table.generation()), id, level,
                       file.geometry.total_bytes()});
    }
  }
  return files;
}

std::vector<std::byte> make_view(Store& store, const ProgressCallback& progress) {
  const AttributeId position = position_of(store, "view of");
  View view;
  view.store = StoreAccess::state(std::as_const(store)).uuid;
  view.version = store.sequence();
  view.base_level = store.base_level();
  view.position = position;
  view.depths = depths_of(store);
  for (const AttributeInfo& info : store.attributes())
    view.attributes.push_back({info.schema, {}, {}});
  for (ViewedFile& file : viewed_files(store)) {
    ViewAttribute& attribute = view.attributes[file.attribute];
    if (file.level == store.base_level())
      attribute.base_file = std::move(file.name);
    else
      attribute.level_files.push_back(std::move(file.name));
  }
  std::vector<Vector3<double>> base;
  if (store.attributes()[position].schema.type == ComponentType::kFloat32)
    fill<float>(store, position, view, base, progress);
  else
    fill<double>(store, position, view, base, progress);
  return encode_view(view, store.base(), base);
}

std::vector<std::byte> view_of(Store& store, const ProgressCallback& progress) {
  const Store::Implementation& state = StoreAccess::state(std::as_const(store));
  if (state.on_disk()) {
    std::vector<std::byte> bytes = read_view_file(
        state.directory,
        {state.uuid, store.base().vertex_count(), store.base().face_count(), depths_of(store)});
    if (!bytes.empty() && view_version(bytes) == store.sequence()) return bytes;
  }
  return make_view(store, progress);
}

PLAIT_END_NAMESPACE
