// plait convert: the same content in another backend, codec, filter or block size.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "measure.h"
#include "partial_output.h"
#include "plait/convert.h"
#include "plait/digest.h"
#include "plait/store.h"
#include "progress.h"

namespace plait {
namespace {

struct Arguments {
  std::filesystem::path from, to;
  std::string backend, codec, filter;  ///< empty: as the source has it
  std::uint64_t block_bytes = 0;       ///< 0: as the source has it
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  int threads = default_thread_count();
  bool no_digest = false, force = false;
};

StoreOptions target_options(const Arguments& arguments, const Store& source,
                            const BackendRegistry& backends) {
  StoreOptions options = source.options();
  if (!arguments.backend.empty()) options.backend = arguments.backend;
  const BackendRegistry::Entry& backend = backends.find(options.backend);
  if (!backend.traits.durable)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert: backend {} keeps nothing", backend.name));
  if (!backend.traits.compressed && !(arguments.codec.empty() && arguments.filter.empty()))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert: --codec and --filter need a backend that compresses, and {} "
                            "does not",
                            backend.name));
  if (!source.backend_traits().compressed) options.backend_options = BackendOptions();
  if (!arguments.codec.empty()) options.backend_options.codec = arguments.codec;
  if (!arguments.filter.empty()) options.backend_options.filter = arguments.filter;
  backend.validate(options.backend_options);
  if (arguments.block_bytes != 0) options.block_bytes = arguments.block_bytes;
  options.budget_bytes = arguments.memory_bytes / 2;
  options.durability = Durability::kCommit;
  return options;
}

Digest digest_of(Store& store, const char* task, int threads) {
  Progress progress(task, ProgressUnit::kNone);
  DigestOptions options;
  options.threads = threads;
  options.proceed = [&](std::uint64_t done, std::uint64_t total) {
    return progress.update(done, total);
  };
  return digest(store, options);
}

/// Errors: kCorruption if the copy is not what the source is.
std::string checked_digest(Store& source, Store& copy, int threads) {
  const Digest expected = digest_of(source, "digest of the source", threads);
  const Digest found = digest_of(copy, "digest of the copy", threads);
  if (expected != found)
    throw Error(ErrorCode::kCorruption,
                fmt::format("convert {}: digest of the copy {}, expected {}",
                            source.path().native(), found.to_string(), expected.to_string()));
  return found.to_string();
}

int run(const Arguments& arguments, const CommandContext& context) {
  Stopwatch clock;
  OpenOptions open;
  // The two stores share what --memory gives.
  open.budget_bytes = arguments.memory_bytes / 2;
  Store source = Store::open(arguments.from, open, context.backends);
  const StoreOptions options = target_options(arguments, source, context.backends);
  PartialOutput output(arguments.to, arguments.force ? Existing::kReplaceStore : Existing::kRefuse);
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.from, output.final_path(), ignored))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert {}: source and copy are the same", arguments.from.native()));
  if (arguments.force) require_replaceable_store(output.final_path(), context.backends);

  const std::uint64_t from_bytes = source.stored_bytes();
  std::uint64_t to_bytes = 0;
  std::string word;
  {
    Store copy = Store::create(output.path(), source.base(), options, context.backends);
    {
      Progress progress("convert", ProgressUnit::kBytes);
      copy_levels(source, copy, [&](std::uint64_t done, std::uint64_t total) {
        return progress.update(done, total);
      });
    }
    copy.commit();
    to_bytes = copy.stored_bytes();
    if (!arguments.no_digest) word = checked_digest(source, copy, arguments.threads);
    copy.close();
  }
  throw_if_interrupted();
  output.publish(true);

  const double ratio = static_cast<double>(from_bytes) / static_cast<double>(to_bytes);
  if (!context.json) {
    print(fmt::format("{}: {} by backend {}, was {} by {} ({:.2f} to 1), {:.2f} s\n",
                      output.final_path().native(), format_bytes(to_bytes), options.backend,
                      format_bytes(from_bytes), source.options().backend, ratio, clock.seconds()));
    if (!word.empty()) print(fmt::format("digest {}, equal to the source's\n", word));
    return kExitDone;
  }
  nlohmann::ordered_json report = {{"from", arguments.from.string()},
                                   {"store", output.final_path().string()},
                                   {"backend", options.backend},
                                   {"block_bytes", options.block_bytes},
                                   {"from_stored_bytes", from_bytes},
                                   {"stored_bytes", to_bytes},
                                   {"ratio", ratio},
                                   {"seconds", clock.seconds()}};
  if (!word.empty()) report["digest"] = word;
  print(report.dump(2) + "\n");
  return kExitDone;
}

}  // namespace

void add_convert_command(CLI::App& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand(
      "convert", "Copy a store into another backend, codec, filter or block size");
  command->add_option("STORE", arguments->from, "The store to copy")->required();
  command->add_option("OUT", arguments->to, "The store to make")->required();
  command->add_option("--backend", arguments->backend, "What keeps the copy (see below)");
  command->add_option("--codec", arguments->codec, "none, lz4, zstd or zstd:LEVEL");
  command->add_option("--filter", arguments->filter, "none or shuffle");
  add_size_option(*command, "--block", arguments->block_bytes, "Unit of I/O, a power of two")
      ->default_str("as in STORE");
  add_size_option(*command, "--memory", arguments->memory_bytes,
                  "Budget for blocks in memory, half of it for each store");
  command->add_option("--threads", arguments->threads, "Threads of the digests")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--no-digest", arguments->no_digest,
                    "Do not compare the digests of source and copy");
  command->add_flag("--force", arguments->force,
                    "Replace OUT if it is a store; the old one goes when the new one is whole");
  add_json_option(*command, context);
  command->footer(backend_help(context.backends) +
                  "\n"
                  "What is not given stays as it is in STORE.\n"
                  "\n"
                  "Examples:\n"
                  "  plait convert surface.plait small.plait --backend compressed --codec zstd:9\n"
                  "  plait convert small.plait fast.plait --backend mmap --block 256KiB");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run(*arguments, context); };
  });
}

}  // namespace plait
