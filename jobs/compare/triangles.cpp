#include "compare/triangles.h"

#include <fmt/format.h>

#include <cstring>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "base/interruption.h"
#include "export/numbered_triangles.h"
#include "export/vertex_stream.h"
#include "job_rules.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/store.h"
#include "sample/samples.h"
#include "store/base_positions.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
void read_positions(const Store& store, int level, const SampleNumbers& numbers,
                    IndexedMesh& mesh) {
  const Reader reader(store, {.attributes = {"position"}, .policy = EvictionPolicy::kLayoutOrder});
  mesh.positions.resize(numbers.count());
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    poll_interruption();
    const PatchView patch = reader.read_patch(face, level);
    const auto positions = patch.attribute<Vector3<Real>>("position");
    for (std::int64_t j = 0; j <= numbers.size(); ++j)
      for (std::int64_t i = 0; i + j <= numbers.size(); ++i) {
        const Vector3<Real>& p = positions.at(i, j);
        mesh.positions[numbers.of(face, i, j)] = {double{p.x}, double{p.y}, double{p.z}};
      }
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      mesh.faces.push_back(
          {static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c)});
    });
  }
}

void check_size_of_mesh(const std::filesystem::path& path, int level, std::uint64_t vertices,
                        std::uint64_t triangles) {
  if (vertices >= kNoId)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected fewer than {} vertices, found {} at level {}",
                            path.native(), kNoId, vertices, level));
  check_memory(fmt::format("{}: level {}", path.native(), level),
               vertices * sizeof(Vector3<double>) + triangles * sizeof(std::array<VertexId, 3>),
               false);
}

/// What is drawn of a store whose faces have depths of their own, up to a level.
template <class Real>
IndexedMesh read_drawn(Store& store, int level) {
  const PatchSelection patches(store.base(), level - store.base_level(), all_faces(store.base()));
  check_size_of_mesh(store.path(), level, patches.vertex_count(), patches.triangle_count());
  IndexedMesh mesh;
  mesh.positions.reserve(patches.vertex_count());
  mesh.faces.reserve(patches.triangle_count());
  const AttributeId position = store.attribute("position");
  stream_vertices(store, std::span(&position, 1), patches, [&](auto records, std::size_t count) {
    poll_interruption();
    for (std::size_t vertex = 0; vertex < count; ++vertex) {
      Vector3<Real> at;
      std::memcpy(&at, records[0].data() + vertex * sizeof(at), sizeof(at));
      mesh.positions.push_back({double{at.x}, double{at.y}, double{at.z}});
    }
  });
  for_each_numbered_triangle(
      patches,
      [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        mesh.faces.push_back(
            {static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c)});
      },
      [](std::uint64_t) {});
  return mesh;
}

IndexedMesh read_store(const std::filesystem::path& path, int level,
                       const BackendRegistry& backends) {
  Store store = Store::open(path, {}, backends);
  const AttributeInfo& position = store.attributes()[position_of(store, "compare")];
  if (level < 0) level = position.finest_level;
  if (level < store.base_level() || level > position.finest_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected a level from {} to {}, found {}", path.native(),
                            store.base_level(), position.finest_level, level));
  const LevelCounts counts = counts_at_level(store.base(), level - store.base_level());
  const bool is_float = position.schema.type == ComponentType::kFloat32;
  if (store.has_depths())
    return is_float ? read_drawn<float>(store, level) : read_drawn<double>(store, level);
  check_size_of_mesh(path, level, counts.vertices, counts.faces);
  IndexedMesh mesh;
  mesh.faces.reserve(counts.faces);
  const SampleNumbers numbers(store.base(), level - store.base_level());
  if (is_float)
    read_positions<float>(store, level, numbers, mesh);
  else
    read_positions<double>(store, level, numbers, mesh);
  return mesh;
}

}  // namespace

IndexedMesh read_triangles(const std::filesystem::path& path, int level,
                           const BackendRegistry& backends,
                           const std::function<void(const std::string&)>& warn) {
  std::error_code ignored;  // a path that cannot be looked at is a file that cannot be read
  if (std::filesystem::is_directory(path, ignored)) return read_store(path, level, backends);
  if (level >= 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected a store, which has levels, found a file", path.native()));
  std::vector<std::string> warnings;
  IndexedMesh mesh = read_indexed_mesh(path, &warnings);
  for (const std::string& warning : warnings)
    if (warn) warn(warning);
  for (const auto& face : mesh.faces)
    for (const VertexId vertex : face)
      if (vertex >= mesh.positions.size())
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: expected a vertex below {}, found {}", path.native(),
                                mesh.positions.size(), vertex));
  if (mesh.faces.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected at least one face, found none", path.native()));
  return mesh;
}

PLAIT_END_NAMESPACE
