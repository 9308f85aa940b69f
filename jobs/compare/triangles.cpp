#include "compare/triangles.h"

#include <fmt/format.h>

#include <string>
#include <system_error>
#include <vector>

#include "job_rules.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/store.h"
#include "sample/samples.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
void read_positions(const Store& store, int level, const SampleNumbers& numbers,
                    IndexedMesh& mesh) {
  const Reader reader(store, {.attributes = {"position"}, .policy = EvictionPolicy::kLayoutOrder});
  mesh.positions.resize(numbers.count());
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
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

IndexedMesh read_store(const std::filesystem::path& path, int level,
                       const BackendRegistry& backends) {
  const Store store = Store::open(path, {}, backends);
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  if (level < 0) level = position.finest_level;
  if (level < store.base_level() || level > position.finest_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected a level from {} to {}, found {}", path.native(),
                            store.base_level(), position.finest_level, level));
  const LevelCounts counts = counts_at_level(store.base(), level - store.base_level());
  if (counts.vertices >= kNoId)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected fewer than {} vertices, found {} at level {}",
                            path.native(), kNoId, counts.vertices, level));
  const std::uint64_t needed =
      counts.vertices * sizeof(Vector3<double>) + counts.faces * sizeof(std::array<VertexId, 3>);
  check_memory(fmt::format("{}: level {}", path.native(), level), needed, false);
  IndexedMesh mesh;
  mesh.faces.reserve(counts.faces);
  const SampleNumbers numbers(store.base(), level - store.base_level());
  if (position.schema == schema_of<Vector3<float>>("position"))
    read_positions<float>(store, level, numbers, mesh);
  else if (position.schema == schema_of<Vector3<double>>("position"))
    read_positions<double>(store, level, numbers, mesh);
  else
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: attribute 'position': expected float32 x 3 or float64 x 3, found "
                    "{} x {}",
                    path.native(), to_string(position.schema.type), position.schema.components));
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
