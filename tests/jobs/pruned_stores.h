// Stores of all levels, and what is pruned of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "option_text.h"
#include "plait/notes.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "prune/prune.h"
#include "support/random_depths.h"

namespace plait::test {

constexpr int kLevels = 3;
using Position = Vector3<float>;

/// A store of all levels, with normals, whose face attribute "depth" has these numbers.
inline std::filesystem::path whole_store(const std::filesystem::path& path, const IndexedMesh& mesh,
                                         const std::vector<std::uint8_t>& depths,
                                         const std::string& scheme = "loop") {
  const StoreOptions options{
      .backend = "pread", .durability = Durability::kNone, .block_bytes = 4096};
  Store store = Store::create(path, lay_out(BaseMesh::build(mesh), LayoutKind::kGiven).mesh,
                              options, default_backends());
  add_base_positions(store, ComponentType::kFloat32);
  subdivide(store, {.scheme = scheme_from_name(scheme), .levels = kLevels, .normals = true});
  if (!depths.empty()) {
    store.notes().add_face_attribute({"depth", ComponentType::kUint8, 1});
    std::ranges::copy(depths, store.notes().face_records<std::uint8_t>("depth").begin());
  }
  store.commit();
  return path;
}

inline PruneResult pruned(const std::filesystem::path& from, const std::filesystem::path& to,
                          int balance, const std::string& max_distance = {}) {
  PruneRequest request;
  if (max_distance.empty())
    request.depth_by = "depth";
  else
    request.max_distance = parse_relative_length(max_distance);
  request.balance = balance;
  request.copy.from = from;
  request.copy.to = to;
  return prune(request, default_backends(), default_backends());
}

inline Store open(const std::filesystem::path& path, bool writable = false) {
  return Store::open(path, {.writable = writable}, default_backends());
}

inline std::vector<Position> patch_of(const Store& store, FaceId face, int level) {
  const Reader reader(store, {.attributes = {"position"}});
  const PatchView view = reader.read_patch(face, level);
  std::vector<Position> records(patch_vertex_count(view.size()));
  view.attribute<Position>("position").copy_to(records);
  return records;
}

}  // namespace plait::test
