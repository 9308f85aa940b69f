// Stores: create, open, commit, close.
#include "plait/store.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "guard.h"
#include "handles.h"
#include "mesh/narrowing.h"
#include "mesh/weld.h"
#include "plait.h"
#include "plait/extend/edge_index.h"
#include "plait/mesh_io.h"
#include "plait/subdivide.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

/// A program that makes a store adds levels later. This many are looked ahead.
constexpr int kLevelsLookedAhead = 3;

std::optional<int> threads_of(std::int32_t io_threads) {
  if (io_threads == PLAIT_AUTOMATIC_THREADS) return std::nullopt;
  return io_threads;
}

Durability durability_of(std::int32_t number) {
  check_choice("durability", number, 2);
  return number == PLAIT_DURABILITY_COMMIT ? Durability::kCommit : Durability::kNone;
}

StoreEvents events_of(plait_event_callback callback, void* user, std::uint64_t slow_read_ns) {
  if (callback == nullptr) return {};
  const auto call = [=](const StoreEvent& event) {
    // Texts of C end with a zero byte.
    const std::string store(event.store), attribute(event.attribute);
    const plait_event told = {sizeof(told),      store.c_str(),
                              attribute.c_str(), event.version,
                              event.duration_ns, event.block,
                              event.bytes,       static_cast<plait_event_kind>(event.kind),
                              event.level};
    callback(&told, user);
  };
  return {call, slow_read_ns != 0 ? slow_read_ns : StoreEvents().slow_read_ns};
}
static_assert(PLAIT_EVENT_OPENED == static_cast<int>(StoreEvent::Kind::kOpened));
static_assert(PLAIT_EVENT_COMMITTED == static_cast<int>(StoreEvent::Kind::kCommitted));
static_assert(PLAIT_EVENT_EVICTED == static_cast<int>(StoreEvent::Kind::kEvicted));
static_assert(PLAIT_EVENT_SLOW_READ == static_cast<int>(StoreEvent::Kind::kSlowRead));

StoreOptions store_options(const plait_store_options& given) {
  StoreOptions options;
  options.backend = text_or(given.backend, options.backend);
  if (const std::string pipeline = text_or(given.pipeline, ""); !pipeline.empty())
    options.pipeline = pipeline;
  options.durability = durability_of(given.durability);
  options.block_bytes = given.block_bytes;
  options.budget_bytes = given.budget_bytes;
  options.expected_bytes = given.expected_bytes;
  options.io_threads = threads_of(given.io_threads);
  options.events = events_of(given.event, given.event_user, given.slow_read_ns);
  options.parallel_for = parallel_for_by(given.parallel_for, given.parallel_user);
  return options;
}

/// Makes a store of the mesh that `make_mesh` returns; it also gets a list for warnings.
template <class MakeMesh>
plait_store* create(const char* path, const plait_store_options* given, const MakeMesh& make_mesh) {
  check_given(path, "path");
  const plait_store_options wanted = options_of(given, plait_store_options PLAIT_STORE_OPTIONS_INIT,
                                                offsetof(plait_store_options, event));
  const StoreOptions options = store_options(wanted);
  if (wanted.position_type != PLAIT_NO_POSITIONS && wanted.position_type != PLAIT_FLOAT32 &&
      wanted.position_type != PLAIT_FLOAT64 && wanted.position_type != PLAIT_AUTOMATIC_POSITIONS)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("position_type: expected PLAIT_FLOAT32, PLAIT_FLOAT64, "
                            "PLAIT_AUTOMATIC_POSITIONS or PLAIT_NO_POSITIONS, found {}",
                            wanted.position_type));
  if (wanted.base_level < 0 || wanted.base_level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("base_level: expected 0 to {}, found {}",
                                                         kMaxLevel, wanted.base_level));
  const LayoutKind layout =
      layout_from_name(text_or(wanted.layout, to_string(LayoutKind::kAutomatic)));
  const Scheme scheme = scheme_from_name(text_or(wanted.base_scheme, to_string(Scheme())));
  std::optional<ComponentType> asked;
  if (wanted.position_type != PLAIT_AUTOMATIC_POSITIONS)
    asked =
        wanted.position_type == PLAIT_FLOAT64 ? ComponentType::kFloat64 : ComponentType::kFloat32;

  std::vector<std::string> warnings;
  BaseMesh mesh = make_mesh(&warnings);
  if (const std::uint64_t seams = seam_vertices_of(mesh); seams > 0)
    warnings.push_back(fmt::format("create: {}", seam_text(seams,
                                                           "one number for each such place "
                                                           "closes them")));
  ComponentType precision = ComponentType::kFloat32;
  if (wanted.position_type != PLAIT_NO_POSITIONS)
    precision = precision_for(mesh.positions(), mesh.faces(),
                              wanted.base_level + kLevelsLookedAhead, asked, "create", warnings);
  if (wanted.warn != nullptr)
    for (const std::string& warning : warnings) wanted.warn(warning.c_str(), wanted.user);
  if (wanted.base_level > 0) mesh = rebase(mesh, wanted.base_level, scheme, precision);
  Store store = Store::create(path, lay_out(mesh, layout), options, known_backends(),
                              {.base_level = wanted.base_level});
  if (wanted.position_type != PLAIT_NO_POSITIONS) add_base_positions(store, precision);
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

ParallelFor parallel_for_by(plait_parallel_for parallel_for, void* user) {
  if (parallel_for == nullptr) return {};
  return [=](int count, const std::function<void(int)>& body) {
    const plait_parallel_body call_body = [](std::int32_t number, void* loop) {
      (*static_cast<const std::function<void(int)>*>(loop))(number);
    };
    parallel_for(count, call_body, const_cast<std::function<void(int)>*>(&body), user);
  };
}

Store& changed_store(plait_store* handle) {
  check_given(handle, "store");
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
    const plait_open_options wanted = options_of(
        options, plait_open_options PLAIT_OPEN_OPTIONS_INIT, offsetof(plait_open_options, event));
    check_reserved(wanted.reserved);
    plait::OpenOptions opening;
    check_choice("writable", wanted.writable, 2);
    opening.writable = wanted.writable != 0;
    opening.budget_bytes = wanted.budget_bytes;
    opening.io_threads = threads_of(wanted.io_threads);
    opening.durability = durability_of(wanted.durability);
    opening.events = events_of(wanted.event, wanted.event_user, wanted.slow_read_ns);
    opening.parallel_for = parallel_for_by(wanted.parallel_for, wanted.parallel_user);
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

plait_status plait_store_roll_back(plait_store* store) {
  return guarded("plait_store_roll_back", [&] { changed_store(store).roll_back(); });
}

plait_status plait_store_close(plait_store* store) {
  return guarded("plait_store_close", [&] {
    if (store == nullptr) return;
    changed_store(store).close();
    delete store;
  });
}

void plait_store_release(plait_store* store) { delete store; }
