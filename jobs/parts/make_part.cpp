#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/default_arithmetic.h"
#include "base/stopwatch.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "io/machine.h"
#include "io/unpublished.h"
#include "parts/done_file.h"
#include "parts/part_directory.h"
#include "parts/part_work.h"
#include "parts/plan_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/parts.h"
#include "process_figures.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void write_synced(const Directory& directory, const std::string& name,
                  std::span<const std::byte> bytes) {
  File file(directory, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
}

/// Letters, digits and a few signs; the number of a user without a name.
std::string user_name() {
  const uid_t number = ::geteuid();
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  std::string name = std::to_string(number);
  if (::getpwuid_r(number, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr)
    name = entry.pw_name;
  for (char& c : name)
    if (!is_in_directory_names(c)) c = '_';
  return name;
}

/// The part if it is complete, whatever is wrong with it otherwise.
std::optional<DoneFile> find_done(const Directory& directory, const PlanFile& plan,
                                  std::uint32_t part) {
  try {
    return read_done_part(directory, plan, part);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotSupported &&
        error.code() != ErrorCode::kNotFound)
      throw;
    return std::nullopt;
  }
}

/// Removes what killed processes of this machine have left of a part.
void remove_left_overs(const Directory& directory, const PlanFile& plan, std::uint32_t part) {
  const std::string prefix = own_prefix(part);
  const std::size_t after_part = part_prefix(part).size();
  for (const std::string& name : directory.names()) {
    if (!name.starts_with(prefix)) continue;
    try {
      const Directory left(directory, name);
      const std::optional<Maker> maker = read_maker(std::string_view(name).substr(after_part));
      if (!maker || may_be_in_use(left, *maker)) continue;
      // A process that ended in the meantime has given done.I its name before it gave up the lock.
      const std::optional<DoneFile> done = find_done(directory, plan, part);
      if (!done || done->directory != name) PartDirectory::remove(directory, name);
    } catch (const Error&) {  // another process removes it
    }
  }
}

/// Gives a file another name, over one that has it. A file system of a network may lose the answer
/// and be asked again: then the file has its name although the last answer is that it is missing.
void rename_over(const Directory& from, const std::string& name, const Directory& to,
                 const std::function<bool()>& is_renamed) try {
  from.rename(name, to, name, Renaming::kReplace);
} catch (const Error& error) {
  if (error.code() != ErrorCode::kNotFound || !is_renamed()) throw;
}

/// Gives done.I its name. If another process was faster, its part stays, unless it is damaged or
/// `again` asks for a new one.
bool publish(const PartDirectory& made, const Directory& plan_directory, const PlanFile& plan,
             const DoneFile& done, bool again) {
  const std::string name = done_file_name(done.part);
  write_synced(made.made(), name, encode_done_file(plan, done));
  made.made().sync();
  plan_directory.sync();
  const auto is_named = [&] {
    const std::optional<DoneFile> found = find_done(plan_directory, plan, done.part);
    return found && found->directory == made.name();
  };
  if (!again) {
    try {
      if (made.made().rename(name, plan_directory, name, Renaming::kRefuse)) return true;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNotFound) throw;
    }
    if (is_named()) return true;
    if (find_done(plan_directory, plan, done.part)) return false;
  }
  rename_over(made.made(), name, plan_directory, is_named);
  return true;
}

}  // namespace

PartResult make_part(const std::filesystem::path& plan, std::uint32_t part,
                     const PartOptions& options, const BackendRegistry& backends) try {
  const Stopwatch clock;
  const double cpu_before = cpu_seconds();
  const auto begun = static_cast<std::uint64_t>(std::time(nullptr));
  const DefaultArithmetic arithmetic;
  const Directory plan_directory = open_plan_directory(plan);
  const PlanFile file = read_plan_file(plan_directory);
  if (part >= file.plan.parts.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("make part {} of {}: expected 0 to {}", part, plan.native(),
                            file.plan.parts.size() - 1));
  if (file.plan.program != program_version())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("make part {} of {}: plait {} made the plan, and this is plait {}: all "
                            "parts need the same",
                            part, plan.native(), file.plan.program, program_version()));
  if (!options.store.empty() && !file.plan.pass)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("make part {} of {}: only a part of a pass reads a store", part,
                            plan.native()));
  const auto result_of = [&](const DoneFile& done, bool was_done) {
    PartResult result{was_done, done.digest.to_string(), 0, done.seconds};
    for (const auto& levels : done.files) result.bytes += levels.bytes;
    return result;
  };
  if (!options.again)
    if (const std::optional<DoneFile> done = find_done(plan_directory, file, part)) {
      remove_left_overs(plan_directory, file, part);
      return result_of(*done, true);
    }
  const std::optional<DoneFile> before = find_done(plan_directory, file, part);
  remove_left_overs(plan_directory, file, part);

  PartDirectory made(plan_directory, part);
  DoneFile done;
  done.part = part;
  done.directory = made.name();
  ComputedPart computed =
      PartWork::of(plan_directory, file)->compute(part, made.made(), options, backends);
  PartContent& content = computed.content;
  done.digest = computed.digest;
  write_synced(made.made(), tables_file_name(file.version(), part), content.tables);
  write_synced(made.made(), kRecordsName, content.base_records);
  done.description = std::move(computed.description);
  done.files = std::move(content.files);
  done.tables_checksum = checksum_of(content.tables);
  done.records_checksum = checksum_of(content.base_records);
  done.seconds = clock.seconds();
  done.host = own_machine().host;
  done.user = user_name();
  done.begun = begun;
  done.cpu_seconds = cpu_seconds() - cpu_before;
  done.peak_memory_bytes = peak_rss_bytes();
  if (publish(made, plan_directory, file, done, options.again)) {
    made.keep();
    plan_directory.sync();
    if (before && before->directory != made.name())
      PartDirectory::remove(plan_directory, before->directory);
  }
  return result_of(done, false);
} catch (const std::bad_alloc&) {
  throw out_of_memory(fmt::format("make part {} of {}", part, plan.native()));
}

PLAIT_END_NAMESPACE
