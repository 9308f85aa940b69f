#include "remesh/scan_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/number_type.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Records, and how much of each counts. The weights have the sum 1.
struct Shares {
  std::span<const VertexId> records;
  std::span<const double> weights;
};

template <class Number>
Number number_of(const MeshAttribute& attribute, VertexId record, std::size_t component) {
  Number number;
  std::memcpy(&number,
              attribute.records.data() + record * attribute.schema.record_bytes() +
                  component * sizeof number,
              sizeof number);
  return number;
}

bool has_mean(const AttributeSchema& schema) {
  return schema.type == ComponentType::kFloat32 || schema.type == ComponentType::kFloat64 ||
         schema.name == "color";
}

template <class Number>
void interpolate(const MeshAttribute& attribute, const Shares& shares, std::byte* to) {
  const auto components = std::size_t{attribute.schema.components};
  std::array<double, 256> sums{};  // a record has at most 255 components
  for (std::size_t i = 0; i < shares.records.size(); ++i) {
    if (!(shares.weights[i] > 0)) continue;  // the number may be none
    for (std::size_t at = 0; at < components; ++at)
      sums[at] += shares.weights[i] *
                  static_cast<double>(number_of<Number>(attribute, shares.records[i], at));
  }
  if (attribute.schema.name == "normal" && components == 3) {
    const double length = std::sqrt(sums[0] * sums[0] + sums[1] * sums[1] + sums[2] * sums[2]);
    if (length > 0)
      for (std::size_t at = 0; at < 3; ++at) sums[at] /= length;
  }
  for (std::size_t at = 0; at < components; ++at) {
    const auto number =
        static_cast<Number>(std::is_integral_v<Number> ? std::round(sums[at]) : sums[at]);
    std::memcpy(to + at * sizeof number, &number, sizeof number);
  }
}

template <class Number>
std::uint64_t records_not_finite(const MeshAttribute& attribute) {
  const std::size_t count = attribute.records.size() / attribute.schema.record_bytes();
  std::uint64_t found = 0;
  for (std::size_t record = 0; record < count; ++record) {
    bool is_finite = true;
    for (std::size_t at = 0; at < std::size_t{attribute.schema.components}; ++at)
      is_finite = is_finite &&
                  std::isfinite(number_of<Number>(attribute, static_cast<VertexId>(record), at));
    found += is_finite ? 0u : 1u;
  }
  return found;
}

/// `one` and `several` name what has the records, `getting` what gets such values too.
void warn_of_values(std::span<const MeshAttribute> attributes, std::string_view one,
                    std::string_view several, std::string_view getting,
                    std::vector<std::string>& warnings) {
  for (const MeshAttribute& attribute : attributes) {
    std::uint64_t count = 0;
    if (attribute.schema.type == ComponentType::kFloat32)
      count = records_not_finite<float>(attribute);
    else if (attribute.schema.type == ComponentType::kFloat64)
      count = records_not_finite<double>(attribute);
    if (count > 0)
      warnings.push_back(
          fmt::format("{} {} of the scan {} a value of '{}' that is infinite or no number: {} get "
                      "such values too",
                      count, count == 1 ? one : several, count == 1 ? "has" : "have",
                      attribute.schema.name, getting));
  }
}

}  // namespace

void warn_of_values_not_finite(const AttributedMesh& scan, std::vector<std::string>& warnings) {
  warn_of_values(scan.attributes, "vertex", "vertices", "points of the faces there", warnings);
  warn_of_values(scan.face_attributes, "face", "faces", "base faces there", warnings);
}

ScanAttributes::ScanAttributes(std::vector<MeshAttribute> attributes, const Repaired& repaired)
    : attributes_(std::move(attributes)), record_of_(repaired.origin) {
  if (!attributes_.empty()) fill_holes(repaired.surface);
}

void ScanAttributes::fill_holes(const Surface& scan) {
  const std::size_t known = attributes_[0].records.size() / attributes_[0].schema.record_bytes();
  std::vector<VertexId> fills;
  for (std::size_t vertex = 0; vertex < record_of_.size(); ++vertex) {
    if (record_of_[vertex] != kNoId) continue;
    record_of_[vertex] = static_cast<VertexId>(known + fills.size());
    fills.push_back(static_cast<VertexId>(vertex));
  }
  if (fills.empty()) return;
  // The faces around such a vertex go around it once, so each neighbour follows it in one face.
  // What fills a hole is numbered from the border inwards, so smaller numbers have their records
  // already.
  std::vector<std::vector<VertexId>> neighbours(fills.size());
  for (const auto& face : scan.faces)
    for (std::size_t corner = 0; corner < 3; ++corner)
      if (const VertexId record = record_of_[face[corner]]; record >= known)
        if (const VertexId neighbour = record_of_[face[(corner + 1) % 3]]; neighbour < record)
          neighbours[record - known].push_back(neighbour);
  for (std::size_t attribute = 0; attribute < attributes_.size(); ++attribute) {
    MeshAttribute& whole = attributes_[attribute];
    const std::size_t bytes = whole.schema.record_bytes();
    whole.records.resize((known + fills.size()) * bytes);
    for (std::size_t i = 0; i < fills.size(); ++i) {
      const std::vector<double> weights(neighbours[i].size(),
                                        1 / static_cast<double>(neighbours[i].size()));
      blend(attribute, neighbours[i], weights, whole.records.data() + (known + i) * bytes);
    }
  }
}

void ScanAttributes::blend(std::size_t attribute, std::span<const VertexId> records,
                           std::span<const double> weights, std::byte* to) const {
  const MeshAttribute& whole = attributes_[attribute];
  if (has_mean(whole.schema)) {
    with_number_type(whole.schema.type, [&]<class Number>(Number) {
      interpolate<Number>(whole, {records, weights}, to);
    });
    return;
  }
  const auto nearest = std::ranges::max_element(weights) - weights.begin();
  const std::size_t bytes = whole.schema.record_bytes();
  std::memcpy(to, whole.records.data() + records[static_cast<std::size_t>(nearest)] * bytes, bytes);
}

void ScanAttributes::record_at(std::size_t attribute, const Surface& scan, const SurfacePoint& at,
                               std::byte* to) const {
  std::array<VertexId, 3> records{};
  for (std::size_t corner = 0; corner < 3; ++corner)
    records[corner] = record_of_[scan.faces[at.face][corner]];
  blend(attribute, records, at.weights, to);
}

PLAIT_END_NAMESPACE
