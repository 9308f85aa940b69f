// A pass over all vertices, in batches.
#include <string>
#include <vector>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "visit/batch_visit.h"

namespace plait::c {
namespace {

std::vector<BatchAttribute> attributes_of(const plait_visit_attribute* given, std::uint64_t count) {
  if (count > 0) check_given(given, "attributes");
  std::vector<BatchAttribute> attributes;
  for (std::uint64_t at = 0; at < count; ++at) {
    check_given(given[at].name, "name");
    check_choice("access", given[at].access, 3);
    check_choice("rings", given[at].rings, 2);
    if (given[at].rings != 0 && given[at].access != PLAIT_ACCESS_READ)
      throw Error(ErrorCode::kInvalidArgument,
                  std::string("attribute '") + given[at].name +
                      "': expected PLAIT_ACCESS_READ with rings: a pass that reads rings of an "
                      "attribute writes to another one");
    attributes.push_back({given[at].name,
                          given[at].access == PLAIT_ACCESS_READ        ? Access::kRead
                          : given[at].access == PLAIT_ACCESS_OVERWRITE ? Access::kOverwrite
                                                                       : Access::kUpdate,
                          given[at].rings != 0});
  }
  return attributes;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_visit(plait_store* store, const plait_visit_attribute* attributes,
                               uint64_t attribute_count, int32_t first_level, int32_t level,
                               plait_visit_batch visit, plait_progress progress, void* user) {
  return guarded("plait_store_visit", [&] {
    plait::Store& changed = changed_store(store);
    check_given(visit, "visit");
    if (level < PLAIT_FINEST_LEVEL)
      throw plait::Error(
          plait::ErrorCode::kInvalidArgument,
          "level: expected PLAIT_FINEST_LEVEL or 0 and more, found " + std::to_string(level));
    if (first_level < 0)
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         "first_level: expected 0 and more, found " + std::to_string(first_level));
    const std::vector<plait::BatchAttribute> wanted = attributes_of(attributes, attribute_count);
    plait::VisitOptions options;
    options.level = level;
    options.progress = progress_by(progress, user);
    plait::visit_batches(
        changed, options, first_level, wanted, [&](const plait::VertexBatch& batch) {
          std::vector<plait_batch_records> records;
          for (std::size_t at = 0; at < wanted.size(); ++at)
            records.push_back({batch.attributes[at].records, batch.attributes[at].neighbours});
          const plait_vertex_batch told = {sizeof(told),  batch.count,    batch.levels,
                                           batch.places,  records.data(), records.size(),
                                           batch.valence, batch.border,   batch.base,
                                           /*reserved=*/0};
          if (visit(&told, user) == 0) refuse_cancelled("visit");
        });
  });
}
