#include "parts/base_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "parts/files_at_once.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/parts/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::vector<ZeroedArray<std::byte>> merge_base_records(
    const Directory& plan_directory, const PlanFile& plan, const std::vector<DoneFile>& parts,
    const BaseMesh& mesh, const std::vector<std::size_t>& record_bytes) {
  const Topology topology = mesh.topology();
  const EdgeShards shards(plan.starts(), plan.edge_count);
  std::vector<std::vector<VertexId>> owned(parts.size());
  for (VertexId vertex = 0; vertex < mesh.vertex_count(); ++vertex)
    owned[owner_of(topology, shards, vertex)].push_back(vertex);
  std::vector<ZeroedArray<std::byte>> records;
  for (const std::size_t bytes : record_bytes) records.emplace_back(mesh.vertex_count() * bytes);
  const std::size_t all = std::accumulate(record_bytes.begin(), record_bytes.end(), std::size_t{0});
  const auto merge = [&](std::size_t number) {
    const DoneFile& done = parts[number];
    const File file(Directory(plan_directory, done.directory), kRecordsName, OpenMode::kRead);
    const std::vector<VertexId>& vertices = owned[done.part];
    if (file.size() != vertices.size() * all)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("join {}: part {} has {} bytes of base records, expected {}",
                              plan_directory.path().native(), done.part, file.size(),
                              vertices.size() * all))
          .about(file.path());
    std::vector<std::byte> bytes(file.size());
    file.read_at(0, bytes);
    auto from = bytes.begin();
    for (std::size_t at = 0; at < records.size(); ++at) {
      const auto size = static_cast<std::ptrdiff_t>(record_bytes[at]);
      for (const VertexId vertex : vertices) {
        std::copy(from, from + size, records[at].data() + size * vertex);
        from += size;
      }
    }
  };
  each_file_at_once(parts.size(), "a join", merge, {});
  return records;
}

PLAIT_END_NAMESPACE
