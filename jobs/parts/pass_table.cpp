// The job "pass": one pass in one process, over the store itself or over a copy.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "conversion/conversion_job.h"
#include "conversion/read_back.h"
#include "job.h"
#include "job_rules.h"
#include "plait/extend/notices.h"
#include "plait/extend/pass.h"
#include "plait/progress.h"
#include "plait/store_info.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kFractalAmplitude = 0.005;
/// Fewer ways that the type of the positions rounds than one in ten vertices are in the report
/// only: small ways are among those of any noise.
constexpr std::uint64_t kLeastRounded = 10;

struct PassArguments : ConversionRequest {
  Pass pass;
  std::optional<double> amplitude;
  std::vector<std::string> compress;
};

/// An option that has no meaning for this call is refused.
void check_meaning(const PassArguments& arguments, const JobOptions& options) {
  const auto refuse_any = [&](std::initializer_list<const char*> names, const std::string& reason) {
    for (const char* const name : names)
      if (std::ranges::any_of(options, [&](const auto& option) { return option.first == name; }))
        throw JobError(ErrorCode::kInvalidArgument, "pass: " + reason, name);
  };
  if (arguments.to.empty()) {
    if (arguments.existing == Existing::kReplace)
      throw Error(ErrorCode::kInvalidArgument,
                  "pass: expected the name of a store that force may replace, found none");
    refuse_any({"backend", "compress", "block"},
               "this is an option of the copy, and without OUT there is none");
  }
  const std::string& kind = arguments.pass.name;
  if (kind != "smooth") refuse_any({"factor"}, "this is an option of smooth");
  if (kind != "noise" && kind != "fractal")
    refuse_any({"amplitude", "seed"}, "this is an option of noise and fractal");
}

struct MadePass {
  PassFigures figures;
  std::vector<std::string> made;
};

MadePass make_pass(Store& store, const PassArguments& arguments, const JobWatch& watch) {
  MadePass result;
  Pass pass = arguments.pass;
  const bool moves = pass.name != "normals";
  if (moves) result.made.emplace_back("position");
  pass.remakes_normals = moves && store.has_attribute("normal");
  if (!moves || pass.remakes_normals) result.made.emplace_back("normal");
  VisitOptions visit;
  visit.threads = arguments.threads;
  int least = thread_count(arguments.threads, "pass");
  visit.begins = [&](int threads) { least = std::min(least, threads); };
  if (watch.step) watch.step("pass");
  visit.progress = watch.progress;
  result.figures = run_pass(store, pass, visit);
  warn_of_fewer_threads(fmt::format("pass '{}'", pass.name), least, arguments.threads,
                        store.options().budget_bytes, watch.warn);
  const std::uint64_t vertices =
      counts_at_level(store.base(), store.finest_level() - store.base_level()).vertices;
  if (const std::uint64_t rounded = result.figures.rounded_moves;
      rounded > vertices / kLeastRounded && watch.warn)
    watch.warn(fmt::format(
        "pass '{}': {} of {} vertices go another way than asked, by more than half of it, because "
        "{} has no nearer numbers there: a larger amplitude, or a store made with --precision "
        "float64, keeps the ways",
        pass.name, rounded, vertices,
        to_string(store.attributes()[store.attribute("position")].schema.type)));
  return result;
}

JobReport run(PassArguments& arguments, const JobCall& call) {
  check_meaning(arguments, call.options);
  arguments.parallel_for = call.parallel_for;
  Pass& pass = arguments.pass;
  pass.amplitude =
      arguments.amplitude.value_or(pass.name == "fractal" ? kFractalAmplitude : pass.amplitude);
  JobReport report = {{"from", arguments.from.string()}, {"kind", pass.name}};
  if (pass.name == "smooth") report["factor"] = pass.factor;
  if (pass.name == "noise" || pass.name == "fractal") {
    report["amplitude"] = pass.amplitude;
    report["seed"] = pass.seed;
  }
  MadePass result;
  JobReport of_store;
  if (arguments.to.empty()) {
    OpenOptions open;
    open.writable = true;
    open.budget_bytes = arguments.budget_bytes;
    open.parallel_for = arguments.parallel_for;
    if (call.watch.before_files) call.watch.before_files();
    Store store = Store::open(arguments.from, open, call.backends);
    tell_notices(store, call.watch.warn);
    result = make_pass(store, arguments, call.watch);
    store.finish_encoding(begin_step(call.watch, "encode"));
    store.commit();
    of_store = {{"store", store.path().string()},
                {"version", store.sequence()},
                {"backend", store.options().backend},
                {"stored_bytes", store.info().stored_bytes}};
  } else {
    arguments.verb = "pass";
    arguments.compression = compression_of(arguments.compress);
    arguments.attributes_of_change = {"normal"};
    arguments.change = [&](Store& copy) { result = make_pass(copy, arguments, call.watch); };
    const ConversionResult copy = convert(arguments, call.open_backends, call.backends, call.watch);
    of_store = {{"store", copy.store.string()},
                {"version", 1},
                {"backend", copy.options.backend},
                {"stored_bytes", copy.stored_bytes}};
  }
  const PassFigures& figures = result.figures;
  if (pass.name == "noise" || pass.name == "fractal") report["diagonal"] = figures.diagonal;
  if (pass.name != "normals") report["largest_move"] = figures.largest_move;
  if (pass.name == "noise" || pass.name == "fractal") report["rounded"] = figures.rounded_moves;
  if (pass.name == "fractal") {
    report["mean_edge"] = figures.mean_edge;
    report["wavelengths"] = figures.wavelengths;
  }
  report["made"] = result.made;
  report.update(of_store);
  return report;
}

}  // namespace

Job pass_job() {
  JobTable<PassArguments> table("pass",
                                "Smooth or move the vertices of a store, or make normals anew");
  table.path("store", &PassArguments::from, "The store").at(0).required();
  table
      .choice(
          "kind", {"smooth", "noise", "fractal", "normals"},
          [](PassArguments& arguments, const std::string& name) { arguments.pass.name = name; },
          "What the pass does (see below)")
      .at(1)
      .required();
  table
      .output("out", &PassArguments::to,
              "The store to make; without it the pass is the next version of STORE")
      .at(2);
  table.number(
      "factor", [](PassArguments & arguments) -> auto& { return arguments.pass.factor; }, 0, 1,
      "smooth: how much of the way to the mean of the neighbours, 0 to 1");
  table.number("amplitude", &PassArguments::amplitude, 0, 1,
               fmt::format("How far, in diagonals of the bounding box, 0 to 1; default: noise "
                           "{:g}, fractal {:g}",
                           Pass().amplitude, kFractalAmplitude));
  table.count(
      "seed", [](PassArguments & arguments) -> auto& { return arguments.pass.seed; }, 0,
      std::numeric_limits<std::uint64_t>::max(), "noise, fractal: each seed gives another surface");
  table.text("backend", &PassArguments::backend,
             "The backend of OUT (see below); auto: chosen by its size; default: as in STORE");
  table.compress(&PassArguments::compress);
  table.bytes("block", &PassArguments::block_bytes, fmt::format("With OUT: {}", kBlockOfCopyHelp));
  table.bytes(
      "memory", &PassArguments::budget_bytes,
      "Budget for blocks in memory; with OUT, half of it for STORE, or less where it needs less");
  table.threads(&PassArguments::threads, "Threads that compute");
  table.force(&PassArguments::existing,
              "Replace OUT if it is a store, when the new store is complete");
  return table.run(run);
}

PLAIT_END_NAMESPACE
