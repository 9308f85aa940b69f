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

PLAIT_END_NAMESPACE
