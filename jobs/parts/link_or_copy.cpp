#include "parts/link_or_copy.h"

#include "io/copy_range.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void link_or_copy(const Directory& from, const std::string& name, const Directory& to) {
  try {
    return link_file(from, name, to);
  } catch (const Error& error) {
    // Another file system, or one without links: the copy says what else may be wrong.
    if (to.contains(name)) throw;
  }
  const File source(from, name, OpenMode::kRead);
  File copy(to, name, OpenMode::kCreate);
  copy.resize(source.size());
  copy_range(source, copy, 0, source.size());
  copy.sync();
  copy.close();
}

void give_name(const Directory& from, const std::string& name, const Directory& to) {
  const auto has_it = [&] {
    return to.contains(name) && to.contains(name, File(from, name, OpenMode::kRead).descriptor());
  };
  if (has_it()) return;
  to.remove(name);
  try {
    link_or_copy(from, name, to);
  } catch (const Error&) {
    if (!has_it()) throw;
  }
}

PLAIT_END_NAMESPACE
