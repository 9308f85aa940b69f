#include "parts/pass_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "base/stopwatch.h"
#include "execution/part_digest.h"
#include "parts/pass_result.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "store/parts/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::uint32_t level_count_of(const VersionDescription& description) {
  std::size_t count = 0;
  for (const AttributeRecord& attribute : description.attributes) count += attribute.levels.size();
  return static_cast<std::uint32_t>(count);
}

}  // namespace

VersionDescription check_pass_fits(const PlanFile& plan, const StoredVersion& version,
                                   const std::filesystem::path& path) {
  const PlannedPass& planned = *plan.plan.pass;
  const Manifest& manifest = version.manifest();
  if (manifest.uuid != plan.plan.uuid)
    throw Error(ErrorCode::kBadState,
                fmt::format("pass {}: expected the store that the plan was made of, found another "
                            "one with {}",
                            path.native(), version.version_name()));
  if (manifest.sequence != planned.version)
    throw Error(ErrorCode::kBadState,
                fmt::format("pass {}: expected version {} of the store, found version {}: the plan "
                            "is done or out of date, make a new one",
                            path.native(), planned.version, manifest.sequence));
  const VersionDescription& description = version.description();
  const auto require = [&](std::string_view what, const auto& expected, const auto& found) {
    if (expected != found)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("pass {}: {}: the store has {}, the plan says {}", path.native(),
                              what, expected, found));
  };
  require("vertices", description.vertex_count, plan.vertex_count);
  require("edges", description.edge_count, plan.edge_count);
  require("faces", description.face_count, plan.face_count);
  require("base level", description.provenance.base_level, plan.plan.base_level);
  require("parts", description.shards.size(), plan.plan.parts.size());
  for (std::size_t at = 0; at < description.shards.size(); ++at)
    require("first edge of a part", description.shards[at].first_edge,
            plan.plan.parts[at].first_edge);
  VersionDescription next;
  try {
    next = version_after(description, planned.pass, plan.version(), plan.plan.program);
  } catch (const Error& error) {
    throw Error(ErrorCode::kCorruption, fmt::format("pass {}: {}", path.native(), error.what()));
  }
  const auto made =
      std::ranges::find(next.attributes, plan.of_pass.attribute_number, &AttributeRecord::number);
  require("the number of the result", description.next_attribute_number,
          plan.of_pass.attribute_number);
  if (made->schema != planned.result)
    throw Error(ErrorCode::kCorruption,
                fmt::format("pass {}: expected the attribute '{}' as result, found '{}'",
                            path.native(), made->schema.name, planned.result.name));
  require("finest level", next.finest_level(*made), plan.plan.levels);
  require("levels", level_count_of(next), plan.of_pass.level_count);
  return next;
}

ComputedPart compute_pass_part(const PlanFile& plan, std::uint32_t part, const Directory& plan_path,
                               const Directory& directory, const PartOptions& options,
                               const BackendRegistry& backends) {
  const PlannedPass& planned = *plan.plan.pass;
  ComputedPart computed;
  const Stopwatch clock;
  PartOfVersion of;
  of.shard = part;
  of.directory = directory.path();
  of.check = [&](const StoredVersion& version) {
    check_pass_fits(plan, version, plan_path.path());
  };
  Store store = open_part_store(planned.store, of, options.budget_bytes, backends);
  computed.begin_seconds = clock.seconds();
  Pass pass = planned.pass;
  pass.kernel = options.kernel;
  VisitOptions visit;
  visit.threads = options.threads;
  visit.progress = options.progress;
  PassFigures figures;
  const AttributeId result = make_result(store, pass, visit, figures);
  const double visited = clock.seconds();
  computed.content = finish_part_store(store);
  const double written = clock.seconds();
  computed.digest = digest_of_part(store, *StoreAccess::own_vertices(store), std::array{result},
                                   options.progress);
  store.close();
  computed.write_seconds = written - visited;
  computed.compute_seconds = clock.seconds() - computed.write_seconds - computed.begin_seconds;
  return computed;
}

PLAIT_END_NAMESPACE
