#include "remesh/scan_face_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>

#include "base/number_type.h"
#include "base/threads.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kFacesAskedAtOnce = 16;

/// A small face: the record of the scan that it has, and its area.
struct SmallFace {
  FaceId record;
  double area;
};

bool is_colour(const std::string& name) {
  return name == "red" || name == "green" || name == "blue" || name == "alpha";
}

template <class Number>
Number number_of_face(const MeshAttribute& attribute, std::size_t record) {
  Number number;
  std::memcpy(&number, attribute.records.data() + record * sizeof number, sizeof number);
  return number;
}

template <class Number>
struct Part {
  Number number;
  double area;
};

template <class Number>
Number mean_of(std::span<const Part<Number>> parts) {
  double sum = 0, area = 0;
  for (const Part<Number>& part : parts) {
    if (!(part.area > 0)) continue;  // the number may be none
    sum += part.area * static_cast<double>(part.number);
    area += part.area;
  }
  return static_cast<Number>(std::is_integral_v<Number> ? std::round(sum / area) : sum / area);
}

/// The number of the largest part. REQUIRES: equal numbers follow each other, smaller ones first.
template <class Number>
Number largest_of(std::span<const Part<Number>> parts) {
  Part<Number> largest{parts.front().number, 0}, now = largest;
  for (const Part<Number>& part : parts) {
    if (part.number != now.number) now = {part.number, 0};
    now.area += part.area;
    if (now.area > largest.area) largest = now;
  }
  return largest.number;
}

/// Writes the number of a base face. Returns whether its small faces have others too.
template <class Number>
bool give_number(const MeshAttribute& of_scan, std::span<const SmallFace> small, std::byte* to) {
  std::vector<Part<Number>> parts;
  parts.reserve(small.size());
  for (const SmallFace& face : small)
    parts.push_back({number_of_face<Number>(of_scan, face.record), face.area});
  Number number = parts.front().number;
  const bool mixed =
      std::ranges::any_of(parts, [&](const auto& part) { return part.number != number; });
  if (mixed && (!std::is_integral_v<Number> || is_colour(of_scan.schema.name))) {
    number = mean_of<Number>(parts);
  } else if (mixed) {
    std::ranges::stable_sort(parts, {}, &Part<Number>::number);
    number = largest_of<Number>(parts);
  }
  std::memcpy(to, &number, sizeof number);
  return mixed;
}

/// The faces of a scan that have numbers.
class KnownFaces {
 public:
  KnownFaces(const Surface& scan, const TriangleTree& tree, std::span<const FaceId> face_origin,
             const std::function<void()>& go_on)
      : tree_(&tree) {
    if (std::ranges::find(face_origin, kNoId) == face_origin.end()) {
      records_.assign(face_origin.begin(), face_origin.end());
      return;
    }
    for (FaceId face = 0; face < scan.faces.size(); ++face) {
      if (face_origin[face] == kNoId) continue;
      faces_.push_back(scan.faces[face]);
      records_.push_back(face_origin[face]);
    }
    own_tree_.emplace(scan.positions, faces_, go_on);
    tree_ = &*own_tree_;
  }
  KnownFaces(const KnownFaces&) = delete;
  KnownFaces& operator=(const KnownFaces&) = delete;

  FaceId closest(const Point& p, FaceId hint) const { return tree_->closest(p, hint).face; }
  FaceId record(FaceId face) const { return records_[face]; }

 private:
  const TriangleTree* tree_;
  std::vector<std::array<VertexId, 3>> faces_;
  std::vector<FaceId> records_;
  std::optional<TriangleTree> own_tree_;
};

void fill_small_faces(const SampledSurface& surface, const SampleNumbers& numbers,
                      const KnownFaces& known, FaceId base_face, std::vector<SmallFace>& small) {
  small.clear();
  FaceId near = 0;
  double whole = 0;
  numbers.for_each_triangle(base_face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    const Point p = surface.positions[a], q = surface.positions[b], r = surface.positions[c];
    near = known.closest((1.0 / 3) * (p + q + r), near);
    small.push_back({known.record(near), length(area_vector(p, q, r)) / 2});
    whole += small.back().area;
  });
  if (!(whole > 0))
    for (SmallFace& face : small) face.area = 1;
}

}  // namespace

std::vector<BaseFaceAttribute> ScanFaceAttributes::of_base_faces(
    const Surface& scan, const TriangleTree& tree, const SampledSurface& surface,
    const std::function<void()>& go_on) const {
  const std::size_t count = surface.base.face_count();
  const KnownFaces known(scan, tree, face_origin_, go_on);
  const SampleNumbers numbers(surface.base, surface.levels);
  std::vector<BaseFaceAttribute> result;
  for (const MeshAttribute& attribute : attributes_)
    result.push_back(
        {{attribute.schema, std::vector<std::byte>(count * attribute.schema.record_bytes())}});
  std::vector<std::vector<std::uint8_t>> mixed(result.size(), std::vector<std::uint8_t>(count));
  const auto fill = [&](std::size_t first, std::size_t last) {
    std::vector<SmallFace> small;
    for (std::size_t face = first; face < last; ++face) {
      fill_small_faces(surface, numbers, known, static_cast<FaceId>(face), small);
      for (std::size_t at = 0; at < result.size(); ++at) {
        MeshAttribute& to = result[at].numbers;
        with_number_type(to.schema.type, [&]<class Number>(Number) {
          mixed[at][face] =
              give_number<Number>(attributes_[at], small, to.records.data() + face * sizeof(Number))
                  ? 1
                  : 0;
        });
      }
    }
  };
  for_paced_ranges(
      count, {kFacesAskedAtOnce}, [&](std::size_t) { go_on(); },
      [&](std::size_t begin, std::size_t end) {
        ranges_on_workers(end - begin, kFacesAskedAtOnce, [&](std::size_t first, std::size_t last) {
          fill(begin + first, begin + last);
        });
      });
  for (std::size_t at = 0; at < result.size(); ++at)
    result[at].mixed_faces =
        static_cast<std::uint64_t>(std::count(mixed[at].begin(), mixed[at].end(), 1));
  return result;
}

PLAIT_END_NAMESPACE
