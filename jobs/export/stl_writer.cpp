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

template <class Real>
Moved write_facets(const ExportTask& task, OutputStream& output) {
  Moved moved;
  const auto narrow = [&](Real number, std::uint8_t& is_moved) {
    const auto written = static_cast<float>(number);
    if (std::isinf(written) && !std::isinf(number))
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("export {}: a coordinate {}, but STL files have float32 numbers only; "
                      ".ply and .obj files keep it",
                      task.store.path().native(), number));
    const double error = std::isfinite(written) ? std::fabs(double{written} - double{number}) : 0;
    moved.most = std::max(moved.most, error);
    if (error > 0) is_moved = 1;
    return written;
  };
  // Half of the budget stays pinned, because neighbouring faces use the same blocks.
  StorePatches<Vector3<Real>> patches(task.store, task.position,
                                      StoreAccess::pager(task.store).budget_bytes() / 2);
  patches.activate(task.level, 1, 0);
  const std::int64_t size = std::int64_t{1} << task.patches.refinements();
  struct Row {
    std::vector<Vector3<float>> at;
    std::vector<std::uint8_t> is_moved;
  };
  const auto length = static_cast<std::size_t>(size) + 1;
  Row lower{std::vector<Vector3<float>>(length), std::vector<std::uint8_t>(length)}, upper = lower;
  std::vector<std::byte> facets;
  std::uint64_t done = 0;
  for (const FaceId face : task.patches.faces()) {
    const auto patch = patches.patch(face);
    const auto fetch = [&](Row& row, std::int64_t j) {
      for (std::int64_t i = 0; i <= size - j; ++i) {
        const Vector3<Real>& at = patch.at(task.level, i, j);
        const auto place = static_cast<std::size_t>(i);
        std::uint8_t is_moved = 0;
        row.at[place] = {narrow(at.x, is_moved), narrow(at.y, is_moved), narrow(at.z, is_moved)};
        row.is_moved[place] = is_moved;
      }
    };
    const auto append = [&](const Row& first, std::size_t a, const Row& second, std::size_t b,
                            const Row& third, std::size_t c) {
      append_facet(facets, first.at[a], second.at[b], third.at[c]);
      if (first.is_moved[a] + second.is_moved[b] + third.is_moved[c] > 0) ++moved.count;
    };
    fetch(lower, 0);
    for (std::int64_t j = 0; j < size; ++j) {
      fetch(upper, j + 1);
      facets.clear();
      const auto count = static_cast<std::size_t>(size - j);
      for (std::size_t i = 0; i < count; ++i) {
        append(lower, i, lower, i + 1, upper, i);
        if (i + 1 < count) append(lower, i + 1, upper, i + 1, upper, i);
      }
      output.write(facets);
      task.progress(done += 2 * count - 1);
      std::swap(lower, upper);
    }
  }
  return moved;
}

}  // namespace

Moved write_stl_level(const ExportTask& task, OutputStream& output) {
  // The first word must not be "solid", which marks a text file.
  std::string header = "plait: level " + std::to_string(task.level);
  header.resize(kHeaderBytes, ' ');
  output.write(header);
  const auto count = static_cast<std::uint32_t>(task.triangles());
  output.write(std::as_bytes(std::span(&count, 1)));
  if (task.schema(task.position).type == ComponentType::kFloat64)
    return write_facets<double>(task, output);
  return write_facets<float>(task, output);
}

PLAIT_END_NAMESPACE
