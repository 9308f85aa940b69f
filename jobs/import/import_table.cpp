// The job "import".
#include <fmt/format.h>

#include "job.h"
#include "job_rules.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/import_mesh.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct ImportArguments : ImportRequest {
  std::vector<std::string> compress;
};

JobReport run_import(ImportArguments& arguments, const JobCall& call) {
  arguments.pipeline_of = pipelines_of(compression_of(arguments.compress));
  arguments.parallel_for = call.parallel_for;
  const ImportResult result = import_mesh(arguments, call.backends, call.watch);
  warn_of_unknown_attributes(arguments.compress, {"position"}, result.attributes, call.watch);
  return {{"mesh", arguments.mesh.string()},
          {"store", arguments.store.string()},
          {"vertices", result.vertices},
          {"faces", result.faces},
          {"merged_vertices", result.merged_vertices},
          {"seam_vertices", result.seam_vertices},
          {"levels", result.levels},
          {"base_level", result.base_level},
          {"base_vertices", result.base_vertices},
          {"base_faces", result.base_faces},
          {"border_edges", result.border_edges},
          {"had_choice", result.had_choice},
          {"next_level", result.next_level},
          {"attributes", attributes_json(result.attributes)},
          {"backend", result.backend},
          {"backend_reason", result.backend_reason},
          {"stored_bytes", result.stored_bytes},
          {"memory_bytes", result.memory_bytes},
          {"read_seconds", result.read_seconds},
          {"recover_seconds", result.recover_seconds},
          {"write_seconds", result.write_seconds}};
}

}  // namespace

Job import_job() {
  JobTable<ImportArguments> table("import",
                                  "Make a store of a mesh that has subdivision levels already");
  table.path("input", &ImportArguments::mesh, "PLY, OBJ, OFF or STL, also .gz and .zst")
      .at(0)
      .required();
  table.output("output", &ImportArguments::store, "The store to make, a directory")
      .at(1)
      .required();
  table
      .count("levels", &ImportArguments::levels, 1, kMaxLevel,
             fmt::format("The number of levels, 1 to {}, or all that there are", kMaxLevel))
      .or_word("all");
  table.precision(
      &ImportArguments::precision,
      "Type of the positions; auto: as in a PLY file; for other files float32, unless it moves "
      "a vertex by more than a thousandth of the shortest edge there");
  table.weld(&ImportArguments::weld);
  table.text("backend", &ImportArguments::backend,
             "The backend that stores the levels (see below)");
  table.compress(&ImportArguments::compress);
  table
      .named(
          "layout",
          [](ImportArguments& arguments, const std::string& name) {
            arguments.layout = layout_from_name(name);
          },
          "Order of edges on disk: auto, given, spatial, hilbert or rcm")
      .by_default("auto");
  table.bytes("block", &ImportArguments::block_bytes, std::string(kBlockHelp));
  table.bytes("max-slot", &ImportArguments::max_slot_bytes,
              fmt::format("Largest slot of positions: take a finer base mesh until all slots fit; "
                          "default {}",
                          size_text(kLargestSlotBytes)));
  table.flag("no-index", &ImportArguments::no_index, std::string(kNoIndexHelp));
  table.bytes("memory", &ImportArguments::budget_bytes, "Budget for blocks in memory");
  table.threads(&ImportArguments::threads, "Threads that write");
  table
      .choice(
          "durability", {"commit", "none"},
          [](ImportArguments& arguments, const std::string& name) {
            arguments.durability = name == "commit" ? Durability::kCommit : Durability::kNone;
          },
          "commit: wait until the store is on the disk; none: do not wait (temporary stores)")
      .by_default("commit");
  table.force(&ImportArguments::existing);
  table
      .flag("ignore-size", &ImportArguments::ignore_size,
            "Start even if the memory is too small for the mesh")
      .remedy("starts anyway");
  return table.run(run_import);
}

PLAIT_END_NAMESPACE
