#include "parts/plan_file.h"

#include <fmt/format.h>

#include <bit>

#include "format/file_names.h"
#include "format/manifest.h"
#include "format/version_description.h"
#include "io/made_mark.h"
#include "parts/pass_result.h"
#include "parts/sealed_file.h"
#include "plait/detail/edge_shards.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kPlanKind[] = "plait plan", kPassKind[] = "plait pass";
constexpr std::uint64_t kMostPlanBytes = 256u << 20;
constexpr std::uint8_t kLimit = 1, kSharesFiles = 2;

void put_pass(FieldWriter& fields, const PlannedPass& planned, const PassVersion& version) {
  const Pass& pass = planned.pass;
  fields.put_utf8(planned.store.native(), kMostText, "the path of the store");
  fields.put(planned.version);
  fields.put(planned.version_checksum);
  fields.put_text(pass.name, kMostText, "the pass");
  fields.put_text(pass.parameters, kMostText, "the parameters of the pass");
  for (const double number : {pass.factor, pass.amplitude, pass.diagonal.value_or(0)})
    fields.put(std::bit_cast<std::uint64_t>(number));
  fields.put(pass.seed);
  fields.put_text(planned.result.name, kMostText, "the attribute");
  fields.put(static_cast<std::uint8_t>(planned.result.type));
  fields.put(static_cast<std::uint8_t>(planned.result.components));
  fields.put(version.attribute_number);
  fields.put(version.level_count);
}

PlannedPass take_pass(FieldReader& fields, PassVersion& version) {
  PlannedPass planned;
  Pass& pass = planned.pass;
  planned.store = fields.take_utf8(kMostText, "the path of the store");
  fields.require(planned.store.is_absolute(), "the path of the store", planned.store.native());
  planned.version = fields.take<std::uint64_t>("the version");
  fields.require(planned.version >= 1 && planned.version < kMaxSequence, "the version",
                 planned.version);
  planned.version_checksum = fields.take<std::uint64_t>("the checksum of the version");
  pass.name = fields.take_text(kMostText, "the pass");
  pass.parameters = fields.take_text(kMostText, "the parameters of the pass");
  for (double* number : {&pass.factor, &pass.amplitude})
    *number = std::bit_cast<double>(fields.take<std::uint64_t>("an option"));
  if (const auto diagonal = std::bit_cast<double>(fields.take<std::uint64_t>("the diagonal"));
      diagonal != 0)
    pass.diagonal = diagonal;
  pass.seed = fields.take<std::uint64_t>("the seed");
  planned.result.name = fields.take_text(kMostText, "the attribute");
  const auto type = fields.take<std::uint8_t>("the type of the attribute");
  planned.result.type = static_cast<ComponentType>(type);
  planned.result.components = fields.take<std::uint8_t>("the components of the attribute");
  fields.require(component_bytes(planned.result.type) > 0, "the type of the attribute", type);
  fields.require(planned.result.components > 0, "the components of the attribute", 0);
  pass.result = planned.result;
  try {
    check_pass(pass);
  } catch (const Error& error) {
    fields.require(false, "the pass", error.what());
  }
  version.attribute_number = fields.take<std::uint32_t>("the number of the attribute");
  version.level_count = fields.take<std::uint32_t>("the number of levels");
  fields.require(version.level_count <= kMaxAttributes * kMaxLevel, "the number of levels",
                 version.level_count);
  return planned;
}

}  // namespace

std::vector<EdgeId> PlanFile::starts() const {
  std::vector<EdgeId> starts;
  for (const PlannedPart& part : plan.parts) starts.push_back(part.first_edge);
  return starts;
}

void write_plan_file(const Directory& directory, const PlanFile& file) {
  const PartsPlan& plan = file.plan;
  FieldWriter fields = begin_sealed(plan.pass ? kPassKind : kPlanKind);
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
  fields.put(static_cast<std::uint8_t>((file.limit ? kLimit : 0) |
                                       (file.shares_files ? kSharesFiles : 0)));
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
  if (plan.pass) put_pass(fields, *plan.pass, file.of_pass);
  const std::vector<std::byte> bytes = seal(fields);
  File out(directory, kPlanName, OpenMode::kCreate);
  out.write_at(0, bytes);
  out.sync();
  out.close();
}

PlanFile read_plan_file(const Directory& directory) {
  const File opened(directory, kPlanName, OpenMode::kRead);
  SealedFile sealed(opened, {kPlanKind, kPassKind}, kMostPlanBytes);
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
  const auto flags = fields.take<std::uint8_t>("the flags");
  fields.require((flags & ~(kLimit | kSharesFiles)) == 0, "the flags", flags);
  file.limit = (flags & kLimit) != 0;
  file.shares_files = (flags & kSharesFiles) != 0;
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
  if (sealed.kind() == kPassKind) plan.pass = take_pass(fields, file.of_pass);
  return file;
}

void remove_plan(const Directory& directory) {
  for (const char* const name : {kPlanName, kBaseMeshName, kBaseIndexName, kMadeMarkName})
    directory.remove_if_possible(name);
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
