// handles.h: what the opaque types of plait.h are.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "plait.h"
#include "plait/extend/notices.h"
#include "plait/patch_writer.h"
#include "plait/progress.h"
#include "plait/reader.h"
#include "plait/store.h"
#include "publish/served_store.h"

namespace plait::c {

inline std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += text.empty() ? line : "\n" + line;
  return text;
}

}  // namespace plait::c

struct plait_store {
  plait_store(plait::Store opened, bool for_writing)
      : store(std::move(opened)), writable(for_writing) {}

  /// For plait_store_get_input_maps().
  struct Maps {
    plait::InputMaps input;
    std::vector<std::uint8_t> turned;
  };

  plait::Store store;
  bool writable;
  mutable std::mutex maps_mutex;
  mutable std::unique_ptr<Maps> maps;  ///< made by the first call
  // For plait_store_get_info():
  std::string pipeline = store.options().pipeline->to_text();
  std::string notices = plait::c::joined_lines(plait::notices(store));
};

struct plait_reader {
  plait_reader(const plait_store& of, const plait::ReaderOptions& options)
      : reader(of.store, options) {
    for (const plait::AttributeInfo& info : of.store.attributes()) schemas.push_back(info.schema);
  }

  plait::Reader reader;
  std::vector<plait::AttributeSchema> schemas;
};

struct plait_patch_writer {
  plait_patch_writer(plait::Store& store, const plait::PatchWriterOptions& options)
      : writer(store, options) {}

  plait::PatchWriter writer;
};

/// A view of its own, or one that a visit of patches lends to its callback.
struct plait_view {
  explicit plait_view(const plait::PatchView& lent) : patch(&lent) {}
  explicit plait_view(plait::PatchView&& view) : own(std::move(view)), patch(&own) {}
  plait_view(const plait_view&) = delete;
  plait_view& operator=(const plait_view&) = delete;

  plait::PatchView own;
  const plait::PatchView* patch;
};

struct plait_served {
  plait_served(plait::Store& store, const plait::ProgressCallback& progress)
      : files(store, progress) {}

  plait::ServedStore files;
};

/// Records that stay at their addresses.
struct plait_pin {
  plait::PinnedVertices vertices;
};

namespace plait::c {

/// The callback of a C program as the library calls it: false cancels. May be NULL.
ProgressCallback progress_by(plait_progress progress, void* user);
/// The parallel loop of a C program as the library calls it. May be NULL.
ParallelFor parallel_for_by(plait_parallel_for parallel_for, void* user);

/// The store of a handle that a call changes. Errors: kInvalidArgument for NULL.
Store& changed_store(plait_store* handle);
/// The store of a handle that a call only reads. Errors: kInvalidArgument for NULL.
const Store& read_store(const plait_store* handle);
/// Errors: kNotFound; kInvalidArgument for NULL.
AttributeId attribute_named(const Store& store, const char* name);
/// The type with this number. Errors: kInvalidArgument if there is none.
plait::ComponentType component_type_of(plait_component_type number);
/// The names that options have; empty for NULL. Errors: kInvalidArgument for a name that is NULL.
std::vector<std::string> names_in(const char* const* attributes, std::uint64_t count);

}  // namespace plait::c
