// Many patches in one call, and records where they are in memory.
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/reader.h"

namespace plait::c {
namespace {

const Reader& reader_in(const plait_reader* handle) {
  check_given(handle, "reader");
  return handle->reader;
}

/// A list of faces. It may be NULL if it is empty.
std::span<const FaceId> faces_of(const std::uint32_t* faces, std::uint64_t count) {
  if (count > 0) check_given(faces, "faces");
  return {faces, count};
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_reader_copy_patches(const plait_reader* reader, const char* name,
                                       const uint32_t* faces, uint64_t face_count, int32_t level,
                                       void* records, uint64_t bytes) {
  return guarded("plait_reader_copy_patches", [&] {
    const plait::Reader& from = reader_in(reader);
    check_given(name, "name");
    if (bytes > 0) check_given(records, "records");
    from.copy_patches(name, faces_of(faces, face_count), level,
                      {static_cast<std::byte*>(records), bytes});
  });
}

plait_status plait_reader_weld_patches(const plait_reader* reader, const uint32_t* faces,
                                       uint64_t face_count, int32_t level, uint32_t* numbers,
                                       uint64_t capacity, uint64_t* vertex_count) {
  return guarded("plait_reader_weld_patches", [&] {
    const plait::Reader& from = reader_in(reader);
    if (capacity > 0) check_given(numbers, "numbers");
    check_given(vertex_count, "vertex_count");
    *vertex_count =
        from.weld_patches(faces_of(faces, face_count), level, std::span(numbers, capacity));
  });
}

plait_status plait_reader_get_blocks(const plait_reader* reader, const char* name, int32_t level,
                                     uint64_t* firsts, uint64_t capacity, uint64_t* block_count) {
  return guarded("plait_reader_get_blocks", [&] {
    const plait::Reader& from = reader_in(reader);
    check_given(name, "name");
    check_given(block_count, "block_count");
    const std::vector<std::uint64_t> starts = from.block_starts(name, level);
    if (firsts != nullptr) {
      if (capacity < starts.size())
        throw plait::Error(plait::ErrorCode::kInvalidArgument,
                           fmt::format("capacity: expected room for {} blocks, found {}",
                                       starts.size(), capacity));
      std::ranges::copy(starts, firsts);
    }
    *block_count = starts.size();
  });
}

plait_status plait_reader_pin_vertices(const plait_reader* reader, const char* name, int32_t level,
                                       uint64_t first, uint64_t count, plait_pin** pin,
                                       const void** records, uint64_t* pinned_count) {
  return guarded("plait_reader_pin_vertices", [&] {
    const plait::Reader& from = reader_in(reader);
    check_given(name, "name");
    check_given(pin, "pin");
    check_given(records, "records");
    check_given(pinned_count, "pinned_count");
    plait::PinnedVertices vertices = from.pin_vertices(name, level, first, count);
    const std::span<const std::byte> bytes = vertices.bytes();
    std::uint64_t record_bytes = 0;
    for (const plait::AttributeSchema& schema : reader->schemas)
      if (schema.name == name) record_bytes = schema.record_bytes();
    *pin = new plait_pin{std::move(vertices)};
    *records = bytes.data();
    *pinned_count = bytes.size() / record_bytes;
  });
}

void plait_pin_release(plait_pin* pin) { delete pin; }
