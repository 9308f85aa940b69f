// Served stores: what a browser reads of a store.
#include <fmt/format.h>

#include <cstddef>
#include <span>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "publish/served_store.h"
#include "sized.h"

namespace plait::c {
namespace {

const ServedStore::File& file_of(const plait_served* handle, const char* path) {
  check_given(handle, "served");
  check_given(path, "path");
  const ServedStore::File* const file = handle->files.find(path);
  if (file == nullptr)
    throw Error(ErrorCode::kNotFound, fmt::format("served store: no file '{}'", path));
  return *file;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_served_open(plait_store* store, plait_progress progress, void* user,
                               plait_served** served) {
  return guarded("plait_served_open", [&] {
    plait::Store& opened = changed_store(store);
    check_given(served, "served");
    *served = new plait_served(opened, progress_by(progress, user));
  });
}

plait_status plait_served_find(const plait_served* served, const char* path,
                               plait_served_file* file) {
  return guarded("plait_served_find", [&] {
    const plait::ServedStore::File& found = file_of(served, path);
    check_result(file, "file");
    fill(file, plait_served_file{sizeof(plait_served_file), found.bytes, found.content_type.c_str(),
                                 served->files.tag().c_str()});
  });
}

plait_status plait_served_read(const plait_served* served, const char* path, uint64_t offset,
                               void* bytes, uint64_t count) {
  return guarded("plait_served_read", [&] {
    const plait::ServedStore::File& file = file_of(served, path);
    check_given(bytes, "bytes");
    if (offset > file.bytes || count > file.bytes - offset)
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         fmt::format("served store: bytes {} to {} of '{}': the file has {}",
                                     offset, offset + count, path, file.bytes));
    served->files.read(file, offset, std::span(static_cast<std::byte*>(bytes), count));
  });
}

void plait_served_close(plait_served* served) { delete served; }
