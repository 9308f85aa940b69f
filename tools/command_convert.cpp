// plait convert: copies a store into another backend, compression or block size.

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/byte_text.h"
#include "command.h"
#include "compress_arguments.h"
#include "console.h"
#include "conversion/conversion_job.h"
#include "copy_arguments.h"
#include "interrupt.h"
#include "json_text.h"
#include "made_blocks.h"
#include "measure.h"
#include "plait/extend/rounding.h"
#include "plait/store.h"
#include "progress.h"
#include "rounding_report.h"

namespace plait {
namespace {

struct ConvertArguments : CopyArguments {
  bool verify = false;
  std::vector<std::string> max_errors;
  ErrorBounds bounds;  ///< of max_errors
};

ConversionRequest request_of(const ConvertArguments& arguments, const BackendRegistry& backends) {
  choices_of(arguments, "convert", backends);
  ConversionRequest request;
  request.from = arguments.from;
  request.to = arguments.to;
  request.backend = arguments.backend;
  request.compression = compression_of(arguments.compress);
  request.max_errors = arguments.bounds;
  request.block_bytes = arguments.block_bytes;
  request.budget_bytes = arguments.memory_bytes;
  request.threads = arguments.threads;
  request.verify = arguments.verify;
  request.replace = arguments.force;
  return request;
}

/// Draws a progress bar for each step, and lets a signal cancel the job.
ConversionResult run_job(const ConvertArguments& arguments, const CommandContext& context) {
  std::optional<ProgressBar> bar;
  ConversionWatch watch;
  watch.step = [&](ConversionStep step) {
    bar.emplace(std::string(to_string(step)),
                step == ConversionStep::kCopy ? ProgressUnit::kBytes : ProgressUnit::kNone);
  };
  watch.progress = [&](const Progress& now) { return bar->update(now.done, now.total, now.phase); };
  watch.warn = [&](const std::string& warning) {
    if (bar) bar->clear();
    report_warning(warning);
  };
  watch.before_publish = [&] {
    bar.reset();
    throw_if_interrupted();
  };
  return convert(request_of(arguments, context.backends), context.open_backends, context.backends,
                 watch);
}

/// What the finished copy makes again when it is read.
std::string made_blocks_of(const std::filesystem::path& path, const BackendRegistry& backends) {
  const Store store = Store::open(path, {}, backends);
  std::string text;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    text += made_blocks_text(store, id);
  return text;
}

int run_convert(const ConvertArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  const ConversionResult done = run_job(arguments, context);
  const double seconds = clock.seconds();
  const double ratio =
      static_cast<double>(done.from_stored_bytes) / static_cast<double>(done.stored_bytes);
  if (!context.json) {
    print(fmt::format("{}: {} by backend {} ({}), was {} by {} ({:.2f} to 1), {:.2f} s\n",
                      done.store.native(), format_bytes(done.stored_bytes), done.options.backend,
                      done.backend_reason, format_bytes(done.from_stored_bytes), done.from_backend,
                      ratio, seconds) +
          made_blocks_of(done.store, context.backends));
    for (const auto& [name, rounding] : done.roundings)
      print(fmt::format("{}: {}\n", name, to_text(rounding)));
    if (!done.digest.empty())
      print(fmt::format("read back: digest {}, {}\n", done.digest,
                        done.roundings.empty() ? "equal to that of the source"
                                               : "every record within its bound of the source"));
    return kExitDone;
  }
  nlohmann::ordered_json report = {{"from", arguments.from.string()},
                                   {"store", done.store.string()},
                                   {"backend", done.options.backend},
                                   {"backend_reason", done.backend_reason},
                                   {"block_bytes", done.options.block_bytes},
                                   {"from_stored_bytes", done.from_stored_bytes},
                                   {"stored_bytes", done.stored_bytes},
                                   {"ratio", ratio},
                                   {"seconds", seconds}};
  for (const auto& [name, rounding] : done.roundings) report["max_error"][name] = to_json(rounding);
  if (!done.digest.empty()) report["digest"] = done.digest;
  print(json_text(report));
  return kExitDone;
}

}  // namespace

void add_convert_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<ConvertArguments>();
  CommandLine* command = program.add_subcommand(
      "convert", "Copy a store into another backend, compression or block size");
  add_copy_options(*command, context, *arguments, "Threads of --verify");
  add_max_error_option(*command, arguments->max_errors);
  command->add_flag("--verify", arguments->verify,
                    "Read the copy back from the disk and compare it with STORE");
  command->footer(
      backend_help(context.backends) + compression_help() +
      "\n"
      "The copy is like STORE in everything that no option changes.\n"
      "\n"
      "The presets default and small make normals again from the positions, instead of storing\n"
      "them, wherever that gives the same bits: plait info counts such blocks as predicted.\n"
      "\n" +
      max_error_help() +
      " --verify then compares\n"
      "every record with STORE. --max-error implies --compress default.\n"
      "\n"
      "Examples:\n"
      "  plait convert surface.plait small.plait --compress small\n"
      "  plait convert surface.plait mixed.plait --compress default --compress @5-=fast\n"
      "  plait convert surface.plait lossy.plait --max-error 1e-6rel --max-error normal=1e-3\n"
      "  plait convert small.plait fast.plait --backend mmap --block 256KiB --verify");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] {
      for (const std::string& text : arguments->max_errors) arguments->bounds.add(text);
      return run_convert(*arguments, context);
    };
  });
}

}  // namespace plait
