#include "parts/done_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "format/file_names.h"
#include "format/version_description.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/block_table.h"
#include "store/parts/shard_place.h"
#include "store/parts/shard_tables.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kDoneKind[] = "plait part";
constexpr std::uint64_t kMostDoneBytes = 1u << 20;

Error damaged(const Directory& directory, const std::string& name, const std::string& reason) {
  return Error(ErrorCode::kCorruption,
               fmt::format("open {}: {}", directory.path_of(name).native(), reason))
      .about(directory.path_of(name));
}

void check_size(const Directory& directory, const std::string& name, std::uint64_t expected) {
  const std::optional<File> file = open_if_present(directory, name, OpenMode::kRead);
  if (!file) throw damaged(directory, name, "it is missing");
  if (const std::uint64_t found = file->size(); found != expected)
    throw damaged(directory, name, fmt::format("expected {} bytes, found {}", expected, found));
}

/// `most` is what the plan allows: a file of any size may be a hole, which costs its author
/// nothing.
void check_content(const Directory& directory, const std::string& name, std::uint64_t most,
                   std::uint64_t checksum) {
  const std::optional<File> file = open_if_present(directory, name, OpenMode::kRead);
  if (!file) throw damaged(directory, name, "it is missing");
  if (const std::uint64_t found = file->size(); found > most)
    throw damaged(directory, name, fmt::format("expected at most {} bytes, found {}", most, found));
  refuse_hole(*file);
  if (const std::uint64_t found = checksum_of(*file); found != checksum)
    throw damaged(directory, name,
                  fmt::format("expected checksum {:016x}, found {:016x}", checksum, found));
}

/// The names of the files of an attribute with `levels` levels, in their order.
void add_file_names(const PlanFile& plan, std::uint32_t attribute, int levels, std::uint32_t part,
                    std::vector<std::string>& names) {
  const int files = plan.shares_files ? std::min(levels, 1) : levels;
  for (int at = 1; at <= files; ++at)
    names.push_back(shard_file_name(plan.shares_files, attribute, plan.plan.base_level + at,
                                    plan.version(), part));
}

/// The names of the files of levels of a part, in their order. Errors: kCorruption if the plan has
/// other levels than the description.
std::vector<std::string> level_names(const PlanFile& plan, const VersionDescription& description,
                                     std::uint32_t part, const FieldReader& fields) {
  const auto require = [&](const char* what, auto expected, auto found) {
    fields.require(expected == found, what, found);
  };
  require("the number of vertices", plan.vertex_count, description.vertex_count);
  require("the number of edges", plan.edge_count, description.edge_count);
  require("the number of faces", plan.face_count, description.face_count);
  require("the checksum of the base mesh", plan.base_mesh.checksum, description.base_mesh_checksum);
  require("the size of the base mesh", plan.base_mesh.bytes, description.base_mesh_bytes);
  require("the size of blocks", plan.block_bytes, description.block_bytes);
  require("the backend", plan.plan.backend, description.backend);
  const Provenance& made = description.provenance;
  require("the base level", plan.plan.base_level, made.base_level);
  require("the program", plan.plan.program, made.program);
  require("the scheme", plan.scheme, made.scheme);
  require("limit positions", plan.limit, made.limit);
  require("the layout", plan.layout, made.layout);
  require("the number of attributes", std::size_t{plan.normals ? 2u : 1u},
          description.attributes.size());
  std::vector<std::string> names;
  for (const AttributeRecord& attribute : description.attributes) {
    require("the finest level", plan.plan.levels, description.finest_level(attribute));
    const bool is_normal = names.size() > 0;
    const AttributeSchema expected = {is_normal ? "normal" : "position",
                                      is_normal ? ComponentType::kFloat32 : plan.precision, 3};
    fields.require(attribute.schema == expected, "the attribute", attribute.schema.name);
    add_file_names(plan, attribute.number, static_cast<int>(attribute.levels.size()), part, names);
  }
  return names;
}

/// The same for a part of a pass, whose plan says all.
std::vector<std::string> level_names(const PlanFile& plan, std::uint32_t part) {
  std::vector<std::string> names;
  add_file_names(plan, plan.of_pass.attribute_number, plan.plan.levels - plan.plan.base_level, part,
                 names);
  return names;
}

/// The directory that a part has in the plan. A link and what is no directory are refused.
Directory open_part_directory(const Directory& plan, const std::string& name,
                              const DoneFile& done) {
  if (!plan.contains(done.directory))
    throw damaged(plan, name, fmt::format("the directory {} is missing", done.directory));
  try {
    return {plan, done.directory};
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument) throw;
    throw damaged(plan, name, fmt::format("{} is no directory", done.directory));
  }
}

}  // namespace

bool is_in_directory_names(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
         c == '_' || c == '-';
}

std::vector<std::byte> seal_of(std::span<const std::byte> description) {
  FieldWriter fields;
  fields.put(checksum_of(description));
  return fields.take();
}

std::string done_file_name(std::uint32_t part) { return fmt::format("done.{}", part); }

std::string part_prefix(std::uint32_t part) { return fmt::format("part.{}-", part); }

std::vector<std::byte> encode_done_file(const PlanFile& plan, const DoneFile& done) {
  FieldWriter fields = begin_sealed(kDoneKind);
  put_uuid(fields, plan.plan.uuid);
  fields.put(plan.checksum);
  fields.put(done.part);
  fields.put_text(done.directory, kMostText, "the directory");
  fields.put(static_cast<std::uint32_t>(done.description.size()));
  for (const std::byte byte : done.description) fields.put(static_cast<std::uint8_t>(byte));
  fields.put(static_cast<std::uint32_t>(done.files.size()));
  for (const auto& [name, bytes] : done.files) {
    fields.put_text(name, kMostText, "a file");
    fields.put(bytes);
  }
  for (const std::uint64_t number : {done.tables_checksum, done.records_checksum, done.digest.high,
                                     done.digest.low, std::bit_cast<std::uint64_t>(done.seconds)})
    fields.put(number);
  fields.put_text(done.host, kMostText, "the host");
  fields.put_text(done.user, kMostText, "the user");
  for (const std::uint64_t number :
       {done.begun, std::bit_cast<std::uint64_t>(done.cpu_seconds), done.peak_memory_bytes})
    fields.put(number);
  return seal(fields);
}

namespace {

DoneFile read_fields(const Directory& directory, const PlanFile& plan, std::uint32_t part,
                     const File& file) {
  const std::string name = done_file_name(part);
  SealedFile sealed(file, {kDoneKind}, kMostDoneBytes);
  FieldReader& fields = sealed.fields();
  DoneFile done;
  if (take_uuid(fields) != plan.plan.uuid ||
      fields.take<std::uint64_t>("the plan") != plan.checksum)
    throw damaged(directory, name, "it is a part of another plan");
  done.part = fields.take<std::uint32_t>("the part");
  if (done.part != part)
    throw damaged(directory, name, fmt::format("expected part {}, found part {}", part, done.part));
  done.directory = fields.take_text(kMostText, "the directory");
  fields.require(done.directory.starts_with(part_prefix(part)) &&
                     std::ranges::all_of(done.directory, is_in_directory_names),
                 "the directory", done.directory);
  const auto bytes = fields.take<std::uint32_t>("the size of the description");
  fields.require(bytes <= fields.bytes_left(), "the size of the description", bytes);
  for (std::uint32_t at = 0; at < bytes; ++at)
    done.description.push_back(static_cast<std::byte>(fields.take<std::uint8_t>("a byte")));
  const std::vector<std::string> names =
      plan.plan.pass
          ? level_names(plan, part)
          : level_names(plan, decode_description(done.description, 1, file.path()), part, fields);
  const auto count = fields.take<std::uint32_t>("the number of files");
  fields.require(count == names.size(), "the number of files", count);
  for (const std::string& expected : names) {
    PartContent::FileOfPart of;
    of.name = fields.take_text(kMostText, "a file");
    fields.require(of.name == expected, "a file", of.name);
    of.bytes = fields.take<std::uint64_t>("the size of a file");
    done.files.push_back(std::move(of));
  }
  for (std::uint64_t* number :
       {&done.tables_checksum, &done.records_checksum, &done.digest.high, &done.digest.low})
    *number = fields.take<std::uint64_t>("a checksum");
  done.seconds = std::bit_cast<double>(fields.take<std::uint64_t>("the seconds"));
  done.host = fields.take_text(kMostText, "the host");
  done.user = fields.take_text(kMostText, "the user");
  done.begun = fields.take<std::uint64_t>("the begin");
  done.cpu_seconds = std::bit_cast<double>(fields.take<std::uint64_t>("the processor seconds"));
  done.peak_memory_bytes = fields.take<std::uint64_t>("the memory");
  for (const double seconds : {done.seconds, done.cpu_seconds})
    fields.require(seconds >= 0 && std::isfinite(seconds), "the seconds", seconds);
  return done;
}

/// Throws unless the files are there, with their sizes or checksums.
void check_files_of(const Directory& directory, const PlanFile& plan, const DoneFile& done) {
  const std::uint32_t part = done.part;
  const std::string name = done_file_name(part);
  const Directory inside = open_part_directory(directory, name, done);
  for (const auto& [file, bytes] : done.files) check_size(inside, file, bytes);
  const PlannedPart& planned = plan.plan.parts[part];
  // A block has one slot or more; a record at most three numbers of eight bytes.
  const auto of_attribute = static_cast<std::uint64_t>(plan.plan.levels - plan.plan.base_level);
  const std::uint64_t levels =
      plan.plan.pass ? plan.of_pass.level_count : (plan.normals ? 2 : 1) * of_attribute;
  const std::uint64_t record_bytes = plan.plan.pass ? plan.plan.pass->result.record_bytes()
                                                    : (plan.normals ? 2 : 1) * 3 * sizeof(double);
  check_content(inside, tables_file_name(plan.version(), part),
                kShardTablesHeaderBytes +
                    (planned.edge_after - planned.first_edge) * levels * sizeof(BlockEntry),
                done.tables_checksum);
  check_content(inside, kRecordsName, plan.vertex_count * record_bytes, done.records_checksum);
}

}  // namespace

std::optional<DoneFile> read_done_file(const Directory& directory, const PlanFile& plan,
                                       std::uint32_t part) {
  const std::optional<File> file =
      open_if_present(directory, done_file_name(part), OpenMode::kRead);
  if (!file) return std::nullopt;
  return read_fields(directory, plan, part, *file);
}

std::optional<DoneFile> read_done_part(const Directory& directory, const PlanFile& plan,
                                       std::uint32_t part) {
  const std::string name = done_file_name(part);
  for (int attempt = 1;; ++attempt) {
    const std::optional<File> file = open_if_present(directory, name, OpenMode::kRead);
    if (!file) return std::nullopt;
    try {
      DoneFile done = read_fields(directory, plan, part, *file);
      check_files_of(directory, plan, done);
      return done;
    } catch (const Error&) {
      // A process that makes the part again removes the files of the former one.
      if (attempt == kMostReplacements || directory.contains(name, file->descriptor())) throw;
    }
  }
}

PLAIT_END_NAMESPACE
