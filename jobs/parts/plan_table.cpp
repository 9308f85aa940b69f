// The job "plan".
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <system_error>

#include "base/text.h"
#include "io/unpublished.h"
#include "job_rules.h"
#include "layout/base_directory.h"
#include "parts/part_tables.h"
#include "parts/parts_script.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct PlanArguments : PartsRequest {
  bool of = false;
  std::optional<int> level;
  std::optional<std::uint32_t> part_count;
  std::vector<std::string> compress;
  std::optional<std::string> pass_name;
  PassRequest of_pass;
  std::optional<std::uint64_t> memory;
  std::filesystem::path sbatch, chain;
  std::uint32_t longest_array = 1000;
};

bool is_given(const JobOptions& options, std::string_view name) {
  return std::ranges::any_of(options, [&](const auto& option) { return option.first == name; });
}

/// Options of a subdivision have no meaning for a pass, and the other way round.
void check_kind(const PlanArguments& arguments, const JobOptions& options) {
  const auto refuse_any = [&](std::initializer_list<const char*> names, const char* reason) {
    for (const char* const name : names)
      if (is_given(options, name))
        throw JobError(ErrorCode::kInvalidArgument, fmt::format("plan: {}", reason), name);
  };
  const auto refuse_options_of_subdivision = [&](const char* reason) {
    refuse_any({"levels", "parts", "scheme", "precision", "weld", "normals", "limit", "layout",
                "compress", "block", "max-slot", "calibrate"},
               reason);
  };
  const auto refuse_options_of_pass = [&](const char* reason) {
    refuse_any({"factor", "amplitude", "seed", "diagonal", "result", "parameters", "threads"},
               reason);
  };
  if (arguments.of) {
    refuse_options_of_subdivision("a plan that is made again has the options of its store");
    refuse_options_of_pass("a plan that is made again has the options of its store");
    refuse_any({"memory"}, "a plan that is made again reads the whole base mesh");
    return refuse_any({"pass"}, "a plan that is made again is that of a subdivision");
  }
  if (arguments.pass_name)
    return refuse_options_of_subdivision("a pass has the levels, shards and blocks of its store");
  for (const char* const name : {"levels", "parts"})
    if (!is_given(options, name))
      throw JobError(ErrorCode::kInvalidArgument,
                     fmt::format("plan: expected the option {}, found none", name), name);
  refuse_options_of_pass("this is an option of a pass");
  if (!is_base_directory(arguments.mesh))
    refuse_any({"memory"},
               "a mesh of this format is read as a whole: plait layout makes one of which plan "
               "reads ranges");
}

/// "folded,float32,1".
AttributeSchema schema_in(const std::string& text) {
  const std::size_t first = text.find(','), second = text.find(',', first + 1);
  if (first == std::string::npos || second == std::string::npos)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("expected NAME,TYPE,COMPONENTS, found \"{}\"", text));
  const std::string type = text.substr(first + 1, second - first - 1);
  for (int number = 1; number <= static_cast<int>(ComponentType::kUint64); ++number)
    if (const auto known = static_cast<ComponentType>(number); to_string(known) == type)
      return {text.substr(0, first), known,
              static_cast<std::uint32_t>(parse_whole_number(text.substr(second + 1), 1, 255))};
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("expected a type such as float32 or uint8, found \"{}\"", type));
}

/// What is left for a base mesh that is read by ranges.
std::uint64_t bytes_for_ranges(std::uint64_t memory) {
  constexpr std::uint64_t kProgram = std::uint64_t{64} << 20, kLeast = std::uint64_t{96} << 20;
  if (memory < kLeast)
    throw JobError(ErrorCode::kBudget,
                   fmt::format("plan: expected at least {} of memory, found {}",
                               format_bytes(kLeast), format_bytes(memory)),
                   "memory");
  return memory - kProgram;
}

/// What was made goes if what follows from it cannot be made.
template <class Step>
void remove_unless(const std::filesystem::path& made, const Step& succeeds) try {
  succeeds();
} catch (const Error&) {
  std::error_code ignored;
  std::filesystem::remove_all(made, ignored);
  throw;
}

void write_scripts(const PlanArguments& arguments, const PartsPlan& plan) {
  write_sbatch_script(arguments.sbatch, arguments.plan, plan, arguments.longest_array);
  if (!arguments.chain.empty())
    remove_unless(arguments.sbatch, [&] {
      write_chain_script(arguments.chain, arguments.sbatch, arguments.plan, plan,
                         arguments.longest_array);
    });
}

PartsPlan make_plan(PlanArguments& arguments, const JobCall& call) {
  if (!arguments.chain.empty() && arguments.sbatch.empty())
    throw JobError(ErrorCode::kInvalidArgument,
                   "plan: a chain submits the script of --sbatch, and there is none", "chain");
  for (const auto& script : {arguments.sbatch, arguments.chain})
    if (!script.empty()) UnpublishedFile::check(script, Existing::kRefuse);
  PartsPlan plan;
  if (arguments.pass_name) {
    PassRequest& request = arguments.of_pass;
    request.store = arguments.mesh;
    request.plan = arguments.plan;
    request.pass.name = *arguments.pass_name;
    request.progress = call.watch.progress;
    request.before_files = call.watch.before_files;
    if (arguments.memory) request.budget_bytes = *arguments.memory;
    plan = plan_pass(request, call.backends);
  } else if (arguments.of) {
    plan = plan_again(arguments.mesh, arguments.plan, call.backends, call.watch.before_files);
  } else {
    arguments.levels = *arguments.level;
    arguments.parts = *arguments.part_count;
    if (arguments.memory) arguments.memory_bytes = bytes_for_ranges(*arguments.memory);
    const Compression compression = compression_of(arguments.compress);
    check_attributes_of_scheme(compression, arguments.normals);
    arguments.pipeline_of = pipelines_of(compression);
    arguments.progress = call.watch.progress;
    arguments.before_files = call.watch.before_files;
    plan = plan_parts(arguments, call.backends);
  }
  if (call.watch.warn)
    for (const std::string& warning : plan.warnings) call.watch.warn(warning);
  if (!arguments.sbatch.empty())
    remove_unless(arguments.plan, [&] { write_scripts(arguments, plan); });
  return plan;
}

JobReport parts_json(const std::vector<PlannedPart>& parts) {
  JobReport json = JobReport::array();
  for (const PlannedPart& part : parts)
    json.push_back({{"first_edge", part.first_edge},
                    {"edge_after", part.edge_after},
                    {"records", part.records},
                    {"faces", part.faces},
                    {"ghost_faces", part.ghosts},
                    {"bytes", part.bytes},
                    {"seconds", part.seconds}});
  return json;
}

JobReport plan_report(const std::filesystem::path& path, const PartsPlan& plan) {
  std::uint64_t bytes = 0, ghosts = 0;
  double seconds = 0;
  for (const PlannedPart& part : plan.parts) {
    bytes += part.bytes;
    ghosts += part.ghosts;
    seconds += part.seconds;
  }
  const auto worst = std::ranges::max_element(plan.parts, {}, &PlannedPart::seconds);
  JobReport report = {{"plan", path.string()},
                      {"levels", plan.levels},
                      {"base_level", plan.base_level},
                      {"vertices", plan.vertices},
                      {"backend", plan.backend},
                      {"files", plan.files},
                      {"bytes", bytes},
                      {"ghost_faces", ghosts},
                      {"seconds_of_parts", seconds},
                      {"worst",
                       {{"part", worst - plan.parts.begin()},
                        {"bytes", worst->bytes},
                        {"seconds", worst->seconds}}}};
  if (plan.pass) {
    report["pass"] = plan.pass->pass.name;
    report["store"] = plan.pass->store.string();
    report["version"] = plan.pass->version;
    report["attribute"] = plan.pass->result.name;
    if (plan.pass->pass.diagonal) report["diagonal"] = *plan.pass->pass.diagonal;
  }
  if (plan.memory)
    report["memory"] = {{"budget_bytes", plan.memory->budget_bytes},
                        {"total_bytes", plan.memory->total_bytes}};
  if (plan.rates)
    report["rates"] = {{"points_per_second", plan.rates->points_per_second},
                       {"bytes_per_second", plan.rates->bytes_per_second},
                       {"begin_seconds", plan.rates->begin_seconds}};
  report["parts"] = parts_json(plan.parts);
  return report;
}

void add_subdivision_options(JobTable<PlanArguments>& table) {
  table.count("levels", &PlanArguments::level, 1, kMaxLevel,
              fmt::format("The level to reach, 1 to {}", kMaxLevel));
  table.count("parts", &PlanArguments::part_count, 1, 1 << 20, "The number of parts");
  table.named(
      "scheme",
      [](PlanArguments& arguments, const std::string& name) {
        arguments.scheme = scheme_from_name(name);
      },
      fmt::format("The scheme; default {}", to_string(Scheme())));
  table.precision(&PlanArguments::precision,
                  "Type of the positions; auto: float32, or float64 where that would move them");
  table.weld(&PlanArguments::weld);
  table.flag("normals", &PlanArguments::normals, "Also compute unit normals");
  table.flag("limit", &PlanArguments::limit,
             "Project positions to the limit surface, if the scheme has one");
  table.named(
      "layout",
      [](PlanArguments& arguments, const std::string& name) {
        arguments.layout = layout_from_name(name);
      },
      "Order of edges: given, spatial, hilbert or rcm; default hilbert");
  table.compress(&PlanArguments::compress);
  table.bytes("block", &PlanArguments::block_bytes, std::string(kBlockHelp));
  table.bytes("max-slot", &PlanArguments::max_slot_bytes,
              fmt::format("Largest slot of positions: refine the base mesh in memory until all "
                          "slots fit; default {}",
                          size_text(kLargestSlotBytes)));
  table.flag("calibrate", &PlanArguments::calibrate,
             "Measure this machine for about two seconds: seconds are then its own");
}

Pass& pass_of(PlanArguments& arguments) { return arguments.of_pass.pass; }

void add_pass_options(JobTable<PlanArguments>& table) {
  table.text("pass", &PlanArguments::pass_name,
             "Plan a pass over all vertices of a store: smooth, noise or normals, or one of a "
             "program's own");
  table.number(
      "factor", [](PlanArguments & arguments) -> auto& { return pass_of(arguments).factor; }, 0, 1,
      "smooth: how far each vertex goes to the mean of its neighbours, 0 to 1");
  table
      .number(
          "amplitude",
          [](PlanArguments & arguments) -> auto& { return pass_of(arguments).amplitude; }, 0, 1,
          "noise: how far, in diagonals of the bounding box, 0 to 1")
      .by_default("3e-7");
  table.count(
      "seed", [](PlanArguments & arguments) -> auto& { return pass_of(arguments).seed; }, 0,
      std::numeric_limits<std::uint64_t>::max(), "noise: each seed gives another surface");
  table.number(
      "diagonal", [](PlanArguments & arguments) -> auto& { return pass_of(arguments).diagonal; }, 0,
      std::numeric_limits<double>::max(),
      "noise: that of the bounding box; default: plan reads all positions once");
  table.named(
      "result",
      [](PlanArguments& arguments, const std::string& text) {
        pass_of(arguments).result = schema_in(text);
      },
      "A pass of a program's own: the attribute that it makes, as NAME,TYPE,COMPONENTS");
  table.text(
      "parameters",
      [](PlanArguments & arguments) -> auto& { return pass_of(arguments).parameters; },
      "A pass of a program's own: a text for it, which the plan keeps");
  table.bytes(
      "memory", &PlanArguments::memory,
      fmt::format("Of a mesh that plait layout made: larger ones are read by ranges, in so "
                  "much memory, default {}; noise: budget for blocks in memory while the "
                  "positions are read, default {}",
                  size_text(PartsRequest().memory_bytes), size_text(StoreOptions().budget_bytes)));
  table.threads(
      [](PlanArguments & arguments) -> auto& { return arguments.of_pass.threads; },
      "noise: threads that read the positions");
}

}  // namespace

Job plan_job() {
  JobTable<PlanArguments> table("plan", "Cut a subdivision or a pass into parts for many machines");
  table
      .path("input", &PlanArguments::mesh,
            "PLY, OBJ or OFF, also .gz and .zst; or what plait layout made; for --pass and --of a "
            "store in shards")
      .at(0)
      .required();
  table.output("plan", &PlanArguments::plan, "The plan to make, a directory").at(1).required();
  add_subdivision_options(table);
  add_pass_options(table);
  table.flag("of", &PlanArguments::of,
             "Make the plan of a store again, so that a damaged shard costs one part");
  table.path("sbatch", &PlanArguments::sbatch,
             "Also write a Slurm script that makes all parts in an array job");
  table.path("chain", &PlanArguments::chain,
             "Also write a script that submits the array, the join after it, and what comes next");
  table.count("array", &PlanArguments::longest_array, 1, 1 << 20,
              "The longest array that --sbatch may ask for");
  return table.run([](PlanArguments& arguments, const JobCall& call) -> JobReport {
    check_kind(arguments, call.options);
    return plan_report(arguments.plan, make_plan(arguments, call));
  });
}

PLAIT_END_NAMESPACE
