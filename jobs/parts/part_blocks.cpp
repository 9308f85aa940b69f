#include "parts/part_blocks.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "format/file_names.h"
#include "plait/extend/backend.h"
#include "plait/extend/base_relative_level.h"
#include "store/parts/shard_place.h"
#include "store/parts/shard_tables.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PartBlocks::PartBlocks(const PlanFile& plan, const BaseMesh& mesh,
                       const VersionDescription& description, const EdgeShards& shards,
                       const RegisteredBackend& backend)
    : plan_(plan), mesh_(mesh), description_(description), backend_(backend) {
  for (const AttributeRecord& attribute : description.attributes)
    for (std::size_t at = 0; at < attribute.levels.size(); ++at) {
      const BaseRelativeLevel level(static_cast<int>(at) + 1);
      levels_.push_back(
          mesh.geometry(level, attribute.schema.record_bytes(),
                        block_bytes_of_level(attribute.levels[at].pipeline, level.refinements,
                                             description.block_bytes))
              .in_shards(shards));
    }
}

bool PartBlocks::is_made_by_parts(const AttributeRecord& attribute) const {
  return !plan_.plan.pass || attribute.number == plan_.of_pass.attribute_number;
}

void PartBlocks::read_all(const Directory& plan_directory, const DoneFile& part) const {
  constexpr std::uint64_t kScratchBytes = 64u << 20;
  const Directory inside(plan_directory, part.directory);
  const std::unique_ptr<Volume> volume = backend_.open({kScratchBytes, 1});
  std::vector<LevelGeometry> alone;
  for (const LevelGeometry& level : levels_) alone.push_back(level.shard(part.part));
  const auto tables = read_shard_tables(inside, tables_file_name(plan_.version(), part.part),
                                        plan_.plan.uuid, part.part, part.tables_checksum, alone);
  std::size_t number = 0;
  for (const AttributeRecord& attribute : description_.attributes) {
    int level = description_.provenance.base_level;
    for (const LevelRecord& record : attribute.levels) {
      const std::size_t at = number++;
      ++level;
      if (!is_made_by_parts(attribute)) continue;
      BlockTable table(plan_.plan.uuid, attribute.number, level, tables[at].size(),
                       levels_[at].first_block(part.part));
      std::ranges::copy(tables[at], table.entries().begin());
      table.set_generation(record.generation);
      LevelSpec spec{inside,         {}, OpenMode::kRead, alone[at], table, attribute.schema,
                     record.pipeline};
      place_of({attribute.number, level, plan_.version(), part.part, alone[at]}, plan_.shares_files,
               backend_.traits)
          .put_into(spec);
      spec.surroundings = {
          mesh_.topology(), description_.provenance.base_level, {}, mesh_.positions()};
      const std::unique_ptr<Backend> backend = volume->open_level(spec);
      std::vector<std::byte> bytes(alone[at].max_block_bytes());
      for (std::uint64_t block = 0; block < alone[at].block_count(); ++block)
        backend->read({block, 1}, std::span(bytes).first(alone[at].block_bytes(block)));
    }
  }
}

PLAIT_END_NAMESPACE
