#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "io/machine.h"
#include "io/unpublished.h"
#include "parts/done_file.h"
#include "parts/plan_file.h"
#include "plait/error.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using State = PartStatus::State;

std::uint64_t seconds_of_change(const Directory& directory, const char* name) {
  struct stat status {};
  const bool is_there = ::fstatat(directory.descriptor(), name, &status, AT_SYMLINK_NOFOLLOW) == 0;
  return is_there && status.st_mtim.tv_sec > 0 ? static_cast<std::uint64_t>(status.st_mtim.tv_sec)
                                               : 0;
}

/// The number of the part in "part.I-...".
std::optional<std::uint32_t> part_of(std::string_view directory) {
  constexpr std::string_view kBegin = "part.";
  std::uint32_t part = 0;
  if (!directory.starts_with(kBegin)) return std::nullopt;
  const char* const end = directory.data() + directory.size();
  const auto [after, error] = std::from_chars(directory.data() + kBegin.size(), end, part);
  if (error != std::errc() || after == end || *after != '-') return std::nullopt;
  return part;
}

/// What a directory says that no done.I names.
PartStatus unfinished(const Directory& plan, const std::string& name, const Maker& maker) {
  PartStatus found;
  found.host = maker.host;
  const Directory inside(plan, name);
  // The files of the levels are made at the begin, so this is about when the part was begun.
  found.begun = found.changed = seconds_of_change(plan, name.c_str());
  for (const std::string& file : inside.names())
    found.changed = std::max(found.changed, seconds_of_change(inside, file.c_str()));
  found.state = may_be_in_use(inside, maker) ? State::kRunning : State::kLost;
  return found;
}

PartStatus of_done(const DoneFile& done) {
  return {State::kDone, done.host,    done.user,        done.begun,
          {},           done.seconds, done.cpu_seconds, done.peak_memory_bytes};
}

}  // namespace

PlanStatus status_of_plan(const std::filesystem::path& path) try {
  const Directory directory = open_plan_directory(path);
  const PlanFile plan = read_plan_file(directory);
  const std::vector<PlannedPart>& planned = plan.plan.parts;
  PlanStatus status;
  status.parts.resize(planned.size());
  double took = 0, expected = 0, expected_left = 0;
  for (std::uint32_t part = 0; part < planned.size(); ++part) {
    std::optional<DoneFile> done;
    try {
      done = read_done_file(directory, plan, part);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruption) throw;  // a damaged one is not done
    }
    if (!done) {
      expected_left += planned[part].seconds;
      continue;
    }
    status.parts[part] = of_done(*done);
    status.bytes_done += planned[part].bytes;
    took += done->seconds;
    expected += planned[part].seconds;
  }
  for (const std::string& name : directory.names()) {
    const std::optional<std::uint32_t> part = part_of(name);
    if (!part || *part >= planned.size() || status.parts[*part].state == State::kDone ||
        status.parts[*part].state == State::kRunning)
      continue;
    const std::optional<Maker> maker =
        read_maker(std::string_view(name).substr(part_prefix(*part).size()));
    if (!maker) continue;
    try {
      status.parts[*part] = unfinished(directory, name, *maker);
    } catch (const Error& error) {  // it has ended meanwhile
      if (error.code() != ErrorCode::kNotFound) throw;
    }
  }
  const auto count = [&](State state) {
    return static_cast<std::uint32_t>(std::ranges::count(status.parts, state, &PartStatus::state));
  };
  status.done = count(State::kDone);
  status.running = count(State::kRunning);
  status.lost = count(State::kLost);
  status.waiting = count(State::kWaiting);
  if (took > 0) status.bytes_per_second = static_cast<double>(status.bytes_done) / took;
  if (took > 0 && expected > 0)
    status.seconds_left = expected_left * took / expected / std::max(1u, status.running);
  return status;
} catch (const std::bad_alloc&) {
  throw out_of_memory("status " + path.native());
}

PLAIT_END_NAMESPACE
