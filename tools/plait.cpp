// The program plait: parses the command line, runs one command, maps errors to exit statuses.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "nearest_name.h"
#include "plait/error.h"
#include "plait/extend/plugins.h"
#include "plait/version.h"
#include "stand_ins.h"

namespace plait {
namespace {

constexpr const char* kFooter =
    "Examples:\n"
    "  plait generate molecule molecule.ply --vertices 26016 --seed 1\n"
    "  plait subdivide molecule.ply molecule.plait --levels 5 --normals\n"
    "  plait verify molecule.plait\n"
    "  plait render molecule.plait molecule.png\n"
    "\n"
    "Commands that open or make a store load plug-ins: --plugin FILE, and the files that\n"
    "PLAIT_PLUGINS names, with colons between them.\n"
    "Sizes take KiB, MiB, GiB, TiB, or K, M, G, T: all powers of 1024.\n"
    "Exit status: 0 done; 1 failed (I/O, corruption, budget, busy); 2 bad usage or refused input,\n"
    "such as a missing file; 3 try again (part, join: I/O, no space, busy); 4 parts are missing\n"
    "(join); 128 + N cancelled by signal N (Ctrl-C: 130).\n"
    "A command never leaves a half-made output: an output gets its name when it is complete.";

/// Searches the arguments itself, because parsing may fail before it reaches the flag.
bool asks_for_json(int argument_count, char** arguments) {
  for (int at = 1; at < argument_count; ++at)
    if (std::strcmp(arguments[at], "--json") == 0) return true;
  return false;
}

int fail(const Error& error, bool json) {
  report_error(to_string(error.code()), error.what(), json);
  return exit_status(error.code());
}

int refuse_usage(const CommandLine& program, const UsageError& error, bool json) {
  std::string name = "plait";
  for (const CommandLine* command : program.parsed_subcommands()) name += " " + command->name();
  report_error("usage", fmt::format("{} (see {} --help)", error.what(), name), json);
  return kExitRefused;
}

/// For an unknown command, the parser's own message would only say that an argument is left over.
void require_known_command(const CommandLine& program, int argument_count, char** arguments) {
  if (argument_count > 1 && arguments[1][0] == '-') return;
  const std::vector<std::string> names = program.subcommand_names();
  const std::string expected = fmt::format("expected one of {}", fmt::join(names, ", "));
  if (argument_count <= 1) throw UsageError(fmt::format("no command was given: {}", expected));
  const std::string_view name = arguments[1];
  if (std::ranges::find(names, name) != names.end()) return;
  const std::string nearest = nearest_name(name, names);
  throw UsageError(fmt::format("there is no command \"{}\"{}: {}", name,
                               nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest),
                               expected));
}

/// Commands that neither open nor make a store work without plug-ins, even if one cannot be loaded.
bool uses_plugins(const CommandLine& program) {
  return std::ranges::any_of(program.parsed_subcommands(), [](const CommandLine* command) {
    return command->has_option("--plugin");
  });
}

void load_plugins(Plugins& plugins, const std::vector<std::string>& files) {
  if (const char* const list = ::secure_getenv("PLAIT_PLUGINS")) plugins.load_list(list);
  for (const std::string& file : files) plugins.load(file);
}

int run_program(int argument_count, char** arguments) {
  install_signal_handlers();
  Plugins plugins;
  BackendRegistry open_backends = with_warnings(plugins.backends(), report_warning);
  CommandContext context{plugins, open_backends, open_backends};
  CommandLine program("Out-of-core subdivision surfaces: semi-regular meshes in a paged store",
                      "plait");
  program.version(std::string("plait ") + PLAIT_VERSION);
  program.require_subcommand();
  program.help_column(30);
  program.footer(kFooter);
  add_generate_command(program, context);
  add_subdivide_command(program, context);
  add_plan_command(program, context);
  add_part_command(program, context);
  add_join_command(program, context);
  add_status_command(program, context);
  add_import_command(program, context);
  add_check_command(program, context);
  add_remesh_command(program, context);
  add_compare_command(program, context);
  add_info_command(program, context);
  add_verify_command(program, context);
  add_repair_command(program, context);
  add_digest_command(program, context);
  add_bounds_command(program, context);
  add_export_command(program, context);
  add_convert_command(program, context);
  add_prune_command(program, context);
  add_publish_command(program, context);
  add_serve_command(program, context);
  add_pass_commands(program, context);
  add_layout_command(program, context);
  add_render_command(program, context);
  add_paper_command(program, context);
  add_tune_command(program, context);
  add_clean_command(program, context);
  add_bench_command(program, context);

  const bool json = asks_for_json(argument_count, arguments);
  try {
    try {
      require_known_command(program, argument_count, arguments);
      if (program.parse(argument_count, arguments) == CommandLine::Outcome::kAnswered) {
        print(program.answer());
        flush_output();
        return kExitDone;
      }
    } catch (const UsageError& error) {
      return refuse_usage(program, error, json);
    }
    if (uses_plugins(program)) {
      load_plugins(plugins, context.plugin_files);
      open_backends = with_warnings(plugins.backends(), report_warning);
    }
    const int status = context.run();
    flush_output();
    return status;
  } catch (const Error& error) {
    return fail(error, json);
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(system_error(error.what(), error.path1().native(), error.code().value()), json);
  } catch (const std::bad_alloc&) {
    return fail(out_of_memory("plait"), json);
  } catch (const std::exception& error) {
    report_error("internal", error.what(), json);
    return kExitFailed;
  }
}

}  // namespace
}  // namespace plait

int main(int argument_count, char** arguments) {
  try {
    return plait::run_program(argument_count, arguments);
  } catch (...) {
    return plait::kExitFailed;  // only if there was no memory to report the error
  }
}
