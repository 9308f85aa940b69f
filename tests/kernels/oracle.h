// A refined store beside the naive oracle's mesh of the same input.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "plait/extend/patch.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "support/naive_limit.h"
#include "support/naive_subdivision.h"
#include "support/test_meshes.h"

namespace plait::test {

/// A store in memory, refined. Face numbers are the input's.
inline Store refine_in_memory(const IndexedMesh& mesh, const SubdivideOptions& options,
                              bool double_precision = false, std::uint64_t block_bytes = 4096) {
  Store store =
      Store::create({}, BaseMesh::build(mesh), {.backend = "memory", .block_bytes = block_bytes},
                    default_backends());
  add_base_positions(store, double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32);
  subdivide(store, options);
  return store;
}

/// Calls compare(oracle vertex, record) for every vertex of every patch at the finest level.
template <class Record, class Compare>
void for_each_vertex(Store& store, const std::string& attribute, const naive::Mesh& oracle,
                     Compare compare) {
  const int level = store.finest_level();
  StorePatches<Record> patches(store, store.attribute(attribute), 1 << 24, Reach::kOwn);
  patches.activate(level, 1, 0);
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const auto patch = patches.patch(face);
    const std::int64_t size = patch.size(level);
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i)
        compare(naive::vertex_at(oracle, face, i, j), patch.at(level, i, j));
  }
}

template <class Record>
naive::Point point_of(const Record& record) {
  return {record.x, record.y, record.z};
}

inline double bounding_box_diagonal(const std::vector<naive::Point>& points) {
  naive::Point low = points.front(), high = points.front();
  for (const naive::Point& point : points) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y), std::min(low.z, point.z)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y), std::max(high.z, point.z)};
  }
  return naive::length(high - low);
}

/// The largest distance to `expected`, over the bounding box's diagonal.
template <class Record>
double worst_distance(Store& store, const std::string& attribute, const naive::Mesh& oracle,
                      const std::vector<naive::Point>& expected) {
  double worst = 0;
  for_each_vertex<Record>(store, attribute, oracle, [&](naive::Index vertex, const Record& found) {
    const double distance = naive::length(point_of(found) - expected[vertex]);
    worst = std::isnan(distance) ? INFINITY : std::max(worst, distance);
  });
  return worst / bounding_box_diagonal(expected);
}

}  // namespace plait::test
