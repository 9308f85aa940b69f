// Patch writers: they fill levels patch by patch.
#include "plait/patch_writer.h"

#include <optional>
#include <span>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "sized.h"
#include "statistics.h"

namespace plait::c {
namespace {

PatchWriter& writer_of(plait_patch_writer* handle) {
  check_given(handle, "writer");
  return handle->writer;
}

std::optional<int> level_of(std::int32_t level) {
  return level == PLAIT_OUTERMOST_LEVEL ? std::nullopt : std::optional<int>(level);
}

PatchWriterOptions writer_options(const plait_patch_writer_options& wanted) {
  check_reserved(wanted.reserved);
  check_choice("compare", wanted.compare, 2);
  return {names_in(wanted.attributes, wanted.attribute_count), level_of(wanted.first_level),
          level_of(wanted.last_level), wanted.compare == 1, wanted.share_bytes};
}

std::span<const std::byte> bytes_of(const void* records, std::uint64_t bytes) {
  check_given(records, "records");
  return {static_cast<const std::byte*>(records), bytes};
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_patch_writer_open(plait_store* store, const plait_patch_writer_options* options,
                                     plait_patch_writer** writer) {
  return guarded("plait_patch_writer_open", [&] {
    plait::Store& to = changed_store(store);
    check_given(writer, "writer");
    const plait_patch_writer_options wanted =
        options_of(options, plait_patch_writer_options PLAIT_PATCH_WRITER_OPTIONS_INIT);
    *writer = new plait_patch_writer(to, writer_options(wanted));
  });
}

plait_status plait_patch_writer_write_patch(plait_patch_writer* writer, const char* name,
                                            uint32_t face, int32_t level, const void* records,
                                            uint64_t bytes) {
  return guarded("plait_patch_writer_write_patch", [&] {
    plait::PatchWriter& to = writer_of(writer);
    check_given(name, "name");
    to.write_patch_of_bytes(name, face, level, bytes_of(records, bytes));
  });
}

plait_status plait_patch_writer_write_level(plait_patch_writer* writer, const char* name,
                                            uint32_t face, int32_t level, const void* records,
                                            uint64_t bytes) {
  return guarded("plait_patch_writer_write_level", [&] {
    plait::PatchWriter& to = writer_of(writer);
    check_given(name, "name");
    to.write_level_of_bytes(name, face, level, bytes_of(records, bytes));
  });
}

plait_status plait_patch_writer_finish(plait_patch_writer* writer) {
  return guarded("plait_patch_writer_finish", [&] { writer_of(writer).finish(); });
}

plait_status plait_patch_writer_get_statistics(const plait_patch_writer* writer,
                                               plait_paging_statistics* statistics) {
  return guarded("plait_patch_writer_get_statistics", [&] {
    check_given(writer, "writer");
    check_result(statistics, "statistics");
    fill(statistics, statistics_of(writer->writer.statistics()));
  });
}

void plait_patch_writer_close(plait_patch_writer* writer) { delete writer; }
