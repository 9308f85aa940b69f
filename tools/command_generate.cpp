// plait generate: makes a base mesh from a seed.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string generate_text(const nlohmann::ordered_json& report) {
  return fmt::format("{}: {}, {} vertices, {} faces, seed {}, {:.2f} s\n",
                     report["file"].get<std::string>(), report["kind"].get<std::string>(),
                     format_count(report["vertices"].get<std::uint64_t>()),
                     format_count(report["faces"].get<std::uint64_t>()),
                     report["seed"].get<std::uint64_t>(), report["seconds"].get<double>());
}

}  // namespace

void add_generate_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {.job = "generate",
       .footer =
           "molecule, torus and icosphere are closed, open-sheet has a border. The same kind, "
           "count\n"
           "and seed give the same file.\n"
           "\n"
           "Examples:\n"
           "  plait generate molecule molecule.ply --vertices 26016 --seed 1\n"
           "  plait generate open-sheet sheet.ply --vertices 5000 --force",
       .text = generate_text});
}

}  // namespace plait
