#include "backends/mesh_subject.h"

#include <fmt/format.h>
#include <xxhash.h>

#include "instrument/process.h"
#include "plait/base_mesh.h"
#include "plait/mesh_io.h"
#include "plait/subdivide.h"

namespace plait::bench {

MeshSubject mesh_subject(const std::filesystem::path& file, int levels, std::uint64_t most_bytes,
                         int* chosen) {
  const nlohmann::json found = instrument::in_own_process([&]() -> nlohmann::json {
    const BaseMesh mesh = read_base_mesh(file);
    const auto positions = std::as_bytes(std::span(mesh.positions()));
    const auto faces = std::as_bytes(std::span(mesh.faces()));
    const std::uint64_t checksum = XXH3_64bits_withSeed(
        faces.data(), faces.size(), XXH3_64bits(positions.data(), positions.size()));
    int finest = levels;
    while (finest > 1 && counts_at_level(mesh, finest).vertices > most_bytes / 12) --finest;
    return {{"checksum", checksum},
            {"base_vertices", mesh.vertex_count()},
            {"levels", finest},
            {"vertices", counts_at_level(mesh, finest).vertices}};
  });
  if (chosen != nullptr) *chosen = found["levels"].get<int>();
  return {
      file,
      fmt::format("{} {:016x}", file.filename().native(), found["checksum"].get<std::uint64_t>()),
      found["base_vertices"].get<std::uint64_t>(), found["vertices"].get<std::uint64_t>()};
}

}  // namespace plait::bench
