#include "parts/plan_file.h"

#include <fmt/format.h>

#include <bit>

#include "parts/sealed_file.h"
#include "plait/detail/edge_shards.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kPlanKind[] = "plait plan";
constexpr std::uint64_t kMostPlanBytes = 256u << 20;

}  // namespace

std::vector<EdgeId> PlanFile::starts() const {
  std::vector<EdgeId> starts;
  for (const PlannedPart& part : plan.parts) starts.push_back(part.first_edge);
  return starts;
}

void write_plan_file(const Directory& directory, const PlanFile& file) {
  const PartsPlan& plan = file.plan;
  FieldWriter fields = begin_sealed(kPlanKind);
  put_uuid(fields, plan.uuid);
  fields.put_text(plan.program, kMostText, "the program");
  for (const std::uint64_t number :
       {file.vertex_count, file.edge_count, file.face_count, file.base_mesh.bytes,
        file.base_mesh.checksum, file.block_bytes, plan.vertices, plan.files})
    fields.put(number);
  fields.put(static_cast<std::uint32_t>(plan.base_level));
  fields.put(static_cast<std::uint32_t>(plan.levels));
  fields.put(static_cast<std::uint8_t>(file.precision));
  fields.put(static_cast<std::uint8_t>(file.normals));
  fields.put(static_cast<std::uint8_t>(file.limit));
  for (const std::string* text :
       {&file.scheme, &file.layout, &plan.backend, &file.position_pipeline, &file.normal_pipeline})
    fields.put_text(*text, kMostText, "an option");
  fields.put(static_cast<std::uint32_t>(plan.parts.size()));
  for (const PlannedPart& part : plan.parts) {
    fields.put(part.first_edge);
    for (const std::uint64_t number : {part.records, part.faces, part.ghosts, part.bytes})
      fields.put(number);
    fields.put(std::bit_cast<std::uint64_t>(part.seconds));
  }
  const std::vector<std::byte> bytes = seal(fields);
  File out(directory, kPlanName, OpenMode::kCreate);
  out.write_at(0, bytes);
  out.sync();
  out.close();
}

PlanFile read_plan_file(const Directory& directory) {
  SealedFile sealed(File(directory, kPlanName, OpenMode::kRead), kPlanKind, kMostPlanBytes);
  FieldReader& fields = sealed.fields();
  PlanFile file;
  PartsPlan& plan = file.plan;
  file.checksum = sealed.checksum();
  plan.uuid = take_uuid(fields);
  plan.program = fields.take_text(kMostText, "the program");
  for (std::uint64_t* number :
       {&file.vertex_count, &file.edge_count, &file.face_count, &file.base_mesh.bytes,
        &file.base_mesh.checksum, &file.block_bytes, &plan.vertices, &plan.files})
    *number = fields.take<std::uint64_t>("a size");
  for (const std::uint64_t count : {file.vertex_count, file.edge_count, file.face_count})
    fields.require(count < kNoId, "the size of the base mesh", count);
  plan.base_level = static_cast<int>(fields.take<std::uint32_t>("the base level"));
  plan.levels = static_cast<int>(fields.take<std::uint32_t>("the level"));
  fields.require(plan.base_level >= 0 && plan.base_level < plan.levels && plan.levels <= kMaxLevel,
                 "the level", plan.levels);
  const auto precision = fields.take<std::uint8_t>("the precision");
  file.precision = static_cast<ComponentType>(precision);
  fields.require(
      file.precision == ComponentType::kFloat32 || file.precision == ComponentType::kFloat64,
      "the precision", precision);
  file.normals = fields.take<std::uint8_t>("an option") != 0;
  file.limit = fields.take<std::uint8_t>("an option") != 0;
  for (std::string* text :
       {&file.scheme, &file.layout, &plan.backend, &file.position_pipeline, &file.normal_pipeline})
    *text = fields.take_text(kMostText, "an option");
  const auto count = fields.take<std::uint32_t>("the number of parts");
  fields.require(count > 0 && count <= kMostShards && count <= fields.bytes_left() / 44,
                 "the number of parts", count);
  for (std::uint32_t at = 0; at < count; ++at) {
    PlannedPart part;
    part.first_edge = fields.take<std::uint32_t>("an edge");
    fields.require(
        part.first_edge < file.edge_count &&
            (at == 0 ? part.first_edge == 0 : part.first_edge > plan.parts.back().first_edge),
        "the first edge of a part", part.first_edge);
    for (std::uint64_t* number : {&part.records, &part.faces, &part.ghosts, &part.bytes})
      *number = fields.take<std::uint64_t>("a figure");
    part.seconds = std::bit_cast<double>(fields.take<std::uint64_t>("a figure"));
    part.edge_after = static_cast<EdgeId>(file.edge_count);
    if (at > 0) plan.parts.back().edge_after = part.first_edge;
    plan.parts.push_back(part);
  }
  return file;
}

Directory open_plan_directory(const std::filesystem::path& plan) {
  Directory directory(plan);
  if (!directory.contains(kPlanName))
    throw Error(ErrorCode::kNotFound,
                fmt::format("open {}: expected a plan, found a directory without the file {}",
                            plan.native(), kPlanName));
  return directory;
}

PLAIT_END_NAMESPACE
