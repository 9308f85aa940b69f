#include "mpi/job.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <exception>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "base/stopwatch.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "plait/error.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "progress.h"
#include "report_text.h"

namespace plait::mpi {
namespace {

/// Makes a part, and reports an error of it in the name of the rank.
class PartMaker {
 public:
  PartMaker(const JobOptions& arguments, const BackendRegistry& backends, int rank)
      : arguments_(arguments), backends_(backends), rank_(rank) {}

  PartOutcome operator()(std::uint32_t part) const {
    PartOptions options = arguments_.part;
    options.progress = [](const Progress&) { return !interrupted(); };
    try {
      if (read_parts_plan(arguments_.plan).pass) options.store = arguments_.store;
      if (!has_warned_) options.warn = [this](const std::string& what) { warn(what); };
      const PartResult result = make_part(arguments_.plan, part, options, backends_);
      return result.was_done ? PartOutcome::kWasDone : PartOutcome::kMade;
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kCancelled) return PartOutcome::kCancelled;
      return fail(part, to_string(error.code()), error.what());
    } catch (const std::exception& error) {
      return fail(part, "internal", error.what());
    }
  }

 private:
  void warn(const std::string& what) const {
    has_warned_ = true;
    report_warning(fmt::format("rank {}: {}", rank_, what));
  }
  PartOutcome fail(std::uint32_t part, std::string_view code, std::string_view what) const {
    report_error(code, fmt::format("rank {} on {}: part {}: {}", rank_, host_name(), part, what),
                 false);
    return PartOutcome::kFailed;
  }

  const JobOptions& arguments_;
  const BackendRegistry& backends_;
  int rank_;
  mutable bool has_warned_ = false;  ///< one part says it for all
};

/// What rank 0 does between messages.
class Watch {
 public:
  Watch(PartQueue& queue, std::uint32_t parts) : queue_(queue), parts_(parts) {}
  void operator()() {
    if (!bar_.update(queue_.ended(), parts_)) queue_.stop();
  }
  void clear() { bar_.clear(); }

 private:
  PartQueue& queue_;
  std::uint32_t parts_;
  ProgressBar bar_{"parts", ProgressUnit::kNone};
};

int report_parts(const JobOptions& arguments, const PartQueue& queue, std::uint32_t parts,
                 int ranks, double seconds) {
  const std::uint32_t made = queue.count(PartOutcome::kMade);
  const std::uint32_t were_done = queue.count(PartOutcome::kWasDone);
  if (!arguments.json) {
    print(fmt::format("{}: {} of {} parts by {} ranks, {} were done before, {:.2f} s\n",
                      arguments.plan.native(), made, parts, ranks, were_done, seconds));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {
      {"plan", arguments.plan.string()}, {"parts", parts},    {"ranks", ranks}, {"made", made},
      {"were_done", were_done},          {"seconds", seconds}};
  print(json_text(report));
  return kExitDone;
}

int join(const JobOptions& arguments, const BackendRegistry& backends) {
  const Stopwatch clock;
  JoinOptions options;
  options.progress = [](const Progress&) { return !interrupted(); };
  options.warn = report_warning;
  const JoinResult joined = join_parts(arguments.plan, arguments.store, options, backends);
  return report_join(joined, arguments.plan, arguments.store, clock.seconds(), arguments.json);
}

/// Refuses before the parts what the join would refuse after them.
PartsPlan begin(const JobOptions& options, const BackendRegistry& backends) {
  PartsPlan plan = read_parts_plan(options.plan);
  if (options.store.empty()) return plan;
  const bool is_there = std::filesystem::exists(options.store);
  const auto is_its_own = [&] {
    return Store::open(options.store, {}, backends).info().uuid == plan.uuid;
  };
  if (plan.pass && !is_its_own())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("pass {}: {} is another store than that of the plan",
                            options.plan.native(), options.store.native()));
  if (!plan.pass && is_there && !is_its_own())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create {}: it exists already", options.store.native()));
  return plan;
}

}  // namespace

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "a machine";
}

void Job::run(const Ranks& ranks, const std::function<void()>& prepare) {
  ranks_ = ranks.count();
  const PartMaker make(options_, backends_, ranks.rank());
  const Stopwatch clock;
  try {
    prepare();
    if (ranks.rank() == 0) plan_ = begin(options_, backends_);
  } catch (...) {
    error_ = std::current_exception();
  }
  if (ranks.rank() == 0) {
    const auto parts = static_cast<std::uint32_t>(plan_.parts.size());
    queue_.emplace(parts);
    Watch watch(*queue_, parts);
    ranks.hand_out(*queue_, make, std::ref(watch));
  } else {
    ranks.work(make, error_ == nullptr);
  }
  seconds_ = clock.seconds();
}

int Job::end() const {
  if (error_) std::rethrow_exception(error_);
  throw_if_interrupted();
  if (!queue_) return kExitDone;
  JoinResult result;
  result.missing = queue_->not_done();
  if (!result.missing.empty()) return report_incomplete(options_.plan, result, options_.json);
  const auto parts = static_cast<std::uint32_t>(plan_.parts.size());
  if (options_.store.empty() || !options_.json)
    report_parts(options_, *queue_, parts, ranks_, seconds_);
  return options_.store.empty() ? kExitDone : join(options_, backends_);
}

}  // namespace plait::mpi
