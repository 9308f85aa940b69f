// Stores: create, open, commit, close.
#include "plait/store.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/edge_index.h"
#include "plait/kernels/subdivide.h"
#include "plait/mesh_io.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

std::optional<int> threads_of(std::int32_t io_threads) {
  if (io_threads == PLAIT_AUTOMATIC_THREADS) return std::nullopt;
  return io_threads;
}

Durability durability_of(std::int32_t number) {
  check_choice("durability", number, 2);
  return number == PLAIT_DURABILITY_COMMIT ? Durability::kCommit : Durability::kNone;
}

Overwriting overwriting_of(std::int32_t number) {
  check_choice("overwriting", number, 2);
  return number == PLAIT_OVERWRITE_NEW_GENERATION ? Overwriting::kNewGeneration
                                                  : Overwriting::kInPlace;
}

StoreOptions store_options(const plait_store_options& given) {
  StoreOptions options;
  options.backend = text_or(given.backend, options.backend);
  options.pipeline = text_or(given.pipeline, "");
  options.base_level = given.base_level;
  options.durability = durability_of(given.durability);
  options.overwriting = overwriting_of(given.overwriting);
  options.block_bytes = given.block_bytes;
  options.budget_bytes = given.budget_bytes;
  options.io_threads = threads_of(given.io_threads);
  return options;
}

/// Makes a store of the mesh that `make_mesh` returns; it also gets a list for warnings.
template <class MakeMesh>
plait_store* create(const char* path, const plait_store_options* given, const MakeMesh& make_mesh) {
  check_given(path, "path");
  const plait_store_options wanted =
      options_of(given, plait_store_options PLAIT_STORE_OPTIONS_INIT);
  check_reserved(wanted.reserved);
  const StoreOptions options = store_options(wanted);
  if (wanted.position_type != PLAIT_NO_POSITIONS && wanted.position_type != PLAIT_FLOAT32 &&
      wanted.position_type != PLAIT_FLOAT64)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("position_type: expected PLAIT_FLOAT32, PLAIT_FLOAT64 or "
                            "PLAIT_NO_POSITIONS, found {}",
                            wanted.position_type));
  if (wanted.base_level < 0 || wanted.base_level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("base_level: expected 0 to {}, found {}",
                                                         kMaxLevel, wanted.base_level));
  const LayoutKind layout =
      layout_from_name(text_or(wanted.layout, to_string(LayoutKind::kAutomatic)));
  const Scheme scheme = scheme_from_name(text_or(wanted.base_scheme, to_string(kDefaultScheme)));
  const bool double_precision = wanted.position_type == PLAIT_FLOAT64;

  std::vector<std::string> warnings;
  BaseMesh mesh = make_mesh(&warnings);
  if (wanted.warn != nullptr)
    for (const std::string& warning : warnings) wanted.warn(warning.c_str(), wanted.user);
  if (wanted.base_level > 0) mesh = rebase(mesh, wanted.base_level, scheme, double_precision);
  Store store = Store::create(path, lay_out(mesh, layout), options, known_backends());
  if (wanted.position_type != PLAIT_NO_POSITIONS) add_base_positions(store, double_precision);
  return new plait_store(std::move(store), true);
}

BaseMesh mesh_of(const double* positions, std::uint64_t vertex_count,
                 const std::uint32_t* triangles, std::uint64_t triangle_count,
                 std::vector<std::string>* warnings) {
  IndexedMesh mesh;
  mesh.positions.resize(vertex_count);
  for (std::uint64_t vertex = 0; vertex < vertex_count; ++vertex)
    mesh.positions[vertex] = {positions[3 * vertex], positions[3 * vertex + 1],
                              positions[3 * vertex + 2]};
  mesh.faces.resize(triangle_count);
  for (std::uint64_t face = 0; face < triangle_count; ++face)
    mesh.faces[face] = {triangles[3 * face], triangles[3 * face + 1], triangles[3 * face + 2]};
  return BaseMesh::build(std::move(mesh), "mesh", warnings);
}

}  // namespace

Store& changed_store(plait_store* handle) {
  check_given(handle, "store");
  const std::uint64_t readers = handle->users->readers, views = handle->users->views;
  if (readers > 0 || views > 0)
    throw Error(ErrorCode::kBusy,
                fmt::format("{}: expected no reader of this store, found {} and {} open views",
                            handle->store.path().native(), readers, views));
  return handle->store;
}

const Store& read_store(const plait_store* handle) {
  check_given(handle, "store");
  return handle->store;
}

}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_create(const char* path, const double* positions, uint64_t vertex_count,
                                const uint32_t* triangles, uint64_t triangle_count,
                                const plait_store_options* options, plait_store** store) {
  return guarded("plait_store_create", [&] {
    check_given(positions, "positions");
    check_given(triangles, "triangles");
    check_given(store, "store");
    *store = create(path, options, [&](std::vector<std::string>* warnings) {
      return mesh_of(positions, vertex_count, triangles, triangle_count, warnings);
    });
  });
}

plait_status plait_store_create_from_file(const char* path, const char* mesh_path,
                                          const plait_store_options* options, plait_store** store) {
  return guarded("plait_store_create_from_file", [&] {
    check_given(mesh_path, "mesh_path");
    check_given(store, "store");
    *store = create(path, options, [&](std::vector<std::string>* warnings) {
      return plait::read_base_mesh(mesh_path, warnings);
    });
  });
}

plait_status plait_store_open(const char* path, const plait_open_options* options,
                              plait_store** store) {
  return guarded("plait_store_open", [&] {
    check_given(path, "path");
    check_given(store, "store");
    const plait_open_options wanted =
        options_of(options, plait_open_options PLAIT_OPEN_OPTIONS_INIT);
    plait::OpenOptions opening;
    opening.writable = wanted.writable != 0;
    opening.budget_bytes = wanted.budget_bytes;
    opening.io_threads = threads_of(wanted.io_threads);
    opening.durability = durability_of(wanted.durability);
    opening.overwriting = overwriting_of(wanted.overwriting);
    *store = new plait_store(plait::Store::open(path, opening, known_backends()), opening.writable);
  });
}

plait_status plait_store_has_commit(const char* path, int32_t* has_commit) {
  return guarded("plait_store_has_commit", [&] {
    check_given(path, "path");
    check_given(has_commit, "has_commit");
    *has_commit = plait::Store::has_commit(path) ? 1 : 0;
  });
}

plait_status plait_store_commit(plait_store* store) {
  return guarded("plait_store_commit", [&] { changed_store(store).commit(); });
}

plait_status plait_store_close(plait_store* store) {
  return guarded("plait_store_close", [&] {
    if (store == nullptr) return;
    changed_store(store).close();
    delete store;
  });
}

void plait_store_release(plait_store* store) { delete store; }
