#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "export/drawn_patch.h"
#include "export/format_writers.h"
#include "plait/extend/patch.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written to the file without conversion");

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFacetBytes = 50;  // normal, three corners, two bytes of attributes

void append_facet(std::vector<std::byte>& facets, const Vector3<float>& a, const Vector3<float>& b,
                  const Vector3<float>& c) {
  const auto wide = [](const Vector3<float>& at) { return Vector3<double>{at.x, at.y, at.z}; };
  // In double, so that the product of two short sides is not zero.
  const Vector3<double> normal = normalized(cross(wide(b) - wide(a), wide(c) - wide(a)));
  const Vector3<float> corners[] = {
      {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)},
      a,
      b,
      c};
  std::array<std::byte, kFacetBytes> facet{};
  std::memcpy(facet.data(), corners, sizeof(corners));
  facets.insert(facets.end(), facet.begin(), facet.end());
}

/// A vertex as the file has it.
struct Corner {
  Vector3<float> at;
  bool is_moved = false;
};

template <class Real>
class FacetWriter {
 public:
  FacetWriter(const ExportTask& task, OutputStream& output) : task_(task), output_(output) {}

  Moved write() {
    if (task_.store.has_depths())
      write_drawn();
    else
      write_patches();
    return moved_;
  }

 private:
  float narrow(Real number, bool& is_moved) {
    const auto written = static_cast<float>(number);
    if (std::isinf(written) && !std::isinf(number))
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("export {}: a coordinate {}, but STL files have float32 numbers only; "
                      ".ply and .obj files keep it",
                      task_.store.path().native(), number));
    const double error = std::isfinite(written) ? std::fabs(double{written} - double{number}) : 0;
    moved_.most = std::max(moved_.most, error);
    is_moved = is_moved || error > 0;
    return written;
  }
  Corner corner(const Vector3<Real>& at) {
    Corner corner;
    corner.at = {narrow(at.x, corner.is_moved), narrow(at.y, corner.is_moved),
                 narrow(at.z, corner.is_moved)};
    return corner;
  }
  void append(const Corner& a, const Corner& b, const Corner& c) {
    append_facet(facets_, a.at, b.at, c.at);
    if (a.is_moved || b.is_moved || c.is_moved) ++moved_.count;
  }
  void end_row() {
    output_.write(facets_);
    task_.progress(done_ += facets_.size() / kFacetBytes);
    facets_.clear();
  }

  void write_patches() {
    // Half of the budget stays pinned, because neighbouring faces use the same blocks.
    StorePatches<Vector3<Real>> patches(task_.store, task_.position,
                                        StoreAccess::pager(task_.store).budget_bytes() / 2);
    patches.activate(task_.level, 1, 0);
    const std::int64_t size = std::int64_t{1} << task_.patches.refinements();
    std::vector<Corner> lower(static_cast<std::size_t>(size) + 1), upper = lower;
    for (const FaceId face : task_.patches.faces()) {
      const auto patch = patches.patch(face);
      const auto fetch = [&](std::vector<Corner>& row, std::int64_t j) {
        for (std::int64_t i = 0; i <= size - j; ++i)
          row[static_cast<std::size_t>(i)] = corner(patch.at(task_.level, i, j));
      };
      fetch(lower, 0);
      for (std::int64_t j = 0; j < size; ++j) {
        fetch(upper, j + 1);
        const auto count = static_cast<std::size_t>(size - j);
        for (std::size_t i = 0; i < count; ++i) {
          append(lower[i], lower[i + 1], upper[i]);
          if (i + 1 < count) append(lower[i + 1], upper[i + 1], upper[i]);
        }
        end_row();
        std::swap(lower, upper);
      }
    }
  }

  void write_drawn() {
    DrawnPatch patch(task_.store, "position");
    for (const FaceId face : task_.patches.faces()) {
      patch.read(face, task_.patches.drawn(face));
      const auto at = [&](FacePoint point) { return corner(patch.at<Vector3<Real>>(point)); };
      for_each_drawn_triangle(
          patch.depths(),
          [&](FacePoint a, FacePoint b, FacePoint c) { append(at(a), at(b), at(c)); },
          [&] { end_row(); });
    }
  }

  const ExportTask& task_;
  OutputStream& output_;
  Moved moved_;
  std::vector<std::byte> facets_;
  std::uint64_t done_ = 0;
};

}  // namespace

Moved write_stl_level(const ExportTask& task, OutputStream& output) {
  // The first word must not be "solid", which marks a text file.
  std::string header = "plait: level " + std::to_string(task.level);
  header.resize(kHeaderBytes, ' ');
  output.write(header);
  const auto count = static_cast<std::uint32_t>(task.triangles());
  output.write(std::as_bytes(std::span(&count, 1)));
  if (task.schema(task.position).type == ComponentType::kFloat64)
    return FacetWriter<double>(task, output).write();
  return FacetWriter<float>(task, output).write();
}

PLAIT_END_NAMESPACE
