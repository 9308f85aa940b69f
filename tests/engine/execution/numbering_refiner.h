// tests/engine/execution/numbering_refiner.h: a user's own rule for the fused executor, without any
// kernel: every vertex becomes numbers that follow from where it lies between base vertices, and
// from nothing else, so that all faces around it say the same and its place in a slot can be told
// from its content.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/fused.h"

namespace plait::test {

inline std::uint64_t mixed_numbers(std::uint64_t seed, std::uint64_t value) {
  std::uint64_t x = (seed ^ value) + 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// A hash of the base vertices around a point with their weights in lowest terms: the same from
/// every face and at every level.
inline std::uint64_t vertex_number(const Topology& mesh, const FaceIndex& point) {
  const std::int64_t size = std::int64_t{1} << point.level;
  std::int64_t weights[3] = {size - point.i - point.j, point.i, point.j};
  while ((weights[0] | weights[1] | weights[2]) % 2 == 0)
    for (std::int64_t& weight : weights) weight /= 2;
  std::array<std::pair<VertexId, std::int64_t>, 3> corners;
  for (std::size_t c = 0; c < 3; ++c)
    corners[c] = {weights[c] > 0 ? mesh.faces[point.face][c] : kNoId, weights[c]};
  std::ranges::sort(corners);
  std::uint64_t number = 0;
  for (const auto& [vertex, weight] : corners)
    number = mixed_numbers(mixed_numbers(number, vertex), static_cast<std::uint64_t>(weight));
  return number;
}

/// One component of a vertex, exact in its type.
inline void put_component(const AttributeSchema& schema, std::uint64_t vertex, std::size_t c,
                          std::byte* to) {
  const std::uint64_t number = mixed_numbers(vertex, c + std::size_t{100} * schema.components);
  const auto put = [&](auto value) { std::memcpy(to, &value, sizeof value); };
  switch (schema.type) {
    case ComponentType::kFloat32:
      return put(static_cast<float>(number >> 40));
    case ComponentType::kFloat64:
      return put(static_cast<double>(number >> 11));
    case ComponentType::kUint32:
      return put(static_cast<std::uint32_t>(number));
    default:
      FAIL("no numbers of this type");
  }
}

/// What the refiners of a pass were asked for.
struct NumberingCalls {
  explicit NumberingCalls(std::size_t face_count) : refined(face_count) {}
  std::vector<std::atomic<int>> refined;  ///< [face] how often
  std::atomic<int> refiners = 0;
  std::atomic<bool> in_order = true;  ///< faces of a run descend one by one
};

class NumberingRefiner final : public PatchRefiner {
 public:
  NumberingRefiner(const Store& store, const FusedPass& pass, NumberingCalls& calls)
      : mesh_(store.base().topology()),
        lattice_(pass.lattice),
        levels_(pass.finest_level - store.base_level()),
        calls_(calls) {
    ++calls_.refiners;
    for (const AttributeId id : pass.outputs) {
      const AttributeSchema& schema = store.attributes()[id].schema;
      // What lies in lanes without a patch and beyond it must not come out.
      outputs_.push_back(
          {schema, std::vector<std::byte>(static_cast<std::size_t>(lattice_.points()) *
                                              schema.record_bytes() * kPatchLanes,
                                          std::byte{0xee})});
    }
  }

  void begin(std::span<const FaceId> faces) override {
    faces_ = faces;
    for (std::size_t i = 1; i < faces.size(); ++i)
      if (faces[i] + 1 != faces[i - 1]) calls_.in_order = false;
  }

  void refine(std::size_t first, std::size_t count) override {
    for (std::size_t lane = 0; lane < count; ++lane) {
      const FaceId face = faces_[first + lane];
      ++calls_.refined[face];
      const auto turn = static_cast<std::size_t>(first_corner(mesh_, face));
      for (std::int64_t j = 0; j <= lattice_.size; ++j)
        for (std::int64_t i = 0; i + j <= lattice_.size; ++i) {
          std::int64_t weights[3];
          weights[turn] = lattice_.size - i - j;
          weights[(1 + turn) % 3] = i;
          weights[(2 + turn) % 3] = j;
          const std::uint64_t vertex =
              vertex_number(mesh_, {face, levels_, weights[1], weights[2]});
          for (auto& [schema, numbers] : outputs_)
            for (std::size_t c = 0; c < schema.components; ++c)
              put_component(
                  schema, vertex, c,
                  numbers.data() +
                      ((static_cast<std::size_t>(lattice_.index(i, j)) * schema.components + c) *
                           kPatchLanes +
                       lane) *
                          component_bytes(schema.type));
        }
    }
  }

  const void* points(std::size_t output) const override { return outputs_[output].numbers.data(); }

 private:
  struct Output {
    AttributeSchema schema;
    std::vector<std::byte> numbers;
  };
  Topology mesh_;
  PatchLattice lattice_;
  int levels_;
  NumberingCalls& calls_;
  std::span<const FaceId> faces_;
  std::vector<Output> outputs_;
};

/// A store with these attributes, all with `levels` levels beyond its base mesh.
inline Store numbered_store(const std::filesystem::path& path, const BaseMesh& base,
                            const StoreOptions& options,
                            const std::vector<AttributeSchema>& schemas, int levels,
                            const BackendRegistry& backends, int base_level = 0) {
  Store store = Store::create(path, base, options, backends, {.base_level = base_level});
  for (const AttributeSchema& schema : schemas) {
    const AttributeId id = store.add_attribute(schema);
    for (int level = 1; level <= levels; ++level) store.add_level(id);
  }
  return store;
}

/// Numbers the first `levels` levels after the base mesh's of all attributes of the store. It and
/// `calls` outlive the pass.
inline FusedPass numbering_pass(const Store& store, int levels, NumberingCalls& calls,
                                std::int64_t halo = 1) {
  FusedPass pass{.name = "numbering"};
  for (AttributeId id = 0; id < store.attributes().size(); ++id) pass.outputs.push_back(id);
  pass.finest_level = store.base_level() + levels;
  pass.lattice = {std::int64_t{1} << levels, halo};
  pass.make_refiner = [&store, &calls, described = pass] {
    return std::make_unique<NumberingRefiner>(store, described, calls);
  };
  return pass;
}

/// Whether every record of levels 1 to `levels` is that of the vertex that face_index() names.
inline bool holds_numbers(Store& store, int levels) {
  const Topology mesh = store.base().topology();
  bool right = true;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeSchema schema = store.attributes()[id].schema;
    const std::size_t width = component_bytes(schema.type);
    std::vector<std::byte> expected(width);
    for (int level = 1; level <= levels; ++level) {
      const std::vector<std::byte> found = read_level(store, id, store.base_level() + level);
      std::size_t at = 0;
      for (EdgeId edge = 0; edge < mesh.edges.size(); ++edge) {
        const std::int64_t n = slot_side(level);
        for (std::int64_t row = 0; row < n; ++row)
          for (std::int64_t column = 0; column < (mesh.edges[edge].is_border() ? n - row : n);
               ++column)
            for (std::size_t c = 0; c < schema.components; ++c, at += width) {
              const FaceIndex point = face_index(mesh, {edge, level, row, column});
              put_component(schema, vertex_number(mesh, point), c, expected.data());
              right &= at + width <= found.size() &&
                       std::memcmp(found.data() + at, expected.data(), width) == 0;
            }
      }
      right &= at == found.size();
    }
  }
  return right;
}

}  // namespace plait::test
