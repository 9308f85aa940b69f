// tools/command.h: the commands of the program. Each is in command_NAME.cpp and adds itself to the
// parser. Parsing only stores a function to run, so that usage errors come before any work.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "command_line/command_line.h"
#include "plait/extend/plugins.h"

namespace plait {

struct CommandContext {
  const Plugins& plugins;  ///< those that the user has named; complete when `run` is called
  const BackendRegistry& backends;             ///< plugins.backends(), with_warnings()
  const BackendRegistry& open_backends;        ///< the same
  std::vector<std::string> plugin_files = {};  ///< --plugin
  bool json = false;  ///< --json: standard output gets one JSON object and nothing else
  std::function<int()> run = nullptr;  ///< set by the parsed command; returns the exit status
};

void add_generate_command(CommandLine& program, CommandContext& context);
void add_subdivide_command(CommandLine& program, CommandContext& context);
void add_import_command(CommandLine& program, CommandContext& context);
void add_info_command(CommandLine& program, CommandContext& context);
void add_verify_command(CommandLine& program, CommandContext& context);
void add_repair_command(CommandLine& program, CommandContext& context);
void add_digest_command(CommandLine& program, CommandContext& context);
void add_bench_command(CommandLine& program, CommandContext& context);
void add_bounds_command(CommandLine& program, CommandContext& context);
void add_export_command(CommandLine& program, CommandContext& context);
void add_check_command(CommandLine& program, CommandContext& context);
void add_clean_command(CommandLine& program, CommandContext& context);
void add_compare_command(CommandLine& program, CommandContext& context);
void add_convert_command(CommandLine& program, CommandContext& context);
void add_prune_command(CommandLine& program, CommandContext& context);
/// pass, and displace, which is pass under another name.
void add_pass_commands(CommandLine& program, CommandContext& context);
void add_join_command(CommandLine& program, CommandContext& context);
void add_status_command(CommandLine& program, CommandContext& context);
void add_layout_command(CommandLine& program, CommandContext& context);
void add_paper_command(CommandLine& program, CommandContext& context);
void add_part_command(CommandLine& program, CommandContext& context);
void add_plan_command(CommandLine& program, CommandContext& context);
void add_publish_command(CommandLine& program, CommandContext& context);
void add_remesh_command(CommandLine& program, CommandContext& context);
void add_render_command(CommandLine& program, CommandContext& context);
void add_serve_command(CommandLine& program, CommandContext& context);
void add_tune_command(CommandLine& program, CommandContext& context);

}  // namespace plait
