#include "parts/part_directory.h"

#include <fmt/format.h>

#include <exception>

#include "format/file_names.h"
#include "io/machine.h"
#include "io/unpublished.h"
#include "parts/done_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string own_prefix(std::uint32_t part) {
  return fmt::format("{}{}-{}-", part_prefix(part), own_machine().host, own_machine().start);
}

PartDirectory::PartDirectory(const Directory& plan, std::uint32_t part) : plan_(plan) {
  made_ = make_locked_directory(
      [&] {
        name_ = part_prefix(part) + new_maker_name();
        return plan.path_of(name_);
      },
      true);
}

PartDirectory::~PartDirectory() {
  if (!is_kept_) remove(plan_, name_);
}

void PartDirectory::remove(const Directory& plan, const std::string& name) noexcept {
  try {
    const Directory made(plan, name);
    for (const std::string& file : made.names())
      if (is_version_file_name(file) || file == kRecordsName || file.starts_with("done."))
        made.remove_if_possible(file);
    plan.remove_directory(name);
  } catch (const std::exception&) {  // what stays does no harm
  }
}

PLAIT_END_NAMESPACE
