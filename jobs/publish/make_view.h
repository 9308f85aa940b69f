// publish/make_view.h: the view of an open store (docs/format.md, "view"), and the files that a
// viewer reads after it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// A file that a view names: the records of one level of an attribute, raw, one after another. That
/// of level base_level() has the base records.
struct ViewedFile {
  std::string name;
  AttributeId attribute = 0;
  int level = 0;
  std::uint64_t bytes = 0;
};

/// All files that the view of the store names: attributes and levels ascending. A store on `pread`
/// that one run has made has them under these names.
std::vector<ViewedFile> viewed_files(const Store& store);

/// Reads all levels of the attribute `position`. Errors: kInvalidArgument unless it is float32 x 3
/// or float64 x 3, and for base positions that are not finite; kNotFound; kCancelled; those of
/// reading blocks.
std::vector<std::byte> make_view(Store& store, const ProgressCallback& progress = {});

/// The bytes of the store's file view if it is that of the open version, and of make_view()
/// otherwise. A damaged file is told as an error: kCorruption.
std::vector<std::byte> view_of(Store& store, const ProgressCallback& progress = {});

/// The page that shows a store: one file of HTML.
std::string_view viewer_page();

PLAIT_END_NAMESPACE
