#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "base/default_arithmetic.h"
#include "base/stopwatch.h"
#include "execution/part_digest.h"
#include "format/base_mesh_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "parts/done_file.h"
#include "parts/plan_file.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/parts.h"
#include "store/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "host";
  std::string host(name.data());
  for (char& c : host)
    if (c == '-' || !is_in_directory_names(c)) c = '_';
  return host;
}

std::string own_prefix(std::uint32_t part) {
  return fmt::format("{}{}-", part_prefix(part), host_name());
}

/// The directory of a part that is being made. The destructor removes it unless the part is
/// complete. A lock (flock) tells other processes of this machine that it is in use.
class PartDirectory {
 public:
  PartDirectory(const Directory& plan, std::uint32_t part) : plan_(plan) {
    std::random_device device;
    // Another process may remove the directory as a left-over before it is locked.
    do {
      name_ = fmt::format("{}{:08x}{:08x}", own_prefix(part), device(), device());
      made_ = Directory::make(plan.path_of(name_));
    } while (!made_.lock(true) || !plan.contains(name_, made_.descriptor()));
  }
  ~PartDirectory() {
    if (!is_kept_) remove(plan_, name_);
  }
  PartDirectory(const PartDirectory&) = delete;
  PartDirectory& operator=(const PartDirectory&) = delete;

  const Directory& made() const { return made_; }
  const std::string& name() const { return name_; }
  void keep() { is_kept_ = true; }

  /// Removes the files of a part, and the directory if it has no others.
  static void remove(const Directory& plan, const std::string& name) noexcept {
    try {
      const Directory made(plan, name);
      for (const std::string& file : made.names())
        if (is_version_file_name(file) || file == kRecordsName || file.starts_with("done."))
          made.remove_if_possible(file);
      plan.remove_directory(name);
    } catch (const std::exception&) {  // what stays does no harm
    }
  }

 private:
  const Directory& plan_;
  std::string name_;
  Directory made_;
  bool is_kept_ = false;
};

void write_synced(const Directory& directory, const std::string& name,
                  std::span<const std::byte> bytes) {
  File file(directory, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
}

/// The part if it is complete, whatever is wrong with it otherwise.
std::optional<DoneFile> find_done(const Directory& directory, const PlanFile& plan,
                                  std::uint32_t part) {
  try {
    return read_done_part(directory, plan, part);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotSupported &&
        error.code() != ErrorCode::kNotFound)
      throw;
    return std::nullopt;
  }
}

/// Removes what killed processes of this machine have left of a part.
void remove_left_overs(const Directory& directory, const PlanFile& plan, std::uint32_t part) {
  const std::string prefix = own_prefix(part);
  for (const std::string& name : directory.names()) {
    if (!name.starts_with(prefix)) continue;
    try {
      const Directory left(directory, name);
      if (!left.lock(true)) continue;
      // A process that ended in the meantime has given done.I its name before it gave up the lock.
      const std::optional<DoneFile> done = find_done(directory, plan, part);
      if (!done || done->directory != name) PartDirectory::remove(directory, name);
    } catch (const Error&) {  // another process removes it
    }
  }
}

Store create_store(const Directory& plan_directory, const PlanFile& plan, std::uint32_t part,
                   const Directory& directory, const PartOptions& options,
                   const BackendRegistry& backends) {
  const File base(plan_directory, kBaseMeshName, OpenMode::kRead);
  refuse_hole(base);
  BaseMesh mesh = read_base_mesh_file(base, plan.base_mesh, plan.vertex_count, plan.face_count);
  if (mesh.edge_count() != plan.edge_count)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: expected {} edges, found {}",
                                                    plan_directory.path_of(kBaseMeshName).native(),
                                                    plan.edge_count, mesh.edge_count()));
  StoreOptions store;
  store.backend = plan.plan.backend;
  store.block_bytes = plan.block_bytes;
  store.budget_bytes = options.budget_bytes;
  if (!plan.position_pipeline.empty())
    store.pipeline_of = [position = plan.position_pipeline,
                         normal = plan.normal_pipeline](const AttributeSchema& schema) {
      return LevelPipelines(schema.name == "normal" ? normal : position);
    };
  PartOfStore of{plan.plan.uuid, EdgeShards(plan.starts(), plan.edge_count), part, plan.base_mesh};
  return create_part_store(directory.path(), std::move(mesh), store, backends,
                           {.layout = plan.layout, .base_level = plan.plan.base_level},
                           std::move(of));
}

/// Gives done.I its name. If another process was faster, its part stays, unless it is damaged or
/// `again` asks for a new one.
bool publish(const PartDirectory& made, const Directory& plan_directory, const PlanFile& plan,
             const DoneFile& done, bool again) {
  const std::string name = done_file_name(done.part);
  write_synced(made.made(), name, encode_done_file(plan, done));
  made.made().sync();
  plan_directory.sync();
  if (!again && made.made().rename(name, plan_directory, name, Renaming::kRefuse)) return true;
  if (!again && find_done(plan_directory, plan, done.part)) return false;
  made.made().rename(name, plan_directory, name, Renaming::kReplace);
  return true;
}

}  // namespace

PartResult make_part(const std::filesystem::path& path, std::uint32_t part,
                     const PartOptions& options, const BackendRegistry& backends) try {
  const Stopwatch clock;
  const DefaultArithmetic arithmetic;
  const Directory plan_directory = open_plan_directory(path);
  const PlanFile plan = read_plan_file(plan_directory);
  if (part >= plan.plan.parts.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("make part {} of {}: expected 0 to {}", part, path.native(),
                            plan.plan.parts.size() - 1));
  if (plan.plan.program != program_version())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("make part {} of {}: plait {} made the plan, and this is plait {}: all "
                            "parts need the same",
                            part, path.native(), plan.plan.program, program_version()));
  const auto result_of = [&](const DoneFile& done, bool was_done) {
    PartResult result{was_done, done.digest.to_string(), 0, done.seconds};
    for (const auto& level : done.levels) result.bytes += level.bytes;
    return result;
  };
  if (!options.again)
    if (const std::optional<DoneFile> done = find_done(plan_directory, plan, part)) {
      remove_left_overs(plan_directory, plan, part);
      return result_of(*done, true);
    }
  const std::optional<DoneFile> before = find_done(plan_directory, plan, part);
  remove_left_overs(plan_directory, plan, part);

  PartDirectory made(plan_directory, part);
  DoneFile done;
  done.part = part;
  done.directory = made.name();
  Store store = create_store(plan_directory, plan, part, made.made(), options, backends);
  add_base_positions(store, plan.precision);
  SubdivideOptions subdivision;
  subdivision.scheme = scheme_from_name(plan.scheme);
  subdivision.levels = plan.plan.levels;
  subdivision.normals = plan.normals;
  subdivision.limit = plan.limit;
  subdivision.executor = ExecutorKind::kFused;
  subdivision.threads = options.threads;
  subdivision.progress = options.progress;
  subdivide(store, subdivision);
  PartContent content = finish_part_store(store);
  done.digest = digest_of_part(
      store,
      owned_vertices(store.base().topology(), EdgeShards(plan.starts(), plan.edge_count), part),
      options.progress);
  store.close();
  write_synced(made.made(), tables_file_name(1, part), content.tables);
  write_synced(made.made(), kRecordsName, content.base_records);
  done.description = encode_description(content.description);
  done.levels = std::move(content.levels);
  done.tables_checksum = checksum_of(content.tables);
  done.records_checksum = checksum_of(content.base_records);
  done.seconds = clock.seconds();
  if (publish(made, plan_directory, plan, done, options.again)) {
    made.keep();
    plan_directory.sync();
    if (before && before->directory != made.name())
      PartDirectory::remove(plan_directory, before->directory);
  }
  return result_of(done, false);
} catch (const std::bad_alloc&) {
  throw out_of_memory(fmt::format("make part {} of {}", part, path.native()));
}

PLAIT_END_NAMESPACE
