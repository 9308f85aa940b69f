#include "render/drawn_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "base/number_type.h"
#include "export/numbered_triangles.h"
#include "export/vertex_stream.h"
#include "job_rules.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kTrianglesBetweenReports = 1 << 16;

Vector3<float> narrow(const Vector3<double>& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// All vertices that are drawn, by their numbers.
class DrawnSurface {
 public:
  DrawnSurface(Store& store, const PatchSelection& patches) : store_(store), patches_(patches) {}

  void read(AttributeId position, int level, const ColorBy& color_by) {
    const bool has_normals = store_.has_attribute("normal") &&
                             store_.attributes()[store_.attribute("normal")].finest_level >= level;
    const std::uint64_t vertices = patches_.vertex_count();
    check_memory(fmt::format("render {}: {} vertices", store_.path().native(), vertices),
                 vertices * (sizeof(Vector3<double>) + sizeof(Vector3<float>) + sizeof(float) +
                             (has_normals ? 0 : sizeof(Vector3<double>))),
                 false);
    positions_.reserve(vertices);
    for_each_record(position, [&]<class Number>(std::span<const std::byte> record, Number) {
      const auto at = std::bit_cast<Vector3<Number>>(array_of<Number, 3>(record));
      positions_.push_back({double(at.x), double(at.y), double(at.z)});
    });
    if (has_normals)
      read_normals();
    else
      make_normals();
    if (color_by.attribute.empty() || color_by.is_depth) return;
    shares_.reserve(vertices);
    for_each_record(
        store_.attribute(color_by.attribute),
        [&]<class Number>(std::span<const std::byte> record, Number) {
          shares_.push_back(color_by.share(static_cast<double>(array_of<Number, 1>(record)[0])));
        });
  }

  void draw(const Camera& camera, SampleBuffer& samples, const ProgressCallback& progress,
            const ColorBy& color_by) const {
    const auto vertex = [&](FaceId face, std::uint64_t number) {
      const auto at = static_cast<std::size_t>(number);
      RasterVertex drawn =
          raster_vertex(camera.project(positions_[at]), camera.rotate(normals_[at]));
      if (color_by.is_depth)
        drawn.share = color_by.share(
            std::min(store_.depth(face), store_.base_level() + patches_.refinements()));
      else if (!shares_.empty())
        drawn.share = shares_[at];
      return drawn;
    };
    std::uint64_t next = 0;
    for_each_numbered_triangle(
        patches_,
        [&](FaceId face, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          samples.draw(vertex(face, a), vertex(face, b), vertex(face, c));
        },
        [&](std::uint64_t done) {
          if (done < next) return;
          next = done + kTrianglesBetweenReports;
          if (progress && !progress({"render", done, patches_.triangle_count()}))
            throw Error(ErrorCode::kCancelled, "render: cancelled");
        });
  }

 private:
  template <class Number, std::size_t count>
  static std::array<Number, count> array_of(std::span<const std::byte> record) {
    std::array<Number, count> numbers;
    std::memcpy(numbers.data(), record.data(), sizeof numbers);
    return numbers;
  }
  /// Calls visit(record, Number()) for each vertex.
  template <class Visit>
  void for_each_record(AttributeId attribute, Visit visit) {
    const AttributeSchema schema = store_.attributes()[attribute].schema;
    stream_vertices(
        store_, std::span(&attribute, 1), patches_, [&](auto records, std::size_t count) {
          with_number_type(schema.type, [&](auto number) {
            for (std::size_t vertex = 0; vertex < count; ++vertex)
              visit(records[0].subspan(vertex * schema.record_bytes(), schema.record_bytes()),
                    number);
          });
        });
  }
  void read_normals() {
    const AttributeId normal = store_.attribute("normal");
    StoreAccess::check_type(store_, normal, ComponentType::kFloat32, 3);
    normals_.reserve(positions_.size());
    for_each_record(normal, [&](std::span<const std::byte> record, auto) {
      normals_.push_back(std::bit_cast<Vector3<float>>(array_of<float, 3>(record)));
    });
  }
  void make_normals() {
    std::vector<Vector3<double>> sums(positions_.size());
    for_each_numbered_triangle(
        patches_,
        [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          const Vector3<double> normal =
              cross(positions_[b] - positions_[a], positions_[c] - positions_[a]);
          for (const std::uint64_t vertex : {a, b, c}) sums[vertex] = sums[vertex] + normal;
        },
        [](std::uint64_t) {});
    normals_.reserve(sums.size());
    for (const Vector3<double>& sum : sums) normals_.push_back(narrow(normalized(sum)));
  }

  Store& store_;
  const PatchSelection& patches_;
  std::vector<Vector3<double>> positions_;
  std::vector<Vector3<float>> normals_;
  std::vector<float> shares_;
};

}  // namespace

void draw_drawn_surface(Store& store, AttributeId position, int level, const Camera& camera,
                        SampleBuffer& samples, const ProgressCallback& progress,
                        const ColorBy& color_by) {
  const PatchSelection patches(store.base(),
                               relative_to_base(level, store.base_level()).refinements,
                               all_faces(store.base()));
  DrawnSurface surface(store, patches);
  surface.read(position, level, color_by);
  surface.draw(camera, samples, progress, color_by);
}

PLAIT_END_NAMESPACE
