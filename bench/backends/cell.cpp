#include "backends/cell.h"

#include <fmt/format.h>

namespace plait::bench {

nlohmann::ordered_json to_json(const Cell& cell) {
  const double ratio =
      static_cast<double>(cell.raw_bytes()) / static_cast<double>(cell.memory_bytes);
  nlohmann::ordered_json object = {{"backend", cell.backend},
                                   {"pipeline", cell.pipeline},
                                   {"disk", cell.disk},
                                   {"workload", cell.workload},
                                   {"mesh", nullptr},
                                   {"vertices", cell.vertices},
                                   {"levels", cell.levels},
                                   {"memory", cell.memory_bytes},
                                   {"budget", cell.budget_bytes},
                                   {"ratio", ratio},
                                   {"block_bytes", cell.block_bytes},
                                   {"threads", cell.threads},
                                   {"durable", true},
                                   {"rate", nullptr}};
  if (!cell.mesh.empty()) object["mesh"] = cell.mesh;
  if (cell.rate > 0) object["rate"] = cell.rate;
  return object;
}

std::string key_of(const Cell& cell) { return to_json(cell).dump(); }

std::string store_name(const Cell& cell) {
  std::string name = fmt::format("{}-{}-{}-{}-{}-{}.plait", cell.backend, cell.pipeline, cell.mesh,
                                 cell.base_vertices, cell.levels, cell.block_bytes);
  for (char& letter : name)
    if (letter == '/') letter = '_';
  return name;
}

std::string surface_name(const Cell& cell) {
  return fmt::format("{}{} vertices at level {}", cell.mesh.empty() ? "" : cell.mesh + ", ",
                     cell.base_vertices, cell.levels);
}

}  // namespace plait::bench
