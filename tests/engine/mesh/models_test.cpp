// Compares real meshes with the table in their folder. Skipped if the machine does not have them.

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "plait/mesh_io.h"
#include "shapes.h"
#include "support/sanitized.h"
#include "support/skip.h"

using namespace plait;

namespace {

using Row = std::map<std::string, std::string>;

std::vector<Row> read_table(const std::filesystem::path& path) {
  std::vector<Row> rows;
  std::vector<std::string> names;
  std::ifstream table(path);
  for (std::string line; std::getline(table, line);) {
    std::istringstream cells(line);
    Row row;
    std::size_t column = 0;
    for (std::string cell; std::getline(cells, cell, '\t'); ++column)
      if (rows.empty() && names.size() == column)
        names.push_back(cell);
      else
        row[names.at(column)] = cell;
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

std::uint64_t count_components(const BaseMesh& mesh) {
  std::vector<char> seen(mesh.face_count(), 0);
  std::uint64_t components = 0;
  for (FaceId seed = 0; seed < mesh.face_count(); ++seed) {
    if (seen[seed]) continue;
    ++components;
    seen[seed] = 1;
    for (std::vector<FaceId> stack = {seed}; !stack.empty();) {
      const FaceId face = stack.back();
      stack.pop_back();
      for (const int side : {0, 1, 2}) {
        const FaceSide beyond = mesh.topology().across(FaceSide(face, side));
        if (!beyond.exists() || seen[beyond.face()]) continue;
        seen[beyond.face()] = 1;
        stack.push_back(beyond.face());
      }
    }
  }
  return components;
}

/// A border edge runs from start to end in its face, so each border vertex is the start of exactly
/// one.
std::uint64_t count_border_loops(const BaseMesh& mesh) {
  std::map<VertexId, VertexId> next;
  for (const EdgeId edge : mesh.border_edges())
    next[mesh.edges()[edge].start] = mesh.edges()[edge].end;
  std::uint64_t loops = 0;
  for (; !next.empty(); ++loops)
    for (auto at = next.begin(); at != next.end();) {
      const VertexId end = at->second;
      next.erase(at);
      at = next.find(end);
    }
  return loops;
}

}  // namespace

TEST_CASE("ReadBaseMesh_EveryModel_MatchesTheTable") {
  const std::filesystem::path directory = PLAIT_MODELS_DIRECTORY;
  if (!std::filesystem::exists(directory / "models.tsv")) {
    test::skip("no models.tsv in " + directory.string());
    return;
  }
  const std::vector<Row> table = read_table(directory / "models.tsv");
  CHECK(table.size() >= 10);
  for (const Row& row : table) {
    if (unless_sanitized(false, true) && row.at("file") != "spot.ply") continue;
    const auto number = [&](const char* column) { return std::stoull(row.at(column)); };
    INFO(row.at("file"));
    std::vector<std::string> warnings;
    const BaseMesh mesh = read_base_mesh(directory / row.at("file"), &warnings);
    shapes::check_topology(mesh);
    CHECK(mesh.vertex_count() == number("V") - number("isolated"));
    CHECK(mesh.edge_count() == number("E"));
    CHECK(mesh.face_count() == number("F"));
    CHECK(mesh.border_edge_count() == number("boundary_edges"));
    CHECK(count_border_loops(mesh) == number("boundary_loops"));
    CHECK(count_components(mesh) == number("components"));
    CHECK(shapes::euler_number(mesh) ==
          static_cast<std::int64_t>(2 * number("components")) -
              static_cast<std::int64_t>(2 * number("genus") + number("boundary_loops")));
    std::erase_if(warnings, [](const std::string& warning) {
      return warning.find(": left out: ") != std::string::npos;
    });
    CHECK(warnings.size() == (number("isolated") > 0 ? 1 : 0));

    std::vector<std::uint64_t> valence(mesh.vertex_count(), 0);
    for (const Edge& edge : mesh.edges()) ++valence[edge.start], ++valence[edge.end];
    CHECK(*std::min_element(valence.begin(), valence.end()) == number("valence_min"));
    CHECK(*std::max_element(valence.begin(), valence.end()) == number("valence_max"));
  }
}
