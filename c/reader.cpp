// Readers: patches and vertices.
#include "plait/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <string>

#include "guard.h"
#include "handles.h"
#include "io/huge_pages.h"
#include "plait.h"
#include "sized.h"
#include "statistics.h"

namespace plait::c {
namespace {

const Reader& reader_of(const plait_reader* handle) {
  check_given(handle, "reader");
  return handle->reader;
}

ReaderOptions reader_options(const plait_reader_options& wanted) {
  check_reserved(wanted.reserved);
  check_choice("eviction", wanted.eviction, 2);
  ReaderOptions options;
  options.attributes = names_in(wanted.attributes, wanted.attribute_count);
  options.policy = wanted.eviction == PLAIT_EVICTION_CLOCK ? EvictionPolicy::kClock
                                                           : EvictionPolicy::kLayoutOrder;
  options.share_bytes = wanted.share_bytes;
  return options;
}

/// Bytes of a record, or 0 for an attribute that the store does not have.
std::size_t record_bytes(const plait_reader& handle, std::string_view name) {
  const auto found = std::ranges::find(handle.schemas, name, &AttributeSchema::name);
  return found == handle.schemas.end() ? 0 : found->record_bytes();
}

plait::Vector3<double> vector_of(const double* numbers, const char* argument) {
  check_given(numbers, argument);
  return {numbers[0], numbers[1], numbers[2]};
}

void check_room(std::size_t needed, std::uint64_t capacity, const char* what) {
  if (capacity < needed)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("capacity: expected room for {} {}, found {}", needed, what, capacity));
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_reader_open(const plait_store* store, const plait_reader_options* options,
                               plait_reader** reader) {
  return guarded("plait_reader_open", [&] {
    read_store(store);
    check_given(reader, "reader");
    const plait_reader_options wanted =
        options_of(options, plait_reader_options PLAIT_READER_OPTIONS_INIT);
    *reader = new plait_reader(*store, reader_options(wanted));
  });
}

void plait_reader_close(plait_reader* reader) { delete reader; }

plait_status plait_reader_read_patch(const plait_reader* reader, uint32_t face, int32_t level,
                                     plait_view** view) {
  return guarded("plait_reader_read_patch", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(view, "view");
    *view = new plait_view(from.read_patch(face, level));
  });
}

plait_status plait_reader_visit_patches(const plait_reader* reader, const uint32_t* faces,
                                        uint64_t face_count, int32_t level, plait_visit_patch visit,
                                        void* user) {
  return guarded("plait_reader_visit_patches", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(faces, "faces");
    check_given(visit, "visit");
    from.for_each_patch(std::span(faces, face_count), level, [&](const plait::PatchView& patch) {
      const plait_view lent(patch);
      if (visit(&lent, user) == 0) refuse_cancelled("visit patches");
    });
  });
}

plait_status plait_reader_prefetch(const plait_reader* reader, const uint32_t* faces,
                                   uint64_t face_count, int32_t level, uint64_t* begun) {
  return guarded("plait_reader_prefetch", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(faces, "faces");
    const std::size_t count = from.prefetch(std::span(faces, face_count), level);
    if (begun != nullptr) *begun = count;
  });
}

plait_status plait_reader_end_prefetch(const plait_reader* reader) {
  return guarded("plait_reader_end_prefetch", [&] { reader_of(reader).end_prefetch(); });
}

plait_status plait_reader_faces_in_box(const plait_reader* reader, const char* attribute,
                                       const double* low, const double* high, uint32_t* faces,
                                       uint64_t capacity, uint64_t* face_count) {
  return guarded("plait_reader_faces_in_box", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(face_count, "face_count");
    const auto found = from.faces_in_box({vector_of(low, "low"), vector_of(high, "high")},
                                         text_or(attribute, "position"));
    if (faces != nullptr) {
      check_room(found.size(), capacity, "faces");
      std::ranges::copy(found, faces);
    }
    *face_count = found.size();
  });
}

plait_status plait_reader_faces_along_ray(const plait_reader* reader, const char* attribute,
                                          const double* origin, const double* direction,
                                          uint32_t* faces, double* distances, uint64_t capacity,
                                          uint64_t* face_count) {
  return guarded("plait_reader_faces_along_ray", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(face_count, "face_count");
    const auto found =
        from.faces_along_ray(vector_of(origin, "origin"), vector_of(direction, "direction"),
                             text_or(attribute, "position"));
    if (faces != nullptr || distances != nullptr) check_room(found.size(), capacity, "faces");
    for (std::size_t at = 0; at < found.size(); ++at) {
      if (faces != nullptr) faces[at] = found[at].face;
      if (distances != nullptr) distances[at] = found[at].distance;
    }
    *face_count = found.size();
  });
}

plait_status plait_reader_patch_indices(const plait_reader* reader, int32_t level,
                                        uint32_t* indices, uint64_t capacity,
                                        uint64_t* triangle_count) {
  return guarded("plait_reader_patch_indices", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(triangle_count, "triangle_count");
    const auto triangles = from.patch_indices(level);
    if (indices != nullptr) {
      check_room(triangles.size(), capacity, "triangles");
      std::memcpy(indices, triangles.data(), triangles.size() * sizeof(triangles[0]));
    }
    *triangle_count = triangles.size();
  });
}

plait_status plait_reader_vertex_count(const plait_reader* reader, int32_t level, uint64_t* count) {
  return guarded("plait_reader_vertex_count", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(count, "count");
    *count = from.vertex_count(level);
  });
}

plait_status plait_reader_read_vertices(const plait_reader* reader, const char* name, int32_t level,
                                        uint64_t first, uint64_t count, void* records,
                                        uint64_t bytes) {
  return guarded("plait_reader_read_vertices", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(name, "name");
    check_given(records, "records");
    const std::size_t each = record_bytes(*reader, name);
    if (each != 0 && (bytes % each != 0 || bytes / each != count))
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         fmt::format("bytes: expected {} records of {} bytes, found {} bytes",
                                     count, each, bytes));
    const std::span<std::byte> to(static_cast<std::byte*>(records), bytes);
    std::size_t at = 0;
    from.for_each_block_of_bytes(name, level, first, count,
                                 [&](std::uint64_t, std::span<const std::byte> block) {
                                   plait::touch_huge_pages(to, at, block.size());
                                   std::memcpy(to.data() + at, block.data(), block.size());
                                   at += block.size();
                                 });
  });
}

plait_status plait_reader_visit_vertices(const plait_reader* reader, const char* name,
                                         int32_t level, uint64_t first, uint64_t count,
                                         plait_visit_records visit, void* user) {
  return guarded("plait_reader_visit_vertices", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(name, "name");
    check_given(visit, "visit");
    const std::size_t each = record_bytes(*reader, name);
    from.for_each_block_of_bytes(name, level, first, count,
                                 [&](std::uint64_t vertex, std::span<const std::byte> block) {
                                   if (visit(block.data(), vertex, block.size() / each, user) == 0)
                                     refuse_cancelled("visit vertices");
                                 });
  });
}

plait_status plait_reader_view_count(const plait_reader* reader, uint64_t* count) {
  return guarded("plait_reader_view_count", [&] {
    const plait::Reader& from = reader_of(reader);
    check_given(count, "count");
    *count = from.view_count();
  });
}

plait_status plait_reader_get_statistics(const plait_reader* reader,
                                         plait_paging_statistics* statistics) {
  return guarded("plait_reader_get_statistics", [&] {
    const plait::Reader& from = reader_of(reader);
    check_result(statistics, "statistics");
    fill(statistics, statistics_of(from.statistics()));
  });
}
